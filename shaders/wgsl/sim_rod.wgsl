// Rods: the twin of sim/src/rod.rs, function by function. That file says why each step is as it is.
//
// One thread takes one strand through all of a frame's steps: each sweep goes from one end to the other. What is kept of 32
// strands lies side by side (sim/src/lanes.rs), so that threads that run together read one stretch of memory. What the sweep
// to the root leaves is a workgroup's, which takes groups of strands one after the other.

#import lorelei::sim_pose::{Pose, rotate, conjugate, multiply, pose_apply, shortest_turn, normalize_or_zero}
#import lorelei::sim_frame::{asked, positions, shown_at, clamp_length, N_PINNED, MAX_SPEED}
#import lorelei::sim_contact::{
    Barrier, Contacted, contact, contact_barrier, contact_collide, contact_keep_out, contact_step, contact_way, STEEPEST,
}
#import lorelei::sim_edge::{Ends, collide_edge, keep_edge_out}
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

// 0: no collider is thin, and edges are not asked about.
override THIN_COLLIDERS: u32 = 0u;

// A matrix that is its own transpose.
struct Symmetric {
    diagonal: vec3<f32>,
    // yz, xz, xy.
    off: vec3<f32>,
}

@group(0) @binding(auto) var<storage, read> rod: RodParams;
// Four of every vertex; which is PLACE, REST_FRAME, JOINT or SUPPORT.
@group(0) @binding(auto) var<storage, read> rest: array<vec4<f32>>;
// Four of every vertex; which is X, PREV, ACCELERATION or FRAME.
@group(0) @binding(auto) var<storage, read_write> s: array<vec4<f32>>;
// Five of every vertex, of a strand of each thread: the columns of lever with the diagonal of gain in their last entries; turn
// with the edge's length; the rest of gain with the room of the vertex above to the nearest obstacle, or PRESSES.
@group(0) @binding(auto) var<storage, read_write> eliminated: array<vec4<f32>>;

const LANES = 32u;

// xyz head space, w the distance from the obstacles at rest.
const PLACE = 0u;
// Frame of the edge above, head space.
const REST_FRAME = 1u;
// Of the rotation of the joint in which it has no moment xyz (its real part is not negative); w length of the edge above.
const JOINT = 2u;
// xyz what carries the vertex beside its own strand, head space; w hold to the style over mass and share of the wind.
const SUPPORT = 3u;

// w of the first three: where the last step began; within a frame's steps of PREV the room to the nearest obstacle.
const X = 0u;
// A step ago; a contact moves it where it takes velocity.
const PREV = 1u;
// Over the last step.
const ACCELERATION = 2u;
// Of the edge above, world.
const FRAME = 3u;

const MIN_EDGE = 0.01;
const DRAG_ALONG = 0.5;
const MAX_TURN = 1.0;
const STILL = 2e-6;
const AT_REST = 2e-5;
const SPIN = 1e-3;
const KEEPS_OUT = 100.0;
const NEARBY = 0.1;
const REACHES = 8u;
const HELD = 1.2;
const EDGE = vec3<f32>(0.0, 0.0, 1.0);

// In place of its room: a vertex presses on what it lies on.
const PRESSES = -1.0;

// Where this thread's strand begins in `rest` and `s`, and in `eliminated`.
var<private> base: u32;
var<private> base_of_eliminated: u32;
// The step that is taken is the frame's last.
var<private> is_last: bool;

fn at(k: u32, which: u32) -> u32 {
    return base + (4u * k + which) * LANES;
}

fn eliminated_at(k: u32) -> u32 {
    return base_of_eliminated + 5u * k * LANES;
}

fn joint_of(packed: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(packed, sqrt(max(1.0 - dot(packed, packed), 0.0)));
}

// Hold and share of the wind.
fn exposure_of(packed: f32) -> vec2<f32> {
    let bits = bitcast<u32>(packed);
    return vec2<f32>(bitcast<f32>(bits & 0xffff0000u), f32(bits & 0xffffu) / 65535.0);
}

// Length of hair whose mass or bending is that of the ends of two edges.
fn half_lengths(below: f32, above: f32) -> f32 {
    return max(0.5 * (below + above), MIN_EDGE);
}

