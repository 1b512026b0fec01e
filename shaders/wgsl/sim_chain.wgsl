// Chains: the twin of sim/src/chain.rs, function by function.
//
// A workgroup takes as many strands as have room, a thread two vertices of a strand that follow each other, `low` and `high`, and
// all of a frame's steps are one dispatch. What a thread's neighbours have to know goes through workgroup memory; the rest
// stays in registers. With a thread a vertex, as the references have it, half the threads rest while lengths are corrected.

#import lorelei::sim_pose::{Pose, rotate, pose_apply, turned_as, inverse_length}
#import lorelei::sim_frame::{asked, positions, shown_at, clamp_length, N_PINNED, MAX_SPEED}
#import lorelei::sim_contact::{Contacted, contact_collide, contact_keep_out, contact_step, contact_way, STEEPEST}
#import lorelei::sim_edge::{Ends, collide_edge}
#import lorelei::sim_air::air_velocity
#import lorelei::sim_pull::pull_on

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
    // xyz what carries it beside its own strand, head space, w the pull of the edge below over its mass, at rest: cm/s2.
    support: vec4<f32>,
}

struct ChainVertex {
    // xyz world, cm; w the pull of the edge below over the vertex's mass in the last step, cm/s2.
    x: vec4<f32>,
    // A step ago; a contact moves it where it takes velocity.
    prev: vec4<f32>,
    // Where the last step began.
    begun: vec4<f32>,
}

// 0: no collider is thin, and edges are not asked about.
override THIN_COLLIDERS: u32 = 0u;

// Threads of a workgroup, and vertices of a thread. Strands have no more than 64 vertices.
const LANES: u32 = 32u;
const BLOCK: u32 = 2u;
// Largest pull of an edge over its vertex's mass, cm/s2, and shortest edge that pulls, cm.
const MOST_PULL: f32 = 1e6;
const SHORTEST: f32 = 1e-4;
// Times in a step that lengths are closed where obstacles keep moving vertices, and what they may move without: cm.
const CLOSINGS: u32 = 8u;
const CLOSED: f32 = 0.002;
// As near as this to the style, and to where it was, a vertex is put to the style, cm.
const AT_REST: f32 = 5e-5;

// A vertex while a frame's steps are taken, and the edge below it.
struct Vertex {
    k: u32,
    // Whether there is such a vertex and it is not pinned.
    is_free: bool,
    x: vec3<f32>,
    prev: vec3<f32>,
    begun: vec3<f32>,
    // Where the head would take it from `prev`.
    carried: vec3<f32>,
    // How far it is from a contact at least.
    room: f32,
    pull: f32,
    // Of the edge at rest: its length, one over the length of the edge below it (0 where it has none), and how far it goes
    // along that one's direction.
    rest_length: f32,
    by_below: f32,
    along_below: f32,
    // The edge as the style has it after the step.
    styled_edge: vec3<f32>,
    // Stiffness of its hold in units of the step's inertia; share of the wind.
    hold: f32,
    wind: f32,
}

@group(0) @binding(auto) var<storage, read> chain: ChainParams;
@group(0) @binding(auto) var<storage, read> rest: array<ChainRest>;
@group(0) @binding(auto) var<storage, read_write> s: array<ChainVertex>;

// What threads tell their neighbours: a vector in each of these slots, every number of it side by side for all threads.
const HIGH: u32 = 0u;
const LOW: u32 = 1u;
const JOINT: u32 = 2u;
const BELOW: u32 = 3u;
const TURN: u32 = 4u;
const SHARE: u32 = 5u;
var<workgroup> said: array<f32, 18u * LANES>;
// Of each strand of the workgroup: whether obstacles moved it when its lengths were closed; whether any.
var<workgroup> is_open: array<atomic<u32>, LANES>;
var<workgroup> is_any_open: u32;
// Of each strand of the workgroup.
var<workgroup> is_broken: array<atomic<u32>, LANES>;

