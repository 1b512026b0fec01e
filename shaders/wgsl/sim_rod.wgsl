// Rods: the twin of sim/src/rod.rs, function by function. That file says why each step is as it is.
//
// One thread takes one strand through all of a frame's steps: each sweep goes from one end to the other.

#import lorelei::sim_pose::{Pose, rotate, conjugate, multiply, pose_apply, after_inverse_of, shortest_turn}
#import lorelei::sim_frame::{asked, positions, shown_at, clamp_length, N_PINNED, MAX_SPEED}
#import lorelei::sim_contact::{contact_collide, contact_keep_out, contact_step}
#import lorelei::sim_air::air_velocity
#import lorelei::sim_pull::pull_on

struct RodParams {
    gravity: vec3<f32>,
    step_secs: f32,
    bend: f32,
    bend_damping: f32,
    damping: f32,
    damping_along: f32,
    drag: f32,
    n_iterations: u32,
}

struct RodRest {
    // xyz head space, w the distance from the obstacles at rest.
    place: vec4<f32>,
    // Frame of the edge above, head space.
    frame: vec4<f32>,
    // Rotation of the joint in which it has no moment.
    joint: vec4<f32>,
    // xyz what carries the vertex beside its own strand, head space; w length of the edge above.
    support: vec4<f32>,
    // Hold to the style over mass; share of the wind; lengths of hair whose mass and bending it stands for.
    numbers: vec4<f32>,
}

struct RodVertex {
    x: vec4<f32>,
    // A step ago; a contact moves it where it takes velocity.
    prev: vec4<f32>,
    // Where the last step began.
    begun: vec4<f32>,
    // Of the edge above, world.
    frame: vec4<f32>,
    // Over the last step.
    acceleration: vec4<f32>,
}

// What the sweep to the root leaves for the sweep to the tip: omega_k = gain omega_k-1 - turn - lever dx_k. The columns of
// lever with those of the symmetric gain's lower triangle, and turn with its last entry.
struct Eliminated {
    first: vec4<f32>,
    second: vec4<f32>,
    third: vec4<f32>,
    turn: vec4<f32>,
    lower: vec4<f32>,
}

@group(0) @binding(auto) var<storage, read> rod: RodParams;
@group(0) @binding(auto) var<storage, read> rest: array<RodRest>;
@group(0) @binding(auto) var<storage, read_write> s: array<RodVertex>;
@group(0) @binding(auto) var<storage, read_write> eliminated: array<Eliminated>;

const MIN_EDGE = 0.01;
const DRAG_ALONG = 0.5;
const MAX_TURN = 1.0;
const STILL = 2e-6;
const AT_REST = 2e-5;
const SPIN = 1e-3;
const REACHES = 8u;
const HELD = 1.2;
const EDGE = vec3<f32>(0.0, 0.0, 1.0);

// First vertex of this thread's strand.
var<private> base: u32;

fn at_rest(k: u32, pose: Pose) {
    let x = vec4<f32>(pose_apply(pose, rest[base + k].place.xyz), 0.0);
    let turned = normalize(multiply(pose.rotation, rest[base + k].frame));
    s[base + k] = RodVertex(x, x, x, turned, vec4<f32>(0.0));
}

// Move everything rigidly.
fn carry_strand(carry: Pose) {
    for (var k = 0u; k < asked.n_vertices; k++) {
        let i = base + k;
        s[i].x = vec4<f32>(pose_apply(carry, s[i].x.xyz), 0.0);
        s[i].prev = vec4<f32>(pose_apply(carry, s[i].prev.xyz), 0.0);
        s[i].begun = vec4<f32>(pose_apply(carry, s[i].begun.xyz), 0.0);
        s[i].frame = normalize(multiply(carry.rotation, s[i].frame));
    }
}

// Frame of an edge that goes rigidly with the head: what it has of its own is found against that.
fn carried_frame(k: u32, carry: Pose, after: Pose) -> vec4<f32> {
    if k == 0u {
        return normalize(multiply(after.rotation, rest[base].frame));
    }
    return normalize(multiply(carry.rotation, s[base + k].frame));
}

// `e x` each column.
fn cross_columns(e: vec3<f32>, m: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(cross(e, m[0]), cross(e, m[1]), cross(e, m[2]));
}

