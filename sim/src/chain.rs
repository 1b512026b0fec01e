//! Chains: the law of one strand over one step as the references have it. Twin of `sim_chain.wgsl`: same names, same order.
//!
//! Vertices are equal masses, integrated by Verlet's rule and then corrected in position, iteration by iteration (SIGGRAPH
//! 2010 course on real-time hair, "one simulation step"; Chen 2014, 3.2; the Nalu demo): lengths in two batches whose edges
//! share no vertex, angular constraints towards the local shape at rest, contacts. Every vertex of a batch can be moved at
//! once, so on the GPU a thread takes two vertices, and a workgroup as many strands as have room.
//!
//! By themselves those spread a pull by two vertices an iteration, so that long hair stretches by a fifth under its own
//! weight and more when it is shaken, and every style sags when time starts (measured). Three things keep that from it:
//!
//! - **The pull of an edge is kept.** What its corrections come to in a step is the force in it, and most of what it will
//!   be in the next; the next begins with it, as springs across the edges, solved at once (`take_pulls`), and iterations
//!   have the change alone to find.
//! - **Lengths are closed** at the end of a step, in the directions that edges have, in turn with contacts.
//! - **The style rests.** At bind time every edge gets the pull of the weight that hangs on it, and what it cannot carry
//!   so is carried by a force that turns with the head.
//!
//! What remains is that stiffness is a matter of iterations and of the step: hair that has left its style hangs otherwise at
//! other steps. Rods are the default for that.

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::simulation::SimulationSettings;

use crate::air::Air;
use crate::bounded;
use crate::contact::{Obstacles, STEEPEST};
use crate::pose::{Pose, clamp_length, inverse_length, rotate, turned_as};
use crate::pull::PullParams;
use crate::rest::Exposure;
use crate::rod::{MAX_SPEED, N_PINNED};

/// Largest pull of an edge over its vertex's mass, cm/s2: a thousand times gravity.
const MOST_PULL: f32 = 1e6;
/// Shortest edge that pulls, cm.
const SHORTEST: f32 = 1e-4;
/// Times in a step that lengths are closed where obstacles keep moving vertices, and what they may move without: cm.
const CLOSINGS: usize = 8;
const CLOSED: f32 = 0.002;
/// As near as this to the style, and to where it was, a vertex is put to the style: hair at rest stays to the last bit, cm.
const AT_REST: f32 = 5e-5;

/// Vertices that a thread of the twin takes.
pub const BLOCK: u32 = 2;

/// [`SimulationSettings`] made ready for steps. Layout of `ChainParams` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ChainParams {
    /// Displacement by gravity in a step, cm.
    pub gravity_step: [f32; 3],
    pub step_secs: f32,
    /// Share of the velocity relative to the head that a step keeps.
    pub keep: f32,
    /// Share of the air's velocity that a step takes up.
    pub take_up: f32,
    /// Share of the distance from the local shape that an iteration takes away.
    pub shape: f32,
    pub n_iterations: u32,
}

impl ChainParams {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let dt = 1.0 / bounded(settings.steps_per_second, default.steps_per_second, 15.0, 2000.0);
        let gravity = bounded(settings.gravity, default.gravity, -1e4, 1e4);
        Self {
            gravity_step: [0.0, -gravity * dt * dt, 0.0],
            step_secs: dt,
            keep: (-bounded(settings.damping, default.damping, 0.0, 1e3) * dt).exp(),
            take_up: 1.0 - (-bounded(settings.drag, default.drag, 0.0, 1e3) * dt).exp(),
            shape: bounded(settings.shape, default.shape, 0.0, 1.0),
            n_iterations: settings.n_iterations.clamp(1, 64),
        }
    }
}

/// What does not change while a strand moves. Layout of `ChainRest` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ChainRest {
    /// xyz head space, w the distance from the obstacles at rest.
    pub place: Vec4,
    /// Stiffness over mass by which it is held to the style, 1/s2; share of the wind that it feels.
    pub numbers: Vec4,
    /// xyz what carries it beside its own strand, head space, w the pull of the edge below over its mass, at rest: cm/s2.
    pub support: Vec4,
}