// This thread, and the ones below and above it: of another strand at the strand's ends.
var<private> lane: u32;
var<private> lane_below: u32;
var<private> lane_above: u32;
// Which of its strand's threads it is.
var<private> nth: u32;
var<private> n_threads: u32;
var<private> low: Vertex;
var<private> high: Vertex;
// Whether the vertex above `high` is free, and the length of the edge to it.
var<private> is_above_free: bool;
var<private> length_above: f32;
// The edge below `low`'s own as the style has it after the step.
var<private> styled_below: vec3<f32>;

// Tell the neighbours; they hear it after the next barrier.
fn say(slot: u32, v: vec3<f32>) {
    let i = 3u * LANES * slot + lane;
    said[i] = v.x;
    said[i + LANES] = v.y;
    said[i + 2u * LANES] = v.z;
}

fn said_by(whom: u32, slot: u32) -> vec3<f32> {
    let i = 3u * LANES * slot + whom;
    return vec3<f32>(said[i], said[i + LANES], said[i + 2u * LANES]);
}

fn along(k: u32) -> f32 {
    return f32(k) / f32(asked.n_vertices - 1u);
}

// Verlet's rule for one vertex: where it goes (xyz) times one more than the stiffness of the hand on it (w). Pinned it goes
// with the head, to `styled`.
fn integrate(v: Vertex, at: ChainRest, styled: vec3<f32>, after: Pose) -> vec4<f32> {
    if !v.is_free {
        return vec4<f32>(styled, 0.0);
    }
    let with_head = v.carried - v.x;
    var goes = with_head + chain.keep * (v.x - v.prev - with_head);
    goes += chain.take_up * (v.wind * chain.step_secs * air_velocity(v.x) - goes);
    let squared_step = chain.step_secs * chain.step_secs;
    let forces = squared_step * rotate(after.rotation, at.support.xyz);
    let free = v.x + clamp_length(goes, MAX_SPEED * chain.step_secs) + (chain.gravity_step + forces);
    let hand = pull_on(asked.pull, v.k, asked.n_vertices, at.place.xyz, v.carried, after);
    let pulled = squared_step * hand.w;
    return vec4<f32>(free + pulled * (v.carried + hand.xyz), pulled);
}

// Stiffness of the edge below a vertex, across and along, in units of the step's inertia.
fn stiffness(v: Vertex) -> f32 {
    return select(0.0, chain.step_secs * chain.step_secs * v.pull / max(v.rest_length, SHORTEST), v.is_free);
}

// Take both vertices where they go that `integrate` sends to `to_low` and `to_high`: see take_pulls in sim/src/chain.rs.
// One equation a vertex, with its neighbours' places as unknowns. Each thread puts its lower one's into its upper one's;
// what is left has the threads' upper vertices as unknowns, and each round puts in theirs, until none is left.
fn take_pulls(to_low: vec4<f32>, to_high: vec4<f32>) {
    let w_low = stiffness(low);
    let w_high = stiffness(high);
    // The lower vertex by the ones below (x) and above it (y).
    let between = select(0.0, w_high, low.is_free);
    let by_low = 1.0 / (1.0 + to_low.w + w_low + between);
    let share_low = by_low * vec2<f32>(w_low, between);
    let x_low = by_low * to_low.xyz;
    say(SHARE, vec3<f32>(share_low, w_low));
    say(TURN, x_low);
    workgroupBarrier();
    var share_above = vec3<f32>(0.0);
    var x_above = vec3<f32>(0.0);
    if is_above_free && high.is_free {
        share_above = said_by(lane_above, SHARE);
        x_above = said_by(lane_above, TURN);
    }
    let w_above = share_above.z;
    let by_high = 1.0 / (1.0 + to_high.w + w_high * (1.0 - share_low.y) + w_above * (1.0 - share_above.x));
    var share = by_high * vec2<f32>(w_high * share_low.x, w_above * share_above.y);
    var x = by_high * (to_high.xyz + w_high * x_low + w_above * x_above);
    for (var far = 1u; far < n_threads; far *= 2u) {
        workgroupBarrier();
        say(SHARE, vec3<f32>(share, 0.0));
        say(TURN, x);
        workgroupBarrier();
        var below = vec2<f32>(0.0);
        var above = vec2<f32>(0.0);
        var x_below = vec3<f32>(0.0);
        var x_beyond = vec3<f32>(0.0);
        if nth >= far {
            below = said_by(lane - far, SHARE).xy;
            x_below = said_by(lane - far, TURN);
        }
        if nth + far < n_threads {
            above = said_by(lane + far, SHARE).xy;
            x_beyond = said_by(lane + far, TURN);
        }
        let again = 1.0 / (1.0 - share.x * below.y - share.y * above.x);
        x = again * (x + share.x * x_below + share.y * x_beyond);
        share = again * vec2<f32>(share.x * below.x, share.y * above.y);
    }
    say(JOINT, x);
    workgroupBarrier();
    high.x = x;
    low.x = x_low + share_low.y * x;
    if nth > 0u {
        low.x += share_low.x * said_by(lane_below, JOINT);
    }
}

