// Chains: the twin of sim/src/chain.rs, function by function.
//
// A workgroup takes a strand, or as many as have room, and a thread a vertex, as the references do; places are shared in
// workgroup memory, and all of a frame's steps are one dispatch.

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

// Threads of a workgroup, and most vertices of a strand: guides have no more than 64.
const LANES: u32 = 64u;
// Largest pull of an edge over its vertex's mass, cm/s2, and shortest edge that pulls, cm.
const MOST_PULL: f32 = 1e6;
const SHORTEST: f32 = 1e-4;
// Times in a step that lengths are closed where obstacles keep moving vertices, and what they may move without: cm.
const CLOSINGS: u32 = 8u;
const CLOSED: f32 = 0.002;
// As near as this to the style, and to where it was, a vertex is put to the style, cm.
const AT_REST: f32 = 5e-5;

@group(0) @binding(auto) var<storage, read> chain: ChainParams;
@group(0) @binding(auto) var<storage, read> rest: array<ChainRest>;
@group(0) @binding(auto) var<storage, read_write> s: array<ChainVertex>;

// Places of the vertices now, one a thread.
var<workgroup> x_of: array<vec3<f32>, LANES>;
// How far the local shape would move them; what is found by halving.
var<workgroup> turn_of: array<vec3<f32>, LANES>;
// Where the step began, where edges are asked about.
var<workgroup> begun_of: array<vec3<f32>, LANES>;
// Shares of the vertices below and above in where a vertex goes; x the stiffness of the edge below before that.
var<workgroup> share_of: array<vec2<f32>, LANES>;
// Of each strand of the workgroup: whether obstacles moved it when its lengths were closed; whether any.
var<workgroup> is_open: array<atomic<u32>, LANES>;
var<workgroup> is_any_open: u32;
// Of each strand of the workgroup.
var<workgroup> is_broken: array<atomic<u32>, LANES>;

// Verlet's rule for one vertex: where it goes from `x` (xyz) times one more than the stiffness of the hand on it (w). With the head
// it would go to `carried`.
fn integrate(k: u32, x: vec3<f32>, prev: vec3<f32>, at: ChainRest, carried: vec3<f32>, after: Pose) -> vec4<f32> {
    if k < N_PINNED {
        return vec4<f32>(pose_apply(after, at.place.xyz), 0.0);
    }
    let with_head = carried - x;
    var v = with_head + chain.keep * (x - prev - with_head);
    v += chain.take_up * (at.numbers.y * chain.step_secs * air_velocity(x) - v);
    let squared_step = chain.step_secs * chain.step_secs;
    let forces = squared_step * rotate(after.rotation, at.support.xyz);
    let free = x + clamp_length(v, MAX_SPEED * chain.step_secs) + (chain.gravity_step + forces);
    let pull = pull_on(asked.pull, k, asked.n_vertices, at.place.xyz, carried, after);
    let pulled = squared_step * pull.w;
    return vec4<f32>(free + pulled * (carried + pull.xyz), pulled);
}

// The hold to the style, of a vertex that the pulls take to `x`.
fn hold(k: u32, x: vec3<f32>, at: ChainRest, after: Pose) -> vec3<f32> {
    if k < N_PINNED {
        return x;
    }
    let stiffness = chain.step_secs * chain.step_secs * at.numbers.x;
    return x + (pose_apply(after, at.place.xyz) - x) * (stiffness / (1.0 + stiffness));
}

// Where a vertex goes that `integrate` sends to `to`: see take_pulls in sim/src/chain.rs. One equation a vertex, with its
// neighbours' places as unknowns; each round puts in theirs, until none is left.
fn take_pulls(lane: u32, k: u32, is_here: bool, to: vec4<f32>, w_below: f32) -> vec3<f32> {
    let n = asked.n_vertices;
    if is_here {
        share_of[lane] = vec2<f32>(w_below, 0.0);
    }
    workgroupBarrier();
    let is_free = is_here && k >= N_PINNED;
    let has_above = is_free && k + 1u < n;
    var w_above = 0.0;
    if has_above {
        w_above = share_of[lane + 1u].x;
    }
    workgroupBarrier();
    let scale = 1.0 / (1.0 + to.w + w_below + w_above);
    var share = vec2<f32>(scale * w_below, scale * w_above);
    var x = scale * to.xyz;
    for (var far = 1u; far < n; far *= 2u) {
        if is_here {
            share_of[lane] = share;
            turn_of[lane] = x;
        }
        workgroupBarrier();
        var below = vec2<f32>(0.0);
        var above = vec2<f32>(0.0);
        var x_below = vec3<f32>(0.0);
        var x_above = vec3<f32>(0.0);
        if is_free && k >= far {
            below = share_of[lane - far];
            x_below = turn_of[lane - far];
        }
        if is_free && k + far < n {
            above = share_of[lane + far];
            x_above = turn_of[lane + far];
        }
        let again = 1.0 / (1.0 - share.x * below.y - share.y * above.x);
        x = again * (x + share.x * x_below + share.y * x_above);
        share = again * vec2<f32>(share.x * below.x, share.y * above.y);
        workgroupBarrier();
    }
    return x;
}