/// Make one strand of [`Rest`](crate::rest::Rest) ready. The style is the shape under gravity: an edge pulls by the weight
/// that hangs on it, and what it cannot carry so is carried by a force that turns with the head. Where `is_weightless` the
/// style is the shape without, and nothing carries it.
pub fn rest_of(places: &[Vec4], exposures: &[Exposure], p: &ChainParams, is_weightless: bool) -> Vec<ChainRest> {
    let of = |(&place, exposure): (&Vec4, &Exposure)| ChainRest {
        place,
        numbers: Vec4::new(exposure.hold, exposure.wind, 0.0, 0.0),
        support: Vec4::ZERO,
    };
    let mut rest: Vec<ChainRest> = places.iter().zip(exposures).map(of).collect();
    if is_weightless {
        return rest;
    }
    let gravity = Vec3::from_array(p.gravity_step) / (p.step_secs * p.step_secs);
    let mut above = Vec3::ZERO;
    for k in (N_PINNED..rest.len()).rev() {
        let edge = places[k].xyz() - places[k - 1].xyz();
        let along = edge * inverse_length(edge);
        let load = gravity + above;
        let pull = load.dot(along).clamp(0.0, MOST_PULL);
        rest[k].support = (pull * along - load).extend(pull);
        above = pull * along;
    }
    rest
}

/// State of one vertex. Layout of `ChainVertex` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ChainVertex {
    /// xyz world, cm; w the pull of the edge below over the vertex's mass in the last step, cm/s2.
    pub x: Vec4,
    /// A step ago; a contact moves it where it takes velocity.
    pub prev: Vec4,
    /// Where the last step began.
    pub begun: Vec4,
}

/// At rest on a head at `pose`.
pub fn at_rest(rest: &ChainRest, pose: Pose) -> ChainVertex {
    let x = pose.apply(rest.place.xyz());
    ChainVertex { x: x.extend(rest.support.w), prev: x.extend(0.0), begun: x.extend(0.0) }
}

/// Move everything rigidly.
pub fn carry(s: &mut [ChainVertex], carry: Pose) {
    let moved = |x: Vec4| carry.apply(x.xyz()).extend(x.w);
    for vertex in s {
        *vertex = ChainVertex { x: moved(vertex.x), prev: moved(vertex.prev), begun: moved(vertex.begun) };
    }
}

/// One step: the head goes from `before` to `after`. `rooms`: how far from a contact each vertex is at the beginning and at the
/// end of it; 0 where that is not known.
pub fn step_chain(
    s: &mut [ChainVertex],
    rest: &[ChainRest],
    p: &ChainParams,
    air: &Air,
    obstacles: Obstacles<'_>,
    pull: &PullParams,
    before: Pose,
    after: Pose,
    rooms: &mut [f32],
) {
    let carry = after.after_inverse_of(&before);
    integrate(s, rest, p, air, pull, carry, after);
    for _ in 0..p.n_iterations {
        lengths(s, rest, p, 0);
        lengths(s, rest, p, 1);
        angles(s, rest, p, after);
        contacts(s, rest, obstacles, [before, carry, after], rooms);
        edges(s, obstacles, [before, after], rooms, true);
    }
    for k in 0..s.len() {
        let (x, prev) = (s[k].x.xyz(), s[k].prev.xyz());
        rooms[k] = (rooms[k] - STEEPEST * obstacles.way(x, prev, carry.apply(prev))).max(0.0);
    }
    for _ in 0..CLOSINGS {
        if close_lengths(s, rest, obstacles, [before, after], rooms) < CLOSED {
            break;
        }
    }
    for k in 0..s.len() {
        let (x, prev, styled) = (s[k].x.xyz(), s[k].prev.xyz(), after.apply(rest[k].place.xyz()));
        if x.distance_squared(styled).max(x.distance_squared(carry.apply(prev))) < AT_REST * AT_REST {
            s[k].x = styled.extend(s[k].x.w);
        }
    }
}

