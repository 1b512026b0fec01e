// Strand dynamics: the twin of sim/src/strand.rs, function by function. That file says why each step is as it is.
//
// One thread takes one strand through all of a frame's steps. A thread for every vertex, with workgroup memory and
// barriers between the batches, was rejected: sim/src/gpu.rs says why.

#import lorelei::sim_pose::{Pose, rotate, multiply, pose_apply, pose_apply_inverse, after_inverse_of, shortest_turn, normalize_or_zero}
#import lorelei::sim_contact::{contact_collide, contact_keep_out, contact_step}
#import lorelei::sim_air::air_velocity

struct StepParams {
    // Displacement by gravity in a step, cm.
    gravity_step: vec3<f32>,
    // Share of the velocity relative to the head that a step keeps.
    keep: f32,
    // Share of the air's velocity that a step takes up.
    take_up: f32,
    bend: f32,
    hold: f32,
    hold_length: f32,
    max_displacement: f32,
    n_iterations: u32,
    step_secs: f32,
    // Share of the difference to each neighbour's velocity that a step takes away.
    rub: f32,
}

struct Params {
    step: StepParams,
    n_guides: u32,
    n_vertices: u32,
    n_steps: u32,
    // How far the picture is past the last step, in steps.
    ahead: f32,
    // 1: move everything by `carry` first.
    carried: u32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    carry: Pose,
    // The head as the picture shows it.
    shown: Pose,
    // The head before the first step, then after each.
    poses: array<Pose, 65>,
}

@group(0) @binding(auto) var<uniform> params: Params;
// xyz head space, w the distance from the obstacles at rest. Vertex k of guide g at g * n_vertices + k.
@group(0) @binding(auto) var<storage, read> rest: array<vec4<f32>>;
// xyz world now, w scratch of solve_lengths.
@group(0) @binding(auto) var<storage, read_write> present: array<vec4<f32>>;
// xyz world one step ago, w scratch of solve_lengths.
@group(0) @binding(auto) var<storage, read_write> before_that: array<vec4<f32>>;
// Where the last step began: what before_that is, were it not moved by contacts and lengths.
@group(0) @binding(auto) var<storage, read_write> begun: array<vec4<f32>>;
// What the picture shows.
@group(0) @binding(auto) var<storage, read_write> positions: array<vec4<f32>>;

const N_PINNED = 2u;
const MIN_EDGE = 0.05;
const SMOOTHING = 3.0;
const HOLD_ENDS = 7.0;
const SHELTER = 4.0;
const CLOSINGS = 3u;
const REACHES = 8u;
const HELD = 1.2;

// First vertex of this thread's strand.
var<private> base: u32;

fn rest_at(k: u32) -> vec3<f32> {
    return rest[base + k].xyz;
}

fn x_at(k: u32) -> vec3<f32> {
    return present[base + k].xyz;
}

fn prev_at(k: u32) -> vec3<f32> {
    return before_that[base + k].xyz;
}

fn set_x(k: u32, p: vec3<f32>) {
    present[base + k] = vec4<f32>(p, present[base + k].w);
}

fn set_prev(k: u32, p: vec3<f32>) {
    before_that[base + k] = vec4<f32>(p, before_that[base + k].w);
}

// Inverse mass: nothing moves a pinned vertex.
fn weight(k: u32) -> f32 {
    return select(1.0, 0.0, k < N_PINNED);
}

fn clamp_length(v: vec3<f32>, largest: f32) -> vec3<f32> {
    let l = length(v);
    if l > largest {
        return v * (largest / l);
    }
    return v;
}

// Verlet's rule. Pinned vertices go with the head.
fn integrate(before: Pose, after: Pose) {
    let n = params.n_vertices;
    let carry = after_inverse_of(after, before);
    let gravity_step = params.step.gravity_step;
    let tilt = gravity_step - rotate(before.rotation, gravity_step);
    var from_root = 0.0;
    var own_below = vec3<f32>(0.0);
    var own = vec3<f32>(0.0);
    for (var k = 0u; k < n; k++) {
        let x = x_at(k);
        // Compute the next vertex's velocity relative to the head, before it is moved.
        var own_above = own;
        if k + 1u < n && k + 1u >= N_PINNED {
            let above = x_at(k + 1u);
            own_above = above - prev_at(k + 1u) - (pose_apply(carry, above) - above);
        }
        set_prev(k, x);
        if k > 0u {
            from_root += distance(rest_at(k), rest_at(k - 1u));
        }
        if k < N_PINNED {
            set_x(k, pose_apply(after, rest_at(k)));
        } else {
            // Level the velocity out with the neighbours', lose some of it to the head and to the air.
            let levelled = own + params.step.rub * (own_below + own_above - 2.0 * own);
            var v = pose_apply(carry, x) - x + params.step.keep * levelled;
            let exposed = from_root / (from_root + SHELTER);
            v += params.step.take_up * (exposed * params.step.step_secs * air_velocity(x) - v);
            let aside = x - pose_apply(before, rest_at(k));
            let swing = sqrt(from_root * from_root + dot(aside, aside));
            let pendulum = -aside * (length(gravity_step) / max(swing, MIN_EDGE));
            set_x(k, x + clamp_length(v, params.step.max_displacement) + tilt + pendulum);
        }
        own_below = own;
        own = own_above;
    }
}