fn at_rest(k: u32, pose: Pose) {
    let x = pose_apply(pose, rest[at(k, PLACE)].xyz);
    s[at(k, X)] = vec4<f32>(x, x.x);
    s[at(k, PREV)] = vec4<f32>(x, x.y);
    s[at(k, ACCELERATION)] = vec4<f32>(0.0, 0.0, 0.0, x.z);
    s[at(k, FRAME)] = normalize(multiply(pose.rotation, rest[at(k, REST_FRAME)]));
}

// Where the last step began, between frames.
fn begun_at(k: u32) -> vec3<f32> {
    return vec3<f32>(s[at(k, X)].w, s[at(k, PREV)].w, s[at(k, ACCELERATION)].w);
}

// Move everything rigidly.
fn carry_strand(carry: Pose) {
    for (var k = 0u; k < asked.n_vertices; k++) {
        let begun = pose_apply(carry, begun_at(k));
        s[at(k, X)] = vec4<f32>(pose_apply(carry, s[at(k, X)].xyz), begun.x);
        s[at(k, PREV)] = vec4<f32>(pose_apply(carry, s[at(k, PREV)].xyz), begun.y);
        s[at(k, ACCELERATION)].w = begun.z;
        s[at(k, FRAME)] = normalize(multiply(carry.rotation, s[at(k, FRAME)]));
    }
}

// Frame of an edge that goes rigidly with the head: what it has of its own is found against that.
fn carried_frame(k: u32, carry: Pose, after: Pose) -> vec4<f32> {
    if k == 0u {
        return normalize(multiply(after.rotation, rest[at(0u, REST_FRAME)]));
    }
    return normalize(multiply(carry.rotation, s[at(k, FRAME)]));
}

// `e x` each column.
fn cross_columns(e: vec3<f32>, m: mat3x3<f32>) -> mat3x3<f32> {
    return mat3x3<f32>(cross(e, m[0]), cross(e, m[1]), cross(e, m[2]));
}

fn full(m: Symmetric) -> mat3x3<f32> {
    return mat3x3<f32>(
        vec3<f32>(m.diagonal.x, m.off.z, m.off.y),
        vec3<f32>(m.off.z, m.diagonal.y, m.off.x),
        vec3<f32>(m.off.y, m.off.x, m.diagonal.z),
    );
}

fn times(m: Symmetric, v: vec3<f32>) -> vec3<f32> {
    return m.diagonal * v + vec3<f32>(
        m.off.z * v.y + m.off.y * v.z,
        m.off.z * v.x + m.off.x * v.z,
        m.off.y * v.x + m.off.x * v.y,
    );
}

// `a b`, known to be its own transpose.
fn symmetric_product(a: mat3x3<f32>, b: mat3x3<f32>) -> Symmetric {
    let x = vec3<f32>(a[0].x, a[1].x, a[2].x);
    let y = vec3<f32>(a[0].y, a[1].y, a[2].y);
    let z = vec3<f32>(a[0].z, a[1].z, a[2].z);
    return Symmetric(
        vec3<f32>(dot(x, b[0]), dot(y, b[1]), dot(z, b[2])),
        vec3<f32>(dot(y, b[2]), dot(x, b[2]), dot(x, b[1])),
    );
}

// `scale` times the outer product of `v` with itself.
fn outer(v: vec3<f32>, scale: f32) -> Symmetric {
    let scaled = scale * v;
    return Symmetric(scaled * v, scaled.yxx * v.zzy);
}

// By cofactors; `m` is positive definite.
fn inverse_symmetric(m: Symmetric) -> Symmetric {
    let d = m.diagonal;
    let o = m.off;
    let off = o.yxx * o.zzy - d * o;
    let diagonal = d.yxx * d.zzy - o * o;
    let scale = 1.0 / (d.x * diagonal.x + o.z * off.z + o.y * off.y);
    return Symmetric(scale * diagonal, scale * off);
}

// Moment that a joint's deviation from its rest makes on the edge above it, world.
fn moment_of_joint(below: vec4<f32>, above: vec4<f32>, joint: vec4<f32>, stiff: f32) -> vec3<f32> {
    let deviation = multiply(conjugate(joint), multiply(conjugate(below), above));
    let shortest = select(1.0, -1.0, deviation.w < 0.0);
    return rotate(above, 2.0 * stiff * shortest * deviation.xyz);
}

