// What one frame asks of the strand solvers, and what they show. Twin of `Frame` in sim/src/clock.rs.
#define_import_path lorelei::sim_frame

#import lorelei::sim_pose::{Pose, pose_apply}
#import lorelei::sim_pull::Pull

struct FrameParams {
    n_guides: u32,
    n_vertices: u32,
    n_steps: u32,
    // How far the picture is past the last step, in steps.
    ahead: f32,
    // 1: move everything by `carry` first.
    carried: u32,
    carry: Pose,
    // The head as the picture shows it.
    shown: Pose,
    pull: Pull,
    // The head before the first step, then after each.
    poses: array<Pose, 65>,
    // What takes each to the next.
    carries: array<Pose, 64>,
}

@group(0) @binding(auto) var<uniform> asked: FrameParams;
// What the picture shows: vertex k of guide g at g * n_vertices + k.
@group(0) @binding(auto) var<storage, read_write> positions: array<vec4<f32>>;

// Vertices at the root that follow the head.
const N_PINNED: u32 = 2u;
// cm/s.
const MAX_SPEED: f32 = 3000.0;

// Where the picture shows vertex `k`, up to a step ahead of the last step; `place` is where it rests on the head.
fn shown_at(k: u32, place: vec3<f32>, x: vec3<f32>, begun: vec3<f32>) -> vec4<f32> {
    if k < N_PINNED {
        return vec4<f32>(pose_apply(asked.shown, place), 0.0);
    }
    return vec4<f32>(x + asked.ahead * (x - begun), 0.0);
}

fn clamp_length(v: vec3<f32>, largest: f32) -> vec3<f32> {
    let squared = dot(v, v);
    if squared > largest * largest {
        return v * (largest * inverseSqrt(squared));
    }
    return v;
}