/// Verlet's rule with gravity and air, the pulls of the edges and of a hand, then the hold to the style. Pinned vertices go
/// with the head.
fn integrate(
    s: &mut [ChainVertex],
    rest: &[ChainRest],
    p: &ChainParams,
    air: &Air,
    pull: &PullParams,
    carry: Pose,
    after: Pose,
) {
    let n = s.len();
    let squared_step = p.step_secs * p.step_secs;
    let mut to: Vec<Vec3> = Vec::with_capacity(n);
    let mut pulled = vec![0.0; n];
    for k in 0..n {
        if k < N_PINNED {
            to.push(after.apply(rest[k].place.xyz()));
            continue;
        }
        let x = s[k].x.xyz();
        let carried = carry.apply(x);
        let with_head = carried - x;
        let mut v = with_head + p.keep * (x - s[k].prev.xyz() - with_head);
        v += p.take_up * (rest[k].numbers.y * p.step_secs * air.velocity(x) - v);
        let forces = squared_step * rotate(after.rotation, rest[k].support.xyz());
        let free = x + clamp_length(v, MAX_SPEED * p.step_secs) + (Vec3::from_array(p.gravity_step) + forces);
        let (pull_way, strength) = pull.on(k, n, rest[k].place.xyz(), carried, after);
        pulled[k] = squared_step * strength;
        to.push(free + pulled[k] * (carried + pull_way));
    }
    take_pulls(&mut to, &pulled, s, rest, squared_step);
    for k in 0..n {
        let mut moved = to[k];
        if k >= N_PINNED {
            let stiffness = squared_step * rest[k].numbers.x;
            moved += (after.apply(rest[k].place.xyz()) - moved) * (stiffness / (1.0 + stiffness));
        }
        s[k].prev = s[k].x.xyz().extend(0.0);
        s[k].x = moved.extend(s[k].x.w);
    }
}

/// Where vertices go that a hand of stiffness `pulled`, in units of the step's inertia, holds on their way to `to` over one more
/// than that. An edge that pulls with a force is a spring without a length whose stiffness is the force over the length of the
/// edge, across the edge as along it. Implicit, one equation with three unknowns a vertex, so that it is stable at any step;
/// at rest it is where the style is. The twin halves the equations instead, so that all its threads are at work.
fn take_pulls(to: &mut [Vec3], pulled: &[f32], s: &[ChainVertex], rest: &[ChainRest], squared_step: f32) {
    let n = to.len();
    let stiffness = |k: usize| if k < n { squared_step * s[k].x.w / rest_length(rest, k).max(SHORTEST) } else { 0.0 };
    let mut above = vec![0.0; n];
    for k in N_PINNED..n {
        let (w_below, w_above) = (stiffness(k), stiffness(k + 1));
        let scale = 1.0 / (1.0 + pulled[k] + w_below + w_above - w_below * above[k - 1]);
        above[k] = scale * w_above;
        to[k] = scale * (to[k] + w_below * to[k - 1]);
    }
    for k in (N_PINNED..n.saturating_sub(1)).rev() {
        let next = to[k + 1];
        to[k] += above[k] * next;
    }
}

/// Of the edge below vertex `k`, cm.
fn rest_length(rest: &[ChainRest], k: usize) -> f32 {
    rest[k].place.xyz().distance(rest[k - 1].place.xyz())
}

/// Lengths of every second edge: the edges of one batch share no vertex. What corrects an edge adds to its pull.
fn lengths(s: &mut [ChainVertex], rest: &[ChainRest], p: &ChainParams, batch: usize) {
    for k in (N_PINNED + batch..s.len()).step_by(2) {
        let edge = s[k].x.xyz() - s[k - 1].x.xyz();
        let rest_length = rest_length(rest, k);
        let w_below = if k - 1 < N_PINNED { 0.0 } else { 1.0 };
        let too_long = (1.0 - rest_length * inverse_length(edge)) / (1.0 + w_below);
        let correction = too_long * edge;
        let pull = s[k].x.w + too_long * edge.length() / (p.step_secs * p.step_secs);
        s[k - 1].x += (w_below * correction).extend(0.0);
        s[k].x = (s[k].x.xyz() - correction).extend(pull.clamp(0.0, MOST_PULL));
    }
}

/// Keep vertices out of the head and the colliders.
fn contacts(
    s: &mut [ChainVertex],
    rest: &[ChainRest],
    obstacles: Obstacles<'_>,
    [before, carry, after]: [Pose; 3],
    rooms: &mut [f32],
) {
    for k in N_PINNED..s.len() {
        let along = k as f32 / (s.len() - 1) as f32;
        let (free, prev) = (s[k].x.xyz(), s[k].prev.xyz());
        let way = STEEPEST * obstacles.way(free, prev, carry.apply(prev));
        if rooms[k] <= way {
            let contacted = obstacles.collide(free, prev, rest[k].place.w, along, before, after);
            s[k].x = contacted.x.extend(s[k].x.w);
            rooms[k] = rooms[k].max(contacted.room - way);
            if contacted.x != free {
                s[k].prev = contacted.prev.extend(0.0);
                rooms[k] = 0.0;
            }
        }
    }
}