// One Newton step on all lengths: the tridiagonal system of their multipliers, by Thomas's algorithm.
fn solve_lengths() {
    let n = params.n_vertices;
    var normal_below = vec3<f32>(0.0);
    var c = 0.0;
    var d = 0.0;
    for (var k = N_PINNED; k < n; k++) {
        let edge = x_at(k) - x_at(k - 1u);
        let normal = normalize_or_zero(edge);
        let error = length(edge) - distance(rest_at(k), rest_at(k - 1u));
        let w_below = select(0.0, 1.0, k > N_PINNED);
        let a = -w_below * dot(normal_below, normal);
        var above = vec3<f32>(0.0);
        if k + 1u < n {
            above = normalize_or_zero(x_at(k + 1u) - x_at(k));
        }
        let pivot = 1.0 + w_below - a * c;
        d = (error - a * d) / pivot;
        c = -dot(normal, above) / pivot;
        present[base + k].w = c;
        before_that[base + k].w = d;
        normal_below = normal;
    }
    var above = vec3<f32>(0.0);
    var multiplier_above = 0.0;
    for (var k = n - 1u; k >= N_PINNED; k--) {
        let normal = normalize_or_zero(x_at(k) - x_at(k - 1u));
        let multiplier = before_that[base + k].w - present[base + k].w * multiplier_above;
        set_x(k, x_at(k) - multiplier * normal + multiplier_above * above);
        above = normal;
        multiplier_above = multiplier;
    }
}

// Bend every joint towards its angle at rest, in the frame carried from the root.
fn bend(after: Pose) {
    let n = params.n_vertices;
    var frame = after.rotation;
    var smooth_edge = x_at(1u) - x_at(0u);
    var rest_smooth = rest_at(1u) - rest_at(0u);
    var h_below = length(rest_smooth);
    for (var k = 1u; k + 1u < n; k++) {
        let rest_edge = rest_at(k + 1u) - rest_at(k);
        let h_above = length(rest_edge);
        let deviation = x_at(k + 1u) - x_at(k) - rotate(frame, rest_edge);
        let h = max(0.5 * (h_below + h_above), MIN_EDGE);
        let stiffness = params.step.bend / (h * h * h * h);
        let w_joint = weight(k);
        let share = stiffness / (1.0 + stiffness * (1.0 + w_joint));
        let top = x_at(k + 1u) - share * deviation;
        let joint = x_at(k) + w_joint * share * deviation;
        set_x(k + 1u, top);
        set_x(k, joint);
        let blend = h_above / (h_above + SMOOTHING);
        smooth_edge += blend * (top - joint - smooth_edge);
        rest_smooth += blend * (rest_edge - rest_smooth);
        frame = multiply(shortest_turn(rotate(frame, rest_smooth), smooth_edge), frame);
        h_below = h_above;
    }
}

// Spring back towards the style, strongest at the root.
fn hold(after: Pose) {
    var from_root = distance(rest_at(1u), rest_at(0u));
    for (var k = N_PINNED; k < params.n_vertices; k++) {
        from_root += distance(rest_at(k), rest_at(k - 1u));
        if from_root > HOLD_ENDS * params.step.hold_length {
            break;
        }
        let stiffness = params.step.hold * exp(-from_root / params.step.hold_length);
        let x = x_at(k);
        set_x(k, x + (pose_apply(after, rest_at(k)) - x) * (stiffness / (1.0 + stiffness)));
    }
}

// Lengths of every second edge: the edges of one batch share no vertex.
fn length_batch(batch: u32) {
    for (var k = N_PINNED + batch; k < params.n_vertices; k += 2u) {
        let edge = x_at(k) - x_at(k - 1u);
        let error = length(edge) - distance(rest_at(k), rest_at(k - 1u));
        let w_below = weight(k - 1u);
        let correction = normalize_or_zero(edge) * (error / (1.0 + w_below));
        let below = x_at(k - 1u) + w_below * correction;
        let x = x_at(k) - correction;
        set_x(k - 1u, below);
        set_x(k, x);
    }
}