// Lengths of every second edge: the thread of an edge's upper vertex moves both of its ends. Returns the pull of its edge.
fn lengths(lane: u32, k: u32, is_here: bool, rest_length: f32, batch: u32, pull: f32) -> f32 {
    var pulls = pull;
    if is_here && k >= N_PINNED + batch && (k - N_PINNED - batch) % 2u == 0u {
        let edge = x_of[lane] - x_of[lane - 1u];
        let w_below = select(1.0, 0.0, k - 1u < N_PINNED);
        let too_long = (1.0 - rest_length * inverse_length(edge)) / (1.0 + w_below);
        let correction = too_long * edge;
        pulls = clamp(pull + too_long * length(edge) / (chain.step_secs * chain.step_secs), 0.0, MOST_PULL);
        x_of[lane - 1u] += w_below * correction;
        x_of[lane] -= correction;
    }
    workgroupBarrier();
    return pulls;
}

// How far closing the lengths of all edges up to this vertex's own moves it: a sum from the root up, in doubling reaches.
fn closing(lane: u32, k: u32, is_free: bool, rest_length: f32) -> vec3<f32> {
    var moved = vec3<f32>(0.0);
    if is_free {
        let edge = x_of[lane] - x_of[lane - 1u];
        moved = edge * (rest_length * inverse_length(edge) - 1.0);
    }
    for (var far = 1u; far < asked.n_vertices; far *= 2u) {
        turn_of[lane] = moved;
        workgroupBarrier();
        if is_free && k >= N_PINNED + far {
            moved += turn_of[lane - far];
        }
        workgroupBarrier();
    }
    return moved;
}

// Keep edges out of thin colliders on their way from where the step began, every second one and then the others, by their upper
// vertices. Returns the vertex as a contact leaves it, its room 0 where it was moved.
fn edges(
    lane: u32,
    k: u32,
    is_free: bool,
    along: f32,
    prev: vec3<f32>,
    room: f32,
    before: Pose,
    after: Pose,
) -> Contacted {
    var contacted = Contacted(vec3<f32>(0.0), prev, room);
    for (var batch = 0u; batch < 2u; batch++) {
        if is_free && (k - N_PINNED) % 2u == batch {
            let start = Ends(begun_of[lane - 1u], begun_of[lane]);
            let free = x_of[lane];
            let of_edge = collide_edge(start, Ends(x_of[lane - 1u], free), prev, along, before, after);
            contacted = Contacted(of_edge.x - free, of_edge.prev, room);
            if any(of_edge.x != free) {
                x_of[lane] = of_edge.x;
                contacted.room = 0.0;
            }
        }
        workgroupBarrier();
    }
    return contacted;
}

// Towards the local shape, all at once from where the vertices were before; both ends of an edge move.
fn angles(lane: u32, is_free: bool, is_tip: bool, rest_below: vec3<f32>, rest_edge: vec3<f32>) {
    var turn = vec3<f32>(0.0);
    if is_free {
        let joint = x_of[lane - 1u];
        let goal = joint + turned_as(rest_below, joint - x_of[lane - 2u], rest_edge);
        turn = 0.5 * chain.shape * (goal - x_of[lane]);
    }
    turn_of[lane] = turn;
    workgroupBarrier();
    if is_free {
        var above = vec3<f32>(0.0);
        if !is_tip {
            above = turn_of[lane + 1u];
        }
        x_of[lane] += turn - above;
    }
    workgroupBarrier();
}