// By what share of itself an edge is too long (x), and by how much (y).
fn too_long(edge: vec3<f32>, wanted: f32) -> vec2<f32> {
    let by_length = inverse_length(edge);
    let share = 1.0 - wanted * by_length;
    return vec2<f32>(share, share * dot(edge, edge) * by_length);
}

// An edge's pull once a correction has taken an end of it by `way`.
fn pulled_by(before: f32, way: f32) -> f32 {
    return clamp(before + way / (chain.step_secs * chain.step_secs), 0.0, MOST_PULL);
}

// Lengths of every second edge, which lie between threads, and then of the others, which each thread has to itself. Both threads
// that an edge lies between know what the other does with it.
fn lengths() {
    say(LOW, low.x);
    say(HIGH, high.x);
    workgroupBarrier();
    if low.is_free {
        let edge = low.x - said_by(lane_below, HIGH);
        // The lowest one is pinned at its other end.
        let excess = select(0.5, 1.0, low.k == N_PINNED) * too_long(edge, low.rest_length);
        low.pull = pulled_by(low.pull, excess.y);
        low.x -= excess.x * edge;
    }
    if is_above_free {
        let edge = said_by(lane_above, LOW) - high.x;
        let excess = 0.5 * too_long(edge, length_above);
        high.x += select(0.0, excess.x, high.is_free) * edge;
    }
    if high.is_free {
        let edge = high.x - low.x;
        let share_low = select(0.0, 0.5, low.is_free);
        let excess = (1.0 - share_low) * too_long(edge, high.rest_length);
        high.pull = pulled_by(high.pull, excess.y);
        low.x += 2.0 * share_low * excess.x * edge;
        high.x -= excess.x * edge;
    }
}

// Towards the local shape, both vertices at once from where all were before; both ends of an edge move.
fn angles() {
    say(JOINT, high.x);
    say(BELOW, low.x);
    workgroupBarrier();
    let joint = said_by(lane_below, JOINT);
    let edge_below = joint - said_by(lane_below, BELOW);
    let edge_low = low.x - joint;
    let edge_high = high.x - low.x;
    let turn_low = turn(low, styled_below, edge_below, edge_low);
    let turn_high = turn(high, low.styled_edge, edge_low, edge_high);
    say(TURN, turn_low);
    workgroupBarrier();
    var turn_above = vec3<f32>(0.0);
    if is_above_free {
        turn_above = said_by(lane_above, TURN);
    }
    if low.is_free {
        low.x += turn_low - turn_high;
    }
    if high.is_free {
        high.x += turn_high - turn_above;
    }
}

// How far the local shape moves a vertex: where the turn of the edge below would take the edge to it.
fn turn(v: Vertex, styled_edge_below: vec3<f32>, edge_below: vec3<f32>, edge: vec3<f32>) -> vec3<f32> {
    if !v.is_free {
        return vec3<f32>(0.0);
    }
    let goal = turned_as(styled_edge_below, v.by_below, v.along_below, edge_below, v.styled_edge);
    return 0.5 * chain.shape * (goal - edge);
}