/// Keep edges out of thin colliders on their way from where the step began, every second one and then the others, by their upper
/// vertices; returns how far these moved the farthest, cm. In a contact a vertex loses velocity, in a correction it keeps
/// what it has.
fn edges(
    s: &mut [ChainVertex],
    obstacles: Obstacles<'_>,
    [before, after]: [Pose; 2],
    rooms: &mut [f32],
    is_contact: bool,
) -> f32 {
    let mut farthest = 0.0_f32;
    if !obstacles.has_thin() {
        return farthest;
    }
    for batch in 0..2 {
        for k in (N_PINNED + batch..s.len()).step_by(2) {
            let along = k as f32 / (s.len() - 1) as f32;
            let start = [s[k - 1].begun.xyz(), s[k].begun.xyz()];
            let (free, prev) = (s[k].x.xyz(), s[k].prev.xyz());
            let contacted = obstacles.collide_edge(start, [s[k - 1].x.xyz(), free], prev, along, before, after);
            if contacted.x != free {
                let moved = contacted.x - free;
                let prev = if is_contact { contacted.prev } else { prev + moved };
                s[k].x = contacted.x.extend(s[k].x.w);
                s[k].prev = prev.extend(0.0);
                rooms[k] = 0.0;
                farthest = farthest.max(moved.length());
            }
        }
    }
    farthest
}

/// Put every vertex at its distance from the one below, in the direction that it has, and out of all obstacles, without
/// giving velocity; returns how far obstacles moved the farthest, cm.
fn close_lengths(
    s: &mut [ChainVertex],
    rest: &[ChainRest],
    obstacles: Obstacles<'_>,
    [before, after]: [Pose; 2],
    rooms: &mut [f32],
) -> f32 {
    let mut farthest = 0.0_f32;
    let mut moved = Vec3::ZERO;
    let mut below = s[N_PINNED - 1].x.xyz();
    for k in N_PINNED..s.len() {
        let start = s[k].x.xyz();
        let edge = start - below;
        below = start;
        let rest_length = rest_length(rest, k);
        moved += edge * (rest_length * inverse_length(edge) - 1.0);
        let closed = start + moved;
        s[k].x = closed.extend(s[k].x.w);
        let way = STEEPEST * start.distance(closed);
        if rooms[k] > way {
            rooms[k] -= way;
            continue;
        }
        rooms[k] = 0.0;
        let along = k as f32 / (s.len() - 1) as f32;
        let kept = obstacles.keep_out(start, closed, rest[k].place.w, along, after);
        farthest = farthest.max(kept.distance(closed));
        s[k].x = kept.extend(s[k].x.w);
        s[k].prev += (kept - closed).extend(0.0);
    }
    farthest.max(edges(s, obstacles, [before, after], rooms, false))
}

/// Towards the local shape: where the turn of the edge below would take the edge above it. All at once, from where vertices
/// were before; both ends of an edge move, so that the strand as a whole does not: a strand whose upper ends alone are
/// moved whips itself up (measured: a slow shake stretched it by a fifth).
fn angles(s: &mut [ChainVertex], rest: &[ChainRest], p: &ChainParams, after: Pose) {
    let turns: Vec<Vec3> = (0..s.len())
        .map(|k| {
            if k < N_PINNED {
                return Vec3::ZERO;
            }
            let rest_below = rotate(after.rotation, rest[k - 1].place.xyz() - rest[k - 2].place.xyz());
            let rest_edge = rotate(after.rotation, rest[k].place.xyz() - rest[k - 1].place.xyz());
            let (below, joint) = (s[k - 2].x.xyz(), s[k - 1].x.xyz());
            let by_below = inverse_length(rest_below);
            let along_below = by_below * rest_below.dot(rest_edge);
            let goal = joint + turned_as(rest_below, by_below, along_below, joint - below, rest_edge);
            0.5 * p.shape * (goal - s[k].x.xyz())
        })
        .collect();
    for k in N_PINNED..s.len() {
        let above = turns.get(k + 1).copied().unwrap_or(Vec3::ZERO);
        s[k].x += (turns[k] - above).extend(0.0);
    }
}

/// A strand that is not finite starts again from rest: once a frame, after its steps.
pub fn recover(s: &mut [ChainVertex], rest: &[ChainRest], after: Pose) {
    let mut sum = 0.0;
    for vertex in s.iter() {
        sum += (vertex.x.xyz() - vertex.prev.xyz()).abs().element_sum();
    }
    // False for NaN and infinity too.
    if sum < 1e15 {
        return;
    }
    for (vertex, rest) in s.iter_mut().zip(rest) {
        *vertex = at_rest(rest, after);
    }
}
