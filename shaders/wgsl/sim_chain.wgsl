// Chains: the twin of sim/src/chain.rs, function by function.
//
// A workgroup takes a strand and a thread a vertex, as the references do; places are shared in workgroup memory, and all
// of a frame's steps are one dispatch.

#import lorelei::sim_pose::{Pose, rotate, pose_apply, after_inverse_of, shortest_turn, normalize_or_zero}
#import lorelei::sim_frame::{asked, positions, shown_at, clamp_length, N_PINNED, MAX_SPEED}
#import lorelei::sim_contact::{contact_collide, contact_step}
#import lorelei::sim_air::air_velocity

struct ChainParams {
    gravity_step: vec3<f32>,
    step_secs: f32,
    keep: f32,
    take_up: f32,
    shape: f32,
    n_iterations: u32,
}

struct ChainRest {
    // xyz head space, w the distance from the obstacles at rest.
    place: vec4<f32>,
    // Hold to the style over mass; share of the wind.
    numbers: vec4<f32>,
}

struct ChainVertex {
    x: vec4<f32>,
    // A step ago; a contact moves it where it takes velocity.
    prev: vec4<f32>,
    // Where the last step began.
    begun: vec4<f32>,
}

// Most vertices of a strand: guides have no more.
const MOST: u32 = 64u;

@group(0) @binding(auto) var<storage, read> chain: ChainParams;
@group(0) @binding(auto) var<storage, read> rest: array<ChainRest>;
@group(0) @binding(auto) var<storage, read_write> s: array<ChainVertex>;

// Places of the strand's vertices now.
var<workgroup> x_of: array<vec3<f32>, MOST>;
// Lengths of the edges below them.
var<workgroup> length_of: array<f32, MOST>;
var<workgroup> is_broken: atomic<u32>;

// Verlet's rule for one vertex: where it goes from `x`.
fn integrate(k: u32, x: vec3<f32>, prev: vec3<f32>, at: ChainRest, before: Pose, after: Pose) -> vec3<f32> {
    let styled = pose_apply(after, at.place.xyz);
    if k < N_PINNED {
        return styled;
    }
    let carry = after_inverse_of(after, before);
    let with_head = pose_apply(carry, x) - x;
    var v = with_head + chain.keep * (x - prev - with_head);
    v += chain.take_up * (at.numbers.y * chain.step_secs * air_velocity(x) - v);
    let moved = x + clamp_length(v, MAX_SPEED * chain.step_secs) + chain.gravity_step;
    let stiffness = at.numbers.x * chain.step_secs * chain.step_secs;
    return moved + (styled - moved) * (stiffness / (1.0 + stiffness));
}

// Lengths of every second edge: the thread of an edge's upper vertex moves both of its ends.
fn lengths(k: u32, is_here: bool, batch: u32) {
    if is_here && k >= N_PINNED + batch && (k - N_PINNED - batch) % 2u == 0u {
        let edge = x_of[k] - x_of[k - 1u];
        let error = length(edge) - length_of[k];
        let w_below = select(1.0, 0.0, k - 1u < N_PINNED);
        let correction = normalize_or_zero(edge) * (error / (1.0 + w_below));
        x_of[k - 1u] += w_below * correction;
        x_of[k] -= correction;
    }
    workgroupBarrier();
}

// Towards the local shape, all at once from where the vertices were before.
fn angles(k: u32, is_here: bool, first: u32, after: Pose) {
    var moved = vec3<f32>(0.0);
    if is_here && k >= N_PINNED {
        let rest_below = rotate(after.rotation, rest[first + k - 1u].place.xyz - rest[first + k - 2u].place.xyz);
        let rest_edge = rotate(after.rotation, rest[first + k].place.xyz - rest[first + k - 1u].place.xyz);
        let joint = x_of[k - 1u];
        let goal = joint + rotate(shortest_turn(rest_below, joint - x_of[k - 2u]), rest_edge);
        moved = x_of[k] + chain.shape * (goal - x_of[k]);
    }
    workgroupBarrier();
    if is_here && k >= N_PINNED {
        x_of[k] = moved;
    }
    workgroupBarrier();
}

// All of a frame's steps for one strand. Twin of SimulatedLayer::run in sim/src/layer.rs.
@compute @workgroup_size(64)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) k: u32,
) {
    let guide_idx = group.x + group.y * n_groups.x;
    if guide_idx >= asked.n_guides {
        return;
    }
    let first = guide_idx * asked.n_vertices;
    let is_here = k < asked.n_vertices;
    let i = first + min(k, asked.n_vertices - 1u);
    let place = rest[i].place;
    var x = s[i].x.xyz;
    var prev = s[i].prev.xyz;
    var begun = s[i].begun.xyz;
    if asked.carried == 1u {
        x = pose_apply(asked.carry, x);
        prev = pose_apply(asked.carry, prev);
        begun = pose_apply(asked.carry, begun);
    }
    if is_here {
        length_of[k] = select(distance(place.xyz, rest[max(i, 1u) - 1u].place.xyz), 0.0, k == 0u);
    }
    workgroupBarrier();
    let along = f32(k) / f32(asked.n_vertices - 1u);
    for (var step = 0u; step < asked.n_steps; step++) {
        contact_step(step, asked.n_steps);
        let before = asked.poses[step];
        let after = asked.poses[step + 1u];
        begun = x;
        let moved = integrate(k, x, prev, rest[i], before, after);
        prev = x;
        if is_here {
            x_of[k] = moved;
        }
        if k == 0u {
            atomicStore(&is_broken, 0u);
        }
        workgroupBarrier();
        for (var iteration = 0u; iteration < chain.n_iterations; iteration++) {
            lengths(k, is_here, 0u);
            lengths(k, is_here, 1u);
            angles(k, is_here, first, after);
            if is_here && k >= N_PINNED {
                let contact = contact_collide(x_of[k], prev, place.w, along, before, after);
                x_of[k] = contact.x;
                prev = contact.prev;
            }
            workgroupBarrier();
        }
        if is_here {
            x = x_of[k];
            let d = abs(x - prev);
            // False for NaN and infinity too.
            if !(d.x + d.y + d.z < 1e13) {
                atomicStore(&is_broken, 1u);
            }
        }
        workgroupBarrier();
        // A strand that is not finite starts again from rest.
        if atomicLoad(&is_broken) == 1u {
            x = pose_apply(after, place.xyz);
            prev = x;
            begun = x;
        }
        workgroupBarrier();
    }
    if is_here {
        s[i] = ChainVertex(vec4<f32>(x, 0.0), vec4<f32>(prev, 0.0), vec4<f32>(begun, 0.0));
        positions[i] = shown_at(k, place.xyz, x, begun);
    }
}