fn diagonal(d: f32) -> mat3x3<f32> {
    return mat3x3<f32>(vec3<f32>(d, 0.0, 0.0), vec3<f32>(0.0, d, 0.0), vec3<f32>(0.0, 0.0, d));
}

// `scale` times the outer product of `v` with itself.
fn outer(v: vec3<f32>, scale: f32) -> mat3x3<f32> {
    let scaled = scale * v;
    return mat3x3<f32>(scaled * v.x, scaled * v.y, scaled * v.z);
}

// By cofactors; `m` is positive definite.
fn inverse_symmetric(m: mat3x3<f32>) -> mat3x3<f32> {
    let yz = cross(m[1], m[2]);
    let scale = 1.0 / dot(m[0], yz);
    return transpose(mat3x3<f32>(scale * yz, scale * cross(m[2], m[0]), scale * cross(m[0], m[1])));
}

// Moment that a joint's deviation from its rest makes on the edge above it, world.
fn moment_of_joint(below: vec4<f32>, above: vec4<f32>, joint: vec4<f32>, stiff: f32) -> vec3<f32> {
    let deviation = multiply(conjugate(joint), multiply(conjugate(below), above));
    let shortest = select(1.0, -1.0, deviation.w < 0.0);
    return rotate(above, 2.0 * stiff * shortest * deviation.xyz);
}

// Eliminate every edge from tip to root.
fn sweep_to_root(before: Pose, after: Pose) {
    let h = rod.step_secs;
    let carry = after_inverse_of(after, before);
    var a = diagonal(0.0);
    var b = diagonal(0.0);
    var c = diagonal(0.0);
    var px = vec3<f32>(0.0);
    var pw = vec3<f32>(0.0);
    var load = vec3<f32>(0.0);
    var above = carried_frame(asked.n_vertices - 2u, carry, after);
    for (var k = asked.n_vertices - 2u; k >= 1u; k--) {
        let j = base + k + 1u;
        let edge_length = rest[base + k].support.w;
        let below = carried_frame(k - 1u, carry, after);
        let t = rotate(above, EDGE);
        let e = edge_length * t;
        // Compute what drives vertex j, relative to going rigidly with the head.
        let x = s[j].x.xyz;
        let carried = pose_apply(carry, x);
        let own = clamp_length(2.0 * x - s[j].prev.xyz - carried, MAX_SPEED * h);
        let stiffness = rest[j].numbers.x;
        let exposed = rest[j].numbers.y;
        let mass = rest[j].numbers.z;
        let to_style = pose_apply(after, rest[j].place.xyz) - carried;
        let pull = pull_on(asked.pull, k + 1u, asked.n_vertices, rest[j].place.xyz, carried, after);
        let held = rod.gravity + rotate(after.rotation, rest[j].support.xyz) + stiffness * to_style;
        let force = held + pull.w * pull.xyz;
        let blown = h * exposed * air_velocity(x) - (carried - x);
        let across = rod.damping + rod.drag;
        let along = rod.damping_along + DRAG_ALONG * rod.drag;
        let drag = rod.drag * (blown - (1.0 - DRAG_ALONG) * dot(t, blown) * t);
        let r = mass * (own + h * h * force + h * drag);
        let d = mass * (1.0 + h * (across + sqrt(pull.w)) + h * h * (stiffness + pull.w));
        a += diagonal(d) + outer(t, mass * h * (along - across));
        px -= r;
        load += mass * (force - s[j].acceleration.xyz);
        // Compute the inertia about vertex k, with dx_j = dx_k + omega x e.
        let ea = cross_columns(e, a);
        let eb = cross_columns(e, b);
        let b_below = b + transpose(ea);
        let tension = h * h * max(dot(load, e), 0.0);
        let long = max(edge_length, MIN_EDGE);
        let spin = SPIN * mass * long * long;
        let c_below = c + eb + transpose(eb) + cross_columns(e, transpose(ea)) + diagonal(tension + spin) - outer(t, tension);
        let pw_below = pw + cross(e, px);
        // Eliminate omega_k.
        let stiff = rod.bend / rest[base + k].numbers.w;
        let g = h * h * moment_of_joint(below, above, rest[base + k].joint, stiff);
        let beta = stiff * (h * h + h * rod.bend_damping);
        let inverse = inverse_symmetric(c_below + diagonal(beta));
        let turn = inverse * (pw_below + g);
        let lever = inverse * transpose(b_below);
        let gain = inverse * beta;
        eliminated[base + k].first = vec4<f32>(lever[0], gain[0].x);
        eliminated[base + k].second = vec4<f32>(lever[1], gain[1].y);
        eliminated[base + k].third = vec4<f32>(lever[2], gain[2].z);
        eliminated[base + k].turn = vec4<f32>(turn, 0.0);
        eliminated[base + k].lower = vec4<f32>(gain[0].y, gain[0].z, gain[1].z, 0.0);
        a -= b_below * lever;
        b = transpose(lever) * beta;
        c = inverse * c_below * beta;
        px -= b_below * turn;
        pw = beta * (inverse * pw_below) - inverse * (c_below * g);
        above = below;
    }
}