// Keep a vertex out of the head and the colliders.
fn contact_of(v: Vertex, rest_distance: f32, carry: Pose, before: Pose, after: Pose) -> Vertex {
    var kept = v;
    let way = STEEPEST * contact_way(v.x, v.prev, v.carried);
    if v.is_free && v.room <= way {
        let contacted = contact_collide(v.x, v.prev, rest_distance, along(v.k), before, v.carried, after);
        kept.room = max(v.room, contacted.room - way);
        if any(contacted.x != v.x) {
            kept.x = contacted.x;
            kept.prev = contacted.prev;
            kept.carried = pose_apply(carry, contacted.prev);
            kept.room = 0.0;
        }
    }
    return kept;
}

// Keep the edge below a vertex out of thin colliders on its way from where the step began. In a contact a vertex loses
// velocity, in a correction it keeps what it has.
fn edge_of(v: Vertex, held: Ends, is_contact: bool, carry: Pose, before: Pose, after: Pose) -> Vertex {
    let start = Ends(held.held, v.begun);
    let contacted = collide_edge(start, Ends(held.free, v.x), v.prev, along(v.k), before, after);
    var kept = v;
    if any(contacted.x != v.x) {
        kept.x = contacted.x;
        kept.prev = select(v.prev + (contacted.x - v.x), contacted.prev, is_contact);
        kept.carried = pose_apply(carry, kept.prev);
        kept.room = 0.0;
    }
    return kept;
}

// The same for every second edge, and then for the others, by their upper vertices; returns how far that moved the farther one.
fn edges(is_moved: bool, is_contact: bool, carry: Pose, before: Pose, after: Pose) -> f32 {
    let free_low = low.x;
    let free_high = high.x;
    workgroupBarrier();
    say(JOINT, high.x);
    say(BELOW, high.begun);
    workgroupBarrier();
    if is_moved && low.is_free {
        low = edge_of(low, Ends(said_by(lane_below, BELOW), said_by(lane_below, JOINT)), is_contact, carry, before, after);
    }
    if is_moved && high.is_free {
        high = edge_of(high, Ends(low.begun, low.x), is_contact, carry, before, after);
    }
    workgroupBarrier();
    return max(distance(low.x, free_low), distance(high.x, free_high));
}

// How far closing the length of the edge below a vertex moves it.
fn closing(v: Vertex, edge: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(0.0), -too_long(edge, v.rest_length).x * edge, v.is_free);
}

// Take a vertex by `moved`, and out of all obstacles without giving velocity.
fn closed_of(v: Vertex, moved: vec3<f32>, rest_distance: f32, carry: Pose, after: Pose) -> Vertex {
    var kept = v;
    kept.x = v.x + moved;
    let way = STEEPEST * length(moved);
    kept.room = max(v.room - way, 0.0);
    if v.room <= way {
        let closed = kept.x;
        kept.x = contact_keep_out(v.x, closed, rest_distance, along(v.k), after);
        if any(kept.x != closed) {
            kept.prev += kept.x - closed;
            kept.carried = pose_apply(carry, kept.prev);
        }
    }
    return kept;
}

// Put every vertex at its distance from the one below and out of all obstacles; returns how far obstacles moved the farther
// one. Where `is_closed` nothing moves any more.
fn close_lengths(is_closed: bool, distances: vec2<f32>, carry: Pose, after: Pose) -> f32 {
    say(JOINT, high.x);
    workgroupBarrier();
    let by_low = closing(low, low.x - said_by(lane_below, JOINT));
    let by_high = closing(high, high.x - low.x);
    // What all edges up to this thread's move: a sum from the root up, in doubling reaches.
    var sum = by_low + by_high;
    for (var far = 1u; far < n_threads; far *= 2u) {
        say(TURN, sum);
        workgroupBarrier();
        if nth >= far {
            sum += said_by(lane - far, TURN);
        }
        workgroupBarrier();
    }
    if is_closed {
        return 0.0;
    }
    var farthest = 0.0;
    if low.is_free {
        let closed = low.x + (sum - by_high);
        low = closed_of(low, sum - by_high, distances.x, carry, after);
        farthest = distance(low.x, closed);
    }
    if high.is_free {
        let closed = high.x + sum;
        high = closed_of(high, sum, distances.y, carry, after);
        farthest = max(farthest, distance(high.x, closed));
    }
    return farthest;
}