// Eliminate every edge from tip to root.
fn sweep_to_root(is_first: bool, carry: Pose, after: Pose) {
    let h = rod.step_secs;
    let across = rod.damping + rod.drag;
    let along = rod.damping_along + DRAG_ALONG * rod.drag;
    var a = Symmetric(vec3<f32>(0.0), vec3<f32>(0.0));
    var b = mat3x3<f32>(vec3<f32>(0.0), vec3<f32>(0.0), vec3<f32>(0.0));
    var c = Symmetric(vec3<f32>(0.0), vec3<f32>(0.0));
    var px = vec3<f32>(0.0);
    var pw = vec3<f32>(0.0);
    var load = vec3<f32>(0.0);
    var above = carried_frame(asked.n_vertices - 2u, carry, after);
    var joint = rest[at(asked.n_vertices - 2u, JOINT)];
    var length_above = 0.0;
    for (var k = asked.n_vertices - 2u; k >= 1u; k--) {
        let j = k + 1u;
        let below = carried_frame(k - 1u, carry, after);
        let joint_below = rest[at(k - 1u, JOINT)];
        let edge_length = joint.w;
        let t = rotate(above, EDGE);
        let e = edge_length * t;
        // Compute what drives vertex j, relative to going rigidly with the head.
        let x = s[at(j, X)].xyz;
        let carried = pose_apply(carry, x);
        let prev = s[at(j, PREV)];
        let own = clamp_length(2.0 * x - prev.xyz - carried, MAX_SPEED * h);
        let support = rest[at(j, SUPPORT)];
        let exposure = exposure_of(support.w);
        let mass = half_lengths(edge_length, length_above);
        let place = rest[at(j, PLACE)];
        let to_style = pose_apply(after, place.xyz) - carried;
        let pull = pull_on(asked.pull, j, asked.n_vertices, place.xyz, carried, after);
        let held = rod.gravity + rotate(after.rotation, support.xyz) + exposure.x * to_style;
        let force = held + pull.w * pull.xyz;
        let blown = h * exposure.y * air_velocity(x) - (carried - x);
        let drag = rod.drag * (blown - (1.0 - DRAG_ALONG) * dot(t, blown) * t);
        let r = mass * (own + h * h * force + h * drag);
        let d = mass * (1.0 + h * (across + sqrt(pull.w)) + h * h * (exposure.x + pull.w));
        let dragged = outer(t, mass * h * (along - across));
        a.diagonal += d + dragged.diagonal;
        a.off += dragged.off;
        px -= r;
        // What it lies on, where it would go in without.
        let acceleration = s[at(j, ACCELERATION)].xyz;
        let driven = own + h * h * acceleration;
        var room = select(prev.w, 0.0, is_first);
        if room <= STEEPEST * contact_way(carried + driven, x, carried) {
            let on = barrier(j, x, carried, place.w, after);
            room = max(-on.push, 0.0);
            let push = min(on.push, NEARBY);
            let pressed = push - dot(on.normal, driven);
            if pressed > 0.0 && push > -NEARBY {
                room = PRESSES;
                let slips = own - on.goes;
                let slip = slips - dot(slips, on.normal) * on.normal;
                let rub = min(contact.friction * pressed / max(length(slip), 1e-9), KEEPS_OUT);
                let keeps = outer(on.normal, mass * (KEEPS_OUT - rub));
                a.diagonal += mass * rub + keeps.diagonal;
                a.off += keeps.off;
                let across_goes = on.goes - dot(on.goes, on.normal) * on.normal;
                px -= mass * (KEEPS_OUT * push * on.normal + rub * across_goes);
            }
        }
        load += mass * (force - acceleration);
        // Compute the inertia about vertex k, with dx_j = dx_k + omega x e.
        let ea = transpose(cross_columns(e, full(a)));
        let eb = cross_columns(e, b);
        let b_below = b + ea;
        let eae = cross_columns(e, ea);
        let tension = h * h * max(dot(load, e), 0.0);
        let taut = outer(t, tension);
        let long = max(edge_length, MIN_EDGE);
        let spin = SPIN * mass * long * long;
        c.diagonal += 2.0 * vec3<f32>(eb[0].x, eb[1].y, eb[2].z) + vec3<f32>(eae[0].x, eae[1].y, eae[2].z)
            + (tension + spin) - taut.diagonal;
        c.off += vec3<f32>(eb[1].z + eb[2].y, eb[0].z + eb[2].x, eb[0].y + eb[1].x)
            + vec3<f32>(eae[1].z, eae[0].z, eae[0].y) - taut.off;
        let pw_below = pw + cross(e, px);
        // Eliminate omega_k.
        let stiff = rod.bend / half_lengths(select(joint_below.w, 0.0, k == 1u), edge_length);
        let g = h * h * moment_of_joint(below, above, joint_of(joint.xyz), stiff);
        let beta = stiff * (h * h + h * rod.bend_damping);
        let inverse = inverse_symmetric(Symmetric(c.diagonal + beta, c.off));
        let inverse_full = full(inverse);
        let turn = times(inverse, pw_below + g);
        let lever = inverse_full * transpose(b_below);
        let i = eliminated_at(k);
        eliminated[i] = vec4<f32>(lever[0], beta * inverse.diagonal.x);
        eliminated[i + LANES] = vec4<f32>(lever[1], beta * inverse.diagonal.y);
        eliminated[i + 2u * LANES] = vec4<f32>(lever[2], beta * inverse.diagonal.z);
        eliminated[i + 3u * LANES] = vec4<f32>(turn, edge_length);
        eliminated[i + 4u * LANES] = vec4<f32>(beta * inverse.off, room);
        let moved = symmetric_product(b_below, lever);
        a.diagonal -= moved.diagonal;
        a.off -= moved.off;
        b = transpose(lever) * beta;
        px -= b_below * turn;
        pw = beta * times(inverse, pw_below) - times(inverse, times(c, g));
        c = symmetric_product(inverse_full, full(c));
        c.diagonal *= beta;
        c.off *= beta;
        above = below;
        joint = joint_below;
        length_above = edge_length;
    }
}