// Turn the edges from root to tip.
fn sweep_to_tip(before: Pose, after: Pose) {
    let h = rod.step_secs;
    let carry = after_inverse_of(after, before);
    var omega = vec3<f32>(0.0);
    var dx = vec3<f32>(0.0);
    var below = vec3<f32>(0.0);
    for (var k = 0u; k < N_PINNED; k++) {
        s[base + k].prev = s[base + k].x;
        below = pose_apply(after, rest[base + k].place.xyz);
        s[base + k].x = vec4<f32>(below, 0.0);
    }
    s[base].frame = normalize(multiply(after.rotation, rest[base].frame));
    for (var k = 1u; k + 1u < asked.n_vertices; k++) {
        let i = base + k;
        let edge_length = rest[i].support.w;
        var turned = carried_frame(k, carry, after);
        let at_root = eliminated[i];
        let lower = at_root.lower;
        let gained = vec3<f32>(at_root.first.w, at_root.second.w, at_root.third.w) * omega
            + vec3<f32>(dot(lower.xy, omega.yz), lower.x * omega.x + lower.z * omega.z, dot(lower.yz, omega.xy));
        let levered = at_root.first.xyz * dx.x + at_root.second.xyz * dx.y + at_root.third.xyz * dx.z;
        omega = clamp_length(gained - at_root.turn.xyz - levered, MAX_TURN);
        if dot(omega, omega) < STILL * STILL {
            omega = vec3<f32>(0.0);
        }
        dx += cross(omega, edge_length * rotate(turned, EDGE));
        turned = normalize(multiply(normalize(vec4<f32>(0.5 * omega, 1.0)), turned));
        var x = below + edge_length * rotate(turned, EDGE);
        if dot(omega, omega) < AT_REST * AT_REST {
            let styled = normalize(multiply(after.rotation, rest[i].frame));
            let styled_x = pose_apply(after, rest[i + 1u].place.xyz);
            let aside = max(dot(turned - styled, turned - styled), dot(x - styled_x, x - styled_x));
            if aside < AT_REST * AT_REST {
                turned = styled;
                x = styled_x;
            }
        }
        let was = s[i + 1u].x.xyz;
        let velocity = was - s[i + 1u].prev.xyz;
        s[i + 1u].acceleration = vec4<f32>(((x - was) - velocity) / (h * h), 0.0);
        s[i].frame = turned;
        s[i + 1u].x = vec4<f32>(x, 0.0);
        s[i + 1u].prev = vec4<f32>(was, 0.0);
        below = x;
    }
}

// Keep vertices out of the head and the colliders; true where one touches, and lengths are no longer exact.
fn collide(before: Pose, after: Pose) -> bool {
    var touches = false;
    for (var k = N_PINNED; k < asked.n_vertices; k++) {
        let i = base + k;
        let along = f32(k) / f32(asked.n_vertices - 1u);
        let was = s[i].x.xyz;
        let kept = contact_collide(was, s[i].prev.xyz, rest[i].place.w, along, before, after);
        if any(kept.x != was) {
            touches = true;
            s[i].x = vec4<f32>(kept.x, 0.0);
            s[i].prev = vec4<f32>(kept.prev, 0.0);
        }
    }
    return touches;
}

// Put every vertex at its exact distance from the one below and out of all obstacles; frames follow the edges.
fn close_lengths(after: Pose) {
    for (var reach = 0u; reach <= REACHES; reach++) {
        if !reach_from_root(after, reach < REACHES) {
            break;
        }
        reach_from_tip(after);
    }
    for (var k = 1u; k + 1u < asked.n_vertices; k++) {
        let i = base + k;
        let edge = s[i + 1u].x.xyz - s[i].x.xyz;
        s[i].frame = normalize(multiply(shortest_turn(rotate(s[i].frame, EDGE), edge), s[i].frame));
    }
}