// The vertex where the style has it, if it is as near as that and has not moved.
fn settled(v: Vertex, place: vec3<f32>, after: Pose) -> vec3<f32> {
    let aside = v.x - v.carried;
    if v.is_free && dot(aside, aside) < AT_REST * AT_REST {
        let styled = pose_apply(after, place);
        let from_style = v.x - styled;
        return select(v.x, styled, dot(from_style, from_style) < AT_REST * AT_REST);
    }
    return v.x;
}

// One step: the head goes from `before` to `after`. `i_low`, `i_high`: the thread's vertices among all.
fn take_step(i_low: u32, i_high: u32, strand: u32, carry: Pose, before: Pose, after: Pose) {
    let at_low = rest[i_low];
    let at_high = rest[i_high];
    let styled_low = pose_apply(after, at_low.place.xyz);
    let styled_high = pose_apply(after, at_high.place.xyz);
    low.carried = pose_apply(carry, low.x);
    high.carried = pose_apply(carry, high.x);
    low.begun = low.x;
    high.begun = high.x;
    let to_low = integrate(low, at_low, styled_low, after);
    let to_high = integrate(high, at_high, styled_high, after);
    low.prev = low.x;
    high.prev = high.x;
    say(JOINT, styled_high);
    say(BELOW, styled_low);
    workgroupBarrier();
    styled_below = said_by(lane_below, JOINT) - said_by(lane_below, BELOW);
    low.styled_edge = styled_low - said_by(lane_below, JOINT);
    high.styled_edge = styled_high - styled_low;
    take_pulls(to_low, to_high);
    low.x += low.hold * (styled_low - low.x);
    high.x += high.hold * (styled_high - high.x);
    let distances = vec2<f32>(at_low.place.w, at_high.place.w);
    for (var iteration = 0u; iteration < chain.n_iterations; iteration++) {
        lengths();
        angles();
        low = contact_of(low, distances.x, carry, before, after);
        high = contact_of(high, distances.y, carry, before, after);
        if THIN_COLLIDERS == 1u {
            _ = edges(true, true, carry, before, after);
        }
    }
    low.room = max(low.room - STEEPEST * contact_way(low.x, low.prev, low.carried), 0.0);
    high.room = max(high.room - STEEPEST * contact_way(high.x, high.prev, high.carried), 0.0);
    var is_closed = false;
    for (var again = 0u; again < CLOSINGS; again++) {
        if nth == 0u {
            atomicStore(&is_open[strand], 0u);
        }
        if lane == 0u {
            is_any_open = 0u;
        }
        var farthest = close_lengths(is_closed, distances, carry, after);
        if THIN_COLLIDERS == 1u {
            farthest = max(farthest, edges(!is_closed, false, carry, before, after));
        }
        if farthest >= CLOSED {
            atomicStore(&is_open[strand], 1u);
        }
        workgroupBarrier();
        if !is_closed && atomicLoad(&is_open[strand]) == 1u {
            is_any_open = 1u;
        } else {
            is_closed = true;
        }
        if workgroupUniformLoad(&is_any_open) == 0u {
            break;
        }
    }
    low.x = settled(low, at_low.place.xyz, after);
    high.x = settled(high, at_high.place.xyz, after);
}