// Turn the edges from root to tip; true where a vertex touches an obstacle, and lengths are no longer exact.
fn sweep_to_tip(before: Pose, carry: Pose, after: Pose) -> bool {
    let h = rod.step_secs;
    var touches = false;
    var omega = vec3<f32>(0.0);
    var dx = vec3<f32>(0.0);
    var below = vec3<f32>(0.0);
    // The vertex below, before and after the step.
    var was_below = vec3<f32>(0.0);
    var now_below = vec3<f32>(0.0);
    for (var k = 0u; k < N_PINNED; k++) {
        let was = s[at(k, X)].xyz;
        below = pose_apply(after, rest[at(k, PLACE)].xyz);
        s[at(k, X)] = vec4<f32>(below, was.x);
        s[at(k, PREV)] = vec4<f32>(was, was.y);
        s[at(k, ACCELERATION)] = vec4<f32>(0.0, 0.0, 0.0, was.z);
        was_below = was;
        now_below = below;
    }
    s[at(0u, FRAME)] = normalize(multiply(after.rotation, rest[at(0u, REST_FRAME)]));
    for (var k = 1u; k + 1u < asked.n_vertices; k++) {
        let j = k + 1u;
        let i = eliminated_at(k);
        let first = eliminated[i];
        let second = eliminated[i + LANES];
        let third = eliminated[i + 2u * LANES];
        let to_root = eliminated[i + 3u * LANES];
        let last = eliminated[i + 4u * LANES];
        let gain = Symmetric(vec3<f32>(first.w, second.w, third.w), last.xyz);
        let was = s[at(j, X)].xyz;
        let prev = s[at(j, PREV)];
        let edge_length = to_root.w;
        var turned = carried_frame(k, carry, after);
        let levered = first.xyz * dx.x + second.xyz * dx.y + third.xyz * dx.z;
        omega = clamp_length(times(gain, omega) - to_root.xyz - levered, MAX_TURN);
        if dot(omega, omega) < STILL * STILL {
            omega = vec3<f32>(0.0);
        }
        dx += cross(omega, edge_length * rotate(turned, EDGE));
        turned = normalize(multiply(normalize(vec4<f32>(0.5 * omega, 1.0)), turned));
        var x = below + edge_length * rotate(turned, EDGE);
        if dot(omega, omega) < AT_REST * AT_REST {
            let styled = normalize(multiply(after.rotation, rest[at(k, REST_FRAME)]));
            let styled_x = pose_apply(after, rest[at(j, PLACE)].xyz);
            let aside = max(dot(turned - styled, turned - styled), dot(x - styled_x, x - styled_x));
            if aside < AT_REST * AT_REST {
                turned = styled;
                x = styled_x;
            }
        }
        below = x;
        let carried = pose_apply(carry, was);
        var acceleration = (x - was) - (was - prev.xyz);
        var contacted = collide(j, x, was, max(last.w, 0.0), before, carried, after);
        if THIN_COLLIDERS == 1u {
            let of_edge = collide_edge(
                Ends(was_below, was), Ends(now_below, contacted.x), contacted.prev, along_strand(j), before, after,
            );
            let room = max(contacted.room - STEEPEST * distance(of_edge.x, contacted.x), 0.0);
            contacted = Contacted(of_edge.x, of_edge.prev, room);
            was_below = was;
            now_below = contacted.x;
        }
        touches |= any(contacted.x != x);
        if last.w == PRESSES {
            let on = barrier(j, was, carried, rest[at(j, PLACE)].w, after);
            let out = (contacted.x - carried - on.goes) - (contacted.prev - was);
            contacted.prev += dot(out, on.normal) * on.normal;
            acceleration -= KEEPS_OUT * (min(on.push, NEARBY) - dot(dx, on.normal)) * on.normal;
        }
        s[at(k, FRAME)] = turned;
        s[at(j, X)] = vec4<f32>(contacted.x, was.x);
        s[at(j, PREV)] = vec4<f32>(contacted.prev, select(contacted.room, was.y, is_last));
        s[at(j, ACCELERATION)] = vec4<f32>(acceleration / (h * h), was.z);
    }
    return touches;
}

