// A hand that holds hair while it moves. Twin of sim/src/pull.rs, which says why it is as it is.
#define_import_path lorelei::sim_pull

#import lorelei::sim_pose::{Pose, rotate}

struct Pull {
    // xyz where the held vertex rests, head space; w how far around it hair follows, cm.
    rest: vec4<f32>,
    // xyz where the hand is, world; w how strongly it pulls a whole strand, 1/s2: 0 while it is open.
    hand: vec4<f32>,
    // Where along its strand the held vertex is, 0 root to 1 tip.
    along: f32,
}

const FARTHEST: f32 = 5.0;

// How vertex `k`, which rests at `place` and is at `x`, is pulled: xyz which way and how far, w how strongly, 1/s2.
fn pull_on(pull: Pull, k: u32, n_vertices: u32, place: vec3<f32>, x: vec3<f32>, after: Pose) -> vec4<f32> {
    if pull.hand.w == 0.0 || k != u32(pull.along * f32(n_vertices - 1u) + 0.5) {
        return vec4<f32>(0.0);
    }
    let aside = place - pull.rest.xyz;
    let falloff = 1.0 - dot(aside, aside) / (pull.rest.w * pull.rest.w);
    if falloff <= 0.0 {
        return vec4<f32>(0.0);
    }
    let way = pull.hand.xyz + rotate(after.rotation, aside) - x;
    let strength = pull.hand.w * falloff * falloff * f32(n_vertices - 1u);
    return vec4<f32>(way * min(FARTHEST / max(length(way), 1e-9), 1.0), strength);
}