// Vertex `k` of the strand that begins at `of_strand`, as the frame finds it.
fn begin(of_strand: u32, k: u32, is_here: bool) -> Vertex {
    let i = of_strand + k;
    let place = rest[i].place.xyz;
    let below = rest[of_strand + max(k, 1u) - 1u].place.xyz;
    let edge = place - below;
    let edge_below = below - rest[of_strand + max(k, 2u) - 2u].place.xyz;
    let by_below = inverse_length(edge_below);
    let hold = chain.step_secs * chain.step_secs * rest[i].numbers.x;
    let is_free = is_here && k >= N_PINNED;
    var v = Vertex();
    v.k = k;
    v.is_free = is_free;
    v.x = s[i].x.xyz;
    v.prev = s[i].prev.xyz;
    v.begun = s[i].begun.xyz;
    v.pull = s[i].x.w;
    v.rest_length = length(edge);
    v.by_below = by_below;
    v.along_below = by_below * dot(edge_below, edge);
    v.hold = select(0.0, hold / (1.0 + hold), is_free);
    v.wind = rest[i].numbers.y;
    if asked.carried == 1u {
        v.x = pose_apply(asked.carry, v.x);
        v.prev = pose_apply(asked.carry, v.prev);
        v.begun = pose_apply(asked.carry, v.begun);
    }
    return v;
}

fn way_of_step(v: Vertex) -> f32 {
    let d = abs(v.x - v.prev);
    return d.x + d.y + d.z;
}

// Leave a vertex as the frame found it where its strand is not finite: at rest.
fn end(v: Vertex, i: u32, is_broken: bool) {
    let place = rest[i].place.xyz;
    var whole = v;
    if is_broken {
        whole.x = pose_apply(asked.poses[asked.n_steps], place);
        whole.prev = whole.x;
        whole.begun = whole.x;
        whole.pull = rest[i].support.w;
    }
    s[i] = ChainVertex(vec4<f32>(whole.x, whole.pull), vec4<f32>(whole.prev, 0.0), vec4<f32>(whole.begun, 0.0));
    positions[i] = shown_at(v.k, place, whole.x, whole.begun);
}

// All of a frame's steps for as many strands as have room in a workgroup. Twin of SimulatedLayer::run in sim/src/layer.rs.
@compute @workgroup_size(LANES)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) local_lane: u32,
) {
    let n = asked.n_vertices;
    n_threads = (n + BLOCK - 1u) / BLOCK;
    let n_strands = LANES / n_threads;
    let first_guide = (group.x + group.y * n_groups.x) * n_strands;
    if first_guide >= asked.n_guides {
        return;
    }
    lane = local_lane;
    lane_below = max(lane, 1u) - 1u;
    lane_above = min(lane + 1u, LANES - 1u);
    let strand = lane / n_threads;
    nth = lane % n_threads;
    let is_here = strand < n_strands && first_guide + strand < asked.n_guides;
    // Threads without a strand read the first one's and write nothing.
    let of_strand = select(0u, (first_guide + strand) * n, is_here);
    let k_low = BLOCK * nth;
    let k_high = min(k_low + 1u, n - 1u);
    let has_high = is_here && k_low + 1u < n;
    low = begin(of_strand, k_low, is_here);
    high = begin(of_strand, k_high, has_high);
    is_above_free = is_here && k_low + BLOCK < n;
    let k_above = min(k_low + BLOCK, n - 1u);
    length_above = distance(rest[of_strand + k_above].place.xyz, rest[of_strand + k_high].place.xyz);
    let i_low = of_strand + k_low;
    let i_high = of_strand + k_high;
    for (var step = 0u; step < asked.n_steps; step++) {
        contact_step(step, asked.n_steps);
        take_step(i_low, i_high, strand, asked.carries[step], asked.poses[step], asked.poses[step + 1u]);
    }
    // A strand that is not finite starts again from rest: once a frame, after its steps.
    if nth == 0u {
        atomicStore(&is_broken[strand], 0u);
    }
    workgroupBarrier();
    // False for NaN and infinity too.
    if is_here && !(way_of_step(low) < 1e13 && way_of_step(high) < 1e13) {
        atomicStore(&is_broken[strand], 1u);
    }
    workgroupBarrier();
    let broken = atomicLoad(&is_broken[strand]) == 1u;
    if is_here {
        end(low, i_low, broken);
    }
    if has_high {
        end(high, i_high, broken);
    }
}