// Keep vertices out of the head and the colliders.
fn collide(before: Pose, after: Pose) {
    for (var k = N_PINNED; k < params.n_vertices; k++) {
        let along = f32(k) / f32(params.n_vertices - 1u);
        let contact = contact_collide(x_at(k), prev_at(k), rest[base + k].w, along, before, after);
        set_x(k, contact.x);
        set_prev(k, contact.prev);
    }
}

// Put every vertex at its exact distance from the one below and out of all obstacles.
fn close_lengths(after: Pose) {
    for (var reach = 0u; reach <= REACHES; reach++) {
        if !reach_from_root(after, reach < REACHES) {
            return;
        }
        reach_from_tip(after);
    }
}

// From the root up, without giving velocity; true where a vertex was held back and may be, its edge too long.
fn reach_from_root(after: Pose, may_hold: bool) -> bool {
    var is_held = false;
    for (var k = N_PINNED; k < params.n_vertices; k++) {
        let below = x_at(k - 1u);
        let rest_edge = rest_at(k) - rest_at(k - 1u);
        let along = f32(k) / f32(params.n_vertices - 1u);
        let start = x_at(k);
        var x = at_length(below, start, rest_edge, after);
        for (var i = 0u; i < CLOSINGS; i++) {
            let kept = contact_keep_out(start, x, rest[base + k].w, along, after);
            if all(kept == x) {
                break;
            }
            x = at_length(below, kept, rest_edge, after);
            if may_hold && distance(kept, below) > HELD * length(rest_edge) {
                is_held = true;
                x = kept;
                break;
            }
        }
        set_x(k, x);
        set_prev(k, prev_at(k) + (x - start));
    }
    return is_held;
}

// From the tip down, edges that are too long; it takes the velocity that made them so.
fn reach_from_tip(after: Pose) {
    for (var k = params.n_vertices - 2u; k >= N_PINNED; k--) {
        let rest_edge = rest_at(k + 1u) - rest_at(k);
        let along = f32(k) / f32(params.n_vertices - 1u);
        let x = x_at(k);
        let above = x_at(k + 1u);
        if distance(x, above) > 1.001 * length(rest_edge) {
            let pulled = at_length(above, x, rest_edge, after);
            set_x(k, contact_keep_out(x, pulled, rest[base + k].w, along, after));
        }
    }
}

// The place in the direction of `x` that is as far from `below` as at rest.
fn at_length(below: vec3<f32>, x: vec3<f32>, rest_edge: vec3<f32>, after: Pose) -> vec3<f32> {
    let edge = x - below;
    let l = length(edge);
    var correction = rotate(after.rotation, rest_edge);
    if l > 1e-6 {
        correction = edge * ((length(rest_edge) - l) / l);
    }
    return x + correction;
}

// A strand that is not finite starts again from rest.
fn recover(after: Pose) {
    var sum = 0.0;
    for (var k = 0u; k < params.n_vertices; k++) {
        let d = abs(x_at(k) - prev_at(k));
        sum += d.x + d.y + d.z;
    }
    if sum < 1e15 {
        return;
    }
    for (var k = 0u; k < params.n_vertices; k++) {
        let x = pose_apply(after, rest_at(k));
        set_x(k, x);
        set_prev(k, x);
    }
}

// One step: the head goes from `before` to `after`.
fn step_strand(before: Pose, after: Pose) {
    integrate(before, after);
    solve_lengths();
    for (var iteration = 0u; iteration < params.step.n_iterations; iteration++) {
        bend(after);
        hold(after);
        length_batch(0u);
        length_batch(1u);
        collide(before, after);
    }
    close_lengths(after);
    recover(after);
}

// All of a frame's steps for one strand. Twin of run_strand in sim/src/cpu.rs.
@compute @workgroup_size(32)
fn advance(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let guide_idx = id.x + id.y * n_groups.x * 32u;
    if guide_idx >= params.n_guides {
        return;
    }
    base = guide_idx * params.n_vertices;
    if params.carried == 1u {
        for (var k = 0u; k < params.n_vertices; k++) {
            set_x(k, pose_apply(params.carry, x_at(k)));
            set_prev(k, pose_apply(params.carry, prev_at(k)));
            begun[base + k] = vec4<f32>(pose_apply(params.carry, begun[base + k].xyz), 0.0);
        }
    }
    for (var i = 0u; i < params.n_steps; i++) {
        if i + 1u == params.n_steps {
            for (var k = 0u; k < params.n_vertices; k++) {
                begun[base + k] = present[base + k];
            }
        }
        contact_step(i, params.n_steps);
        step_strand(params.poses[i], params.poses[i + 1u]);
    }
    for (var k = 0u; k < params.n_vertices; k++) {
        let x = x_at(k);
        var ahead = x + params.ahead * (x - begun[base + k].xyz);
        if k < N_PINNED {
            ahead = pose_apply(params.shown, rest_at(k));
        }
        positions[base + k] = vec4<f32>(ahead, 0.0);
    }
}
