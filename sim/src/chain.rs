//! Chains: the law of one strand over one step as the references have it. Twin of `sim_chain.wgsl`: same names, same order.
//!
//! Vertices are equal masses, integrated by Verlet's rule and then corrected in position, iteration by iteration (SIGGRAPH
//! 2010 course on real-time hair, "one simulation step"; Chen 2014, 3.2; the Nalu demo): lengths in two batches whose edges
//! share no vertex, angular constraints towards the local shape at rest, contacts. Every vertex of a batch can be moved at
//! once, so on the GPU a thread takes a vertex, and a workgroup as many strands as have room.
//!
//! It is what it is: a pull spreads by two vertices an iteration, so long chains stretch when shaken; stiffness depends on
//! iterations and step; and the style sags where the shape is weak. Rods are the default for those reasons.

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::simulation::SimulationSettings;

use crate::air::Air;
use crate::bounded;
use crate::contact::{Obstacles, STEEPEST};
use crate::pose::{Pose, clamp_length, inverse_length, rotate, turned_as};
use crate::pull::PullParams;
use crate::rod::{MAX_SPEED, N_PINNED};

/// A hand leads a vertex no faster, cm/s, and gives it no velocity: as a force, or faster, it makes the chain swing about
/// the hand for as long as it holds it (measured: edges 40 % too long). So a chain comes to the hand only where its weight
/// and its shape let it.
const PULL_SPEED: f32 = 60.0;

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
}

/// State of one vertex. Layout of `ChainVertex` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ChainVertex {
    /// World, cm.
    pub x: Vec4,
    /// A step ago; a contact moves it where it takes velocity.
    pub prev: Vec4,
    /// Where the last step began.
    pub begun: Vec4,
}

/// At rest on a head at `pose`.
pub fn at_rest(place: Vec4, pose: Pose) -> ChainVertex {
    let x = pose.apply(place.xyz()).extend(0.0);
    ChainVertex { x, prev: x, begun: x }
}

/// Move everything rigidly.
pub fn carry(s: &mut [ChainVertex], carry: Pose) {
    let moved = |x: Vec4| carry.apply(x.xyz()).extend(0.0);
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
        lengths(s, rest, 0);
        lengths(s, rest, 1);
        angles(s, rest, p, after);
        for k in N_PINNED..s.len() {
            let along = k as f32 / (s.len() - 1) as f32;
            let (free, prev) = (s[k].x.xyz(), s[k].prev.xyz());
            let way = STEEPEST * obstacles.way(free, prev, carry.apply(prev));
            if rooms[k] <= way {
                let contacted = obstacles.collide(free, prev, rest[k].place.w, along, before, after);
                s[k].x = contacted.x.extend(0.0);
                rooms[k] = rooms[k].max(contacted.room - way);
                if contacted.x != free {
                    s[k].prev = contacted.prev.extend(0.0);
                    rooms[k] = 0.0;
                }
            }
        }
    }
    for (vertex, room) in s.iter().zip(rooms) {
        let (x, prev) = (vertex.x.xyz(), vertex.prev.xyz());
        *room = (*room - STEEPEST * obstacles.way(x, prev, carry.apply(prev))).max(0.0);
    }
}

/// Verlet's rule with gravity, air and the hold to the style. Pinned vertices go with the head.
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
    for k in 0..n {
        let x = s[k].x.xyz();
        let styled = after.apply(rest[k].place.xyz());
        let mut moved = styled;
        if k >= N_PINNED {
            let with_head = carry.apply(x) - x;
            let mut v = with_head + p.keep * (x - s[k].prev.xyz() - with_head);
            let [hold, exposed, ..] = rest[k].numbers.to_array();
            v += p.take_up * (exposed * p.step_secs * air.velocity(x) - v);
            moved = x + clamp_length(v, MAX_SPEED * p.step_secs) + Vec3::from_array(p.gravity_step);
            let stiffness = hold * p.step_secs * p.step_secs;
            moved += (styled - moved) * (stiffness / (1.0 + stiffness));
            let (pull_way, strength) = pull.on(k, n, rest[k].place.xyz(), x + with_head, after);
            let pulled = strength * p.step_secs * p.step_secs;
            let led = x + with_head + clamp_length(pull_way, PULL_SPEED * p.step_secs);
            moved += (led - moved) * (pulled / (1.0 + pulled));
        }
        s[k].prev = s[k].x;
        s[k].x = moved.extend(0.0);
    }
}

/// Lengths of every second edge: the edges of one batch share no vertex.
fn lengths(s: &mut [ChainVertex], rest: &[ChainRest], batch: usize) {
    for k in (N_PINNED + batch..s.len()).step_by(2) {
        let edge = s[k].x.xyz() - s[k - 1].x.xyz();
        let rest_length = rest[k].place.xyz().distance(rest[k - 1].place.xyz());
        let w_below = if k - 1 < N_PINNED { 0.0 } else { 1.0 };
        let correction = edge * ((1.0 - rest_length * inverse_length(edge)) / (1.0 + w_below));
        s[k - 1].x += (w_below * correction).extend(0.0);
        s[k].x -= correction.extend(0.0);
    }
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
            let goal = joint + turned_as(rest_below, joint - below, rest_edge);
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
        *vertex = at_rest(rest.place, after);
    }
}