// Keep a vertex out of the head and the colliders; `room` is how far from a contact it was at `prev`.
fn collide(
    k: u32,
    x: vec3<f32>,
    prev: vec3<f32>,
    room: f32,
    before: Pose,
    carried: vec3<f32>,
    after: Pose,
) -> Contacted {
    let left = room - STEEPEST * contact_way(x, prev, carried);
    if left > 0.0 {
        return Contacted(x, prev, left);
    }
    return contact_collide(x, prev, rest[at(k, PLACE)].w, along_strand(k), before, carried, after);
}

// What vertex `k` lies on that would go with the head from `prev` to `carried`.
fn barrier(k: u32, prev: vec3<f32>, carried: vec3<f32>, rest_distance: f32, after: Pose) -> Barrier {
    return contact_barrier(prev, carried, rest_distance, along_strand(k), after, NEARBY);
}

// Where on the strand, 0 root to 1 tip.
fn along_strand(k: u32) -> f32 {
    return f32(k) / f32(asked.n_vertices - 1u);
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
        let edge = s[at(k + 1u, X)].xyz - s[at(k, X)].xyz;
        let turned = s[at(k, FRAME)];
        s[at(k, FRAME)] = normalize(multiply(shortest_turn(rotate(turned, EDGE), edge), turned));
    }
}

// From the root up, without giving velocity; true where a vertex was held back and may be, its edge too long.
fn reach_from_root(after: Pose, may_hold: bool) -> bool {
    var is_held = false;
    var below = s[at(N_PINNED - 1u, X)].xyz;
    var start_below = below;
    for (var k = N_PINNED; k < asked.n_vertices; k++) {
        let edge_length = rest[at(k - 1u, JOINT)].w;
        let was = s[at(k, X)];
        let prev = s[at(k, PREV)];
        let start = was.xyz;
        var x = at_length(below, start, edge_length, k - 1u);
        for (var iteration = 0u; iteration < rod.n_iterations; iteration++) {
            let kept = keep_out(k, Ends(start_below, start), Ends(below, x), prev.w, after);
            if all(kept == x) {
                break;
            }
            if may_hold && distance(kept, below) > HELD * edge_length {
                is_held = true;
                x = kept;
                break;
            }
            x = turned_out(below, x, kept, edge_length, k - 1u);
        }
        s[at(k, X)] = vec4<f32>(x, was.w);
        s[at(k, PREV)] = vec4<f32>(prev.xyz + (x - start), room_after(prev.w, start, x));
        below = x;
        start_below = start;
    }
    return is_held;
}