// All of a frame's steps for as many strands as have room in a workgroup. Twin of SimulatedLayer::run in sim/src/layer.rs.
@compute @workgroup_size(LANES)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let n = asked.n_vertices;
    let n_strands = max(LANES / n, 1u);
    let first_guide = (group.x + group.y * n_groups.x) * n_strands;
    if first_guide >= asked.n_guides {
        return;
    }
    let strand = lane / n;
    let k = lane % n;
    let is_here = strand < n_strands && first_guide + strand < asked.n_guides;
    let is_free = is_here && k >= N_PINNED;
    // Threads without a vertex read the first one's and write nothing.
    let i = select(0u, (first_guide + strand) * n + k, is_here);
    let place = rest[i].place;
    var x = s[i].x.xyz;
    var prev = s[i].prev.xyz;
    var begun = s[i].begun.xyz;
    var pull = s[i].x.w;
    if asked.carried == 1u {
        x = pose_apply(asked.carry, x);
        prev = pose_apply(asked.carry, prev);
        begun = pose_apply(asked.carry, begun);
    }
    var rest_edge = vec3<f32>(0.0);
    var rest_below = vec3<f32>(0.0);
    if is_free {
        rest_edge = place.xyz - rest[i - 1u].place.xyz;
        rest_below = rest[i - 1u].place.xyz - rest[i - 2u].place.xyz;
    }
    let rest_length = length(rest_edge);
    let along = f32(k) / f32(n - 1u);
    // How far from a contact the vertex was when the step began.
    var room = 0.0;
    for (var step = 0u; step < asked.n_steps; step++) {
        contact_step(step, asked.n_steps);
        let before = asked.poses[step];
        let after = asked.poses[step + 1u];
        begun = x;
        var carried = pose_apply(asked.carries[step], x);
        let to = integrate(k, x, prev, rest[i], carried, after);
        let w_below = select(0.0, chain.step_secs * chain.step_secs * pull / max(rest_length, SHORTEST), is_free);
        let moved = hold(k, take_pulls(lane, k, is_here, to, w_below), rest[i], after);
        prev = x;
        if is_here {
            x_of[lane] = moved;
            begun_of[lane] = begun;
        }
        workgroupBarrier();
        let turned_below = rotate(after.rotation, rest_below);
        let turned_edge = rotate(after.rotation, rest_edge);
        for (var iteration = 0u; iteration < chain.n_iterations; iteration++) {
            pull = lengths(lane, k, is_here, rest_length, 0u, pull);
            pull = lengths(lane, k, is_here, rest_length, 1u, pull);
            angles(lane, is_free, k + 1u == n, turned_below, turned_edge);
            if is_free {
                let free = x_of[lane];
                let way = STEEPEST * contact_way(free, prev, carried);
                if room <= way {
                    let contacted = contact_collide(free, prev, place.w, along, before, carried, after);
                    x_of[lane] = contacted.x;
                    room = max(room, contacted.room - way);
                    if any(contacted.x != free) {
                        prev = contacted.prev;
                        carried = pose_apply(asked.carries[step], prev);
                        room = 0.0;
                    }
                }
            }
            workgroupBarrier();
            if THIN_COLLIDERS == 1u {
                let of_edge = edges(lane, k, is_free, along, prev, room, before, after);
                prev = of_edge.prev;
                room = of_edge.room;
                carried = pose_apply(asked.carries[step], prev);
            }
        }
        // Put every vertex at its distance from the one below, and out of all obstacles, without giving velocity.
        var is_closed = !is_free;
        if is_here {
            room = max(room - STEEPEST * contact_way(x_of[lane], prev, carried), 0.0);
        }
        for (var again = 0u; again < CLOSINGS; again++) {
            let moved_by = closing(lane, k, is_free, rest_length);
            if is_here && k == 0u {
                atomicStore(&is_open[strand], 0u);
            }
            if lane == 0u {
                is_any_open = 0u;
            }
            workgroupBarrier();
            if !is_closed {
                let start = x_of[lane];
                let closed = start + moved_by;
                let way = STEEPEST * distance(start, closed);
                x_of[lane] = closed;
                if room > way {
                    room -= way;
                } else {
                    room = 0.0;
                    let kept = contact_keep_out(start, closed, place.w, along, after);
                    x_of[lane] = kept;
                    prev += kept - closed;
                    if distance(kept, closed) >= CLOSED {
                        atomicStore(&is_open[strand], 1u);
                    }
                }
            }
            workgroupBarrier();
            if THIN_COLLIDERS == 1u {
                let of_edge = edges(lane, k, is_free && !is_closed, along, prev, room, before, after);
                room = of_edge.room;
                prev += of_edge.x;
                if length(of_edge.x) >= CLOSED {
                    atomicStore(&is_open[strand], 1u);
                }
                workgroupBarrier();
            }
            if !is_closed && atomicLoad(&is_open[strand]) == 1u {
                is_any_open = 1u;
            } else {
                is_closed = true;
            }
            if workgroupUniformLoad(&is_any_open) == 0u {
                break;
            }
        }
        if is_here {
            x = x_of[lane];
            let styled = pose_apply(after, place.xyz);
            carried = pose_apply(asked.carries[step], prev);
            let aside = max(dot(x - styled, x - styled), dot(x - carried, x - carried));
            x = select(x, styled, aside < AT_REST * AT_REST);
        }
    }
    // A strand that is not finite starts again from rest: once a frame, after its steps.
    if is_here {
        atomicStore(&is_broken[strand], 0u);
    }
    workgroupBarrier();
    let d = abs(x - prev);
    // False for NaN and infinity too.
    if is_here && !(d.x + d.y + d.z < 1e13) {
        atomicStore(&is_broken[strand], 1u);
    }
    workgroupBarrier();
    if is_here {
        if atomicLoad(&is_broken[strand]) == 1u {
            x = pose_apply(asked.poses[asked.n_steps], place.xyz);
            prev = x;
            begun = x;
            pull = rest[i].support.w;
        }
        s[i] = ChainVertex(vec4<f32>(x, pull), vec4<f32>(prev, 0.0), vec4<f32>(begun, 0.0));
        positions[i] = shown_at(k, place.xyz, x, begun);
    }
}