// From the root up, without giving velocity; true where a vertex was held back and may be, its edge too long.
fn reach_from_root(after: Pose, may_hold: bool) -> bool {
    var is_held = false;
    for (var k = N_PINNED; k < asked.n_vertices; k++) {
        let i = base + k;
        let below = s[i - 1u].x.xyz;
        let edge_length = rest[i - 1u].support.w;
        let along = f32(k) / f32(asked.n_vertices - 1u);
        let start = s[i].x.xyz;
        var x = at_length(below, start, edge_length, s[i - 1u].frame);
        for (var iteration = 0u; iteration < rod.n_iterations; iteration++) {
            let kept = contact_keep_out(start, x, rest[i].place.w, along, after);
            if all(kept == x) {
                break;
            }
            x = at_length(below, kept, edge_length, s[i - 1u].frame);
            if may_hold && distance(kept, below) > HELD * edge_length {
                is_held = true;
                x = kept;
                break;
            }
        }
        s[i].prev = vec4<f32>(s[i].prev.xyz + (x - start), 0.0);
        s[i].x = vec4<f32>(x, 0.0);
    }
    return is_held;
}

// From the tip down, edges that are too long; it takes the velocity that made them so.
fn reach_from_tip(after: Pose) {
    for (var k = asked.n_vertices - 2u; k >= N_PINNED; k--) {
        let i = base + k;
        let edge_length = rest[i].support.w;
        let along = f32(k) / f32(asked.n_vertices - 1u);
        let x = s[i].x.xyz;
        let above = s[i + 1u].x.xyz;
        if distance(x, above) > 1.001 * edge_length {
            let pulled = at_length(above, x, edge_length, s[i].frame);
            s[i].x = vec4<f32>(contact_keep_out(x, pulled, rest[i].place.w, along, after), 0.0);
        }
    }
}

// The place in the direction of `x` that is as far from `below` as at rest; in the edge's own where there is none.
fn at_length(below: vec3<f32>, x: vec3<f32>, edge_length: f32, turned: vec4<f32>) -> vec3<f32> {
    let edge = x - below;
    let far = length(edge);
    if far > 1e-6 {
        return below + edge * (edge_length / far);
    }
    return below + edge_length * rotate(turned, EDGE);
}

// A strand that is not finite starts again from rest: once a frame, after its steps.
fn recover(after: Pose) {
    var sum = 0.0;
    for (var k = 0u; k < asked.n_vertices; k++) {
        let d = abs(s[base + k].x.xyz - s[base + k].prev.xyz);
        sum += d.x + d.y + d.z + dot(s[base + k].frame, s[base + k].frame);
    }
    if sum < 1e15 {
        return;
    }
    for (var k = 0u; k < asked.n_vertices; k++) {
        at_rest(k, after);
    }
}

// One step: the head goes from `before` to `after`.
fn step_rod(before: Pose, after: Pose) {
    sweep_to_root(before, after);
    sweep_to_tip(before, after);
    if collide(before, after) {
        close_lengths(after);
    }
}

// All of a frame's steps for one strand. Twin of SimulatedLayer::run in sim/src/layer.rs.
@compute @workgroup_size(32)
fn advance(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let guide_idx = id.x + id.y * n_groups.x * 32u;
    if guide_idx >= asked.n_guides {
        return;
    }
    base = guide_idx * asked.n_vertices;
    if asked.carried == 1u {
        carry_strand(asked.carry);
    }
    for (var step = 0u; step < asked.n_steps; step++) {
        if step + 1u == asked.n_steps {
            for (var k = 0u; k < asked.n_vertices; k++) {
                s[base + k].begun = s[base + k].x;
            }
        }
        contact_step(step, asked.n_steps);
        step_rod(asked.poses[step], asked.poses[step + 1u]);
    }
    recover(asked.poses[asked.n_steps]);
    for (var k = 0u; k < asked.n_vertices; k++) {
        positions[base + k] = shown_at(k, rest[base + k].place.xyz, s[base + k].x.xyz, s[base + k].begun.xyz);
    }
}