// From the tip down, edges that are too long; it takes the velocity that made them so.
fn reach_from_tip(after: Pose) {
    var above = s[at(asked.n_vertices - 1u, X)].xyz;
    var start_above = above;
    for (var k = asked.n_vertices - 2u; k >= N_PINNED; k--) {
        let edge_length = rest[at(k, JOINT)].w;
        let was = s[at(k, X)];
        var x = was.xyz;
        let is_long = distance(x, above) > 1.001 * edge_length;
        if is_long || THIN_COLLIDERS == 1u {
            let room = s[at(k, PREV)].w;
            if is_long {
                x = at_length(above, was.xyz, edge_length, k);
            }
            x = keep_out(k, Ends(start_above, was.xyz), Ends(above, x), room, after);
            s[at(k, X)] = vec4<f32>(x, was.w);
            s[at(k, PREV)].w = room_after(room, was.xyz, x);
        }
        above = x;
        start_above = was.xyz;
    }
}

// Keep out a vertex that goes from `start` to `end`, the free ends of its edge; `room` is what is kept of it, in the last step not
// its room.
fn keep_out(k: u32, start: Ends, end: Ends, room: f32, after: Pose) -> vec3<f32> {
    var x = end.free;
    if is_last || room <= STEEPEST * distance(start.free, x) {
        x = contact_keep_out(start.free, x, rest[at(k, PLACE)].w, along_strand(k), after);
    }
    if THIN_COLLIDERS == 0u {
        return x;
    }
    return keep_edge_out(start, Ends(end.held, x), along_strand(k), after);
}

// What is kept of a vertex that has gone from `start` to `x`.
fn room_after(room: f32, start: vec3<f32>, x: vec3<f32>) -> f32 {
    return select(max(room - STEEPEST * distance(start, x), 0.0), room, is_last);
}

// The place in the direction of `x` that is as far from `below` as at rest; in the direction of edge k where there is none.
fn at_length(below: vec3<f32>, x: vec3<f32>, edge_length: f32, k: u32) -> vec3<f32> {
    let edge = x - below;
    let far = length(edge);
    if far > 1e-6 {
        return below + edge * (edge_length / far);
    }
    return below + edge_length * rotate(s[at(k, FRAME)], EDGE);
}

// As far from `below` as at rest, and out of what pushed from `x` to `kept`: the edge turns until it is.
fn turned_out(below: vec3<f32>, x: vec3<f32>, kept: vec3<f32>, edge_length: f32, k: u32) -> vec3<f32> {
    let edge = kept - below;
    let normal = normalize_or_zero(kept - x);
    let out = dot(edge, normal);
    let across = edge - out * normal;
    let squared = dot(across, across);
    if squared < 1e-12 || abs(out) >= edge_length {
        return at_length(below, kept, edge_length, k);
    }
    return below + out * normal + across * sqrt((edge_length * edge_length - out * out) / squared);
}

// A strand that is not finite starts again from rest: once a frame, after its steps.
fn recover(after: Pose) {
    var sum = 0.0;
    for (var k = 0u; k < asked.n_vertices; k++) {
        let d = abs(s[at(k, X)].xyz - s[at(k, PREV)].xyz);
        let turned = s[at(k, FRAME)];
        sum += d.x + d.y + d.z + dot(turned, turned);
    }
    if sum < 1e15 {
        return;
    }
    for (var k = 0u; k < asked.n_vertices; k++) {
        at_rest(k, after);
    }
}

// One step.
fn step_rod(step: u32) {
    let before = asked.poses[step];
    let after = asked.poses[step + 1u];
    let carry = asked.carries[step];
    contact_step(step, asked.n_steps);
    is_last = step + 1u == asked.n_steps;
    sweep_to_root(step == 0u, carry, after);
    if sweep_to_tip(before, carry, after) {
        close_lengths(after);
    }
}

// All of a frame's steps for one strand after the other. Twin of SimulatedLayer::run in sim/src/layer.rs.
@compute @workgroup_size(32)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let n = asked.n_vertices;
    base_of_eliminated = 5u * group.x * n * LANES + lane;
    for (var first_guide = group.x * LANES; first_guide < asked.n_guides; first_guide += n_groups.x * LANES) {
        let guide_idx = first_guide + lane;
        if guide_idx >= asked.n_guides {
            return;
        }
        base = 4u * first_guide * n + lane;
        if asked.carried == 1u {
            carry_strand(asked.carry);
        }
        for (var step = 0u; step < asked.n_steps; step++) {
            step_rod(step);
        }
        recover(asked.poses[asked.n_steps]);
        for (var k = 0u; k < n; k++) {
            let x = s[at(k, X)].xyz;
            positions[guide_idx * n + k] = shown_at(k, rest[at(k, PLACE)].xyz, x, begun_at(k));
        }
    }
}
