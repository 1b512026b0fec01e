//! Rods: the law of one strand over one step, exact in length and implicit in everything stiff. Twin of `sim_rod.wgsl`:
//! same names, same order.
//!
//! A strand is a chain of straight edges, each with an orthonormal frame whose third axis is the edge. The unknowns of a
//! step are the rotations omega of the edges, not the places of the vertices: so lengths are exact whatever happens, and
//! twist is there. One Newton step of implicit Euler minimises the quadratic
//!
//! ```text
//!   sum_j  1/2 d_j |dx_j|^2 - r_j . dx_j                          inertia, damping, drag, hold, gravity
//! + sum_k  1/2 beta_k |omega_k - omega_k-1|^2 + h^2 M_k . (omega_k - omega_k-1)    bending and twist
//! ```
//!
//! with dx_k+1 = dx_k + omega_k x e_k. It is solved exactly in two sweeps: from tip to root every edge is eliminated, which
//! leaves an articulated inertia (Featherstone 1983) of what is above; from root to tip the rotations follow. Therefore
//! nothing depends on iterations, stiffness costs nothing, and no step is too long: a cantilever hangs as the elastica
//! does at 30 steps a second as at 960, with 16 vertices as with 64 (sim/tests/solver/rods.rs).
//!
//! **Bending and twist.** The energy of joint k is 4 B/l (1 - w), where w is the real part of the rotation by which the
//! joint differs from its rest: B/l theta^2 / 2 for small angles theta, and a moment that grows up to half a turn. Twist is
//! as stiff as bending (of a solid fibre it is 1 / (1 + Poisson's ratio) = 0.7 of it), so that the energy knows no axis
//! and its second derivative is bounded by beta = h^2 B/l in every direction.
//!
//! **Tension.** Transverse waves of a taut strand are stiff too. Their second derivative, (N . e)(I - t t^T) for the force
//! N in an edge, is added from the forces and the accelerations of the step before.
//!
//! **Contact** is within the solve where a vertex presses on what it lies on: a stiff term along the normal, and friction
//! across it, whose force is that of the step before over how fast it slips. Whether it presses needs no memory of its own:
//! the acceleration that is kept is without the contact's force, so it points into the obstacle for as long as the vertex
//! leans on it. What a step meets anew, or has not quite kept out, is pushed out after it and lengths are closed again.
//! With that alone weight hung on places which a step corrects afterwards: a drape over the head depended on the step (5.7 %
//! of its length between 30 and 240 steps a second, now 0.1 %).
//!
//! **Rest** (sim/src/rod_rest.rs) is made when a style is bound, so that it does not sag.
//!
//! Rejected after trying: positions with multipliers of length (XPBD, or one banded system with the lengths): in 32 bits
//! the product of a stiff length and a stiff bend leaves no digits for the inertia, and 64 vertices in 10 cm explode;
//! bending solved apart from lengths: equilibria then depend on the step, and curls on the split.

use glam::{Mat3, Quat, Vec3, Vec3Swizzles, Vec4Swizzles};
use lorelei_core::simulation::SimulationSettings;

use crate::air::Air;
use crate::bounded;
use crate::contact::{Barrier, Contacted, Obstacles, STEEPEST};
use crate::pose::{Pose, clamp_length, rotate, shortest_turn};
use crate::pull::PullParams;
use crate::rod_rest::{MIN_EDGE, RodRest, at_rest, half_lengths, joint_length};

/// Vertices at the root that follow the head: the root, and the next one for the growing direction.
pub const N_PINNED: usize = 2;
/// Strands that `sim_rod.wgsl` keeps side by side: threads of its workgroups.
pub(crate) const LANES: usize = 32;
/// Drag along a slender body over that across it (slender-body theory).
const DRAG_ALONG: f32 = 0.5;
/// How much stiffer than its own inertia a vertex is kept out of what it lies on, and from slipping where friction holds it:
/// what is left to correct after the step is a hundredth of what gravity would do in it. Without, a drape at 30 steps a
/// second differs from one at 240 by 5.7 % of its length; with it by 0.1 %.
/// Friction four times as stiff would let hair that lies creep less, but it chatters: fastest 1.9 cm/s where it is 0.14
/// (hair_that_lies_under_friction_stays).
const KEEPS_OUT: f32 = 100.0;
/// A vertex is pushed out within the solve by no more than this, and from no farther pressed against anything, cm: the rest is
/// done after the step.
const NEARBY: f32 = 0.1;
/// Times that a strand which is held is closed from both ends.
const REACHES: usize = 8;
/// An edge stretched by an obstacle to this many times its length is held.
const HELD: f32 = 1.2;
/// Faster hair is not seen, only missed: cm/s.
pub(crate) const MAX_SPEED: f32 = 3000.0;
/// Most that an edge turns relative to the head in a step, radians.
const MAX_TURN: f32 = 1.0;
/// Turns below this are rounding, not movement (measured at rest: 3e-7), radians a step.
const STILL: f32 = 2e-6;
/// Turns below this, as near as this to the style, end in the style: hair at rest stays to the last bit. Radians, and cm.
const AT_REST: f32 = 2e-5;
/// Twist inertia over that of bending: keeps the tip's twist determined.
const SPIN: f32 = 1e-3;
/// Standard gravity, by which `bend_length` becomes a stiffness; not the scene's gravity, cm/s2.
pub(crate) const STANDARD_GRAVITY: f32 = 981.0;

/// [`SimulationSettings`] made ready for steps: finite and bounded. Layout of `RodParams` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RodParams {
    /// cm/s2.
    pub gravity: [f32; 3],
    pub step_secs: f32,
    /// Bending stiffness over mass a centimetre, cm4/s2.
    pub bend: f32,
    /// Time over which bending is damped, s.
    pub bend_damping: f32,
    /// Of the velocity relative to the head, across and along the hair, 1/s.
    pub damping: f32,
    pub damping_along: f32,
    /// By the air, across the hair, 1/s.
    pub drag: f32,
    /// Corrections of a contact in a step.
    pub n_iterations: u32,
    pub pad: [u32; 2],
}

impl RodParams {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let step_secs = 1.0 / bounded(settings.steps_per_second, default.steps_per_second, 15.0, 2000.0);
        let bend_length = bounded(settings.bend_length, default.bend_length, 0.0, 100.0);
        Self {
            gravity: [0.0, -bounded(settings.gravity, default.gravity, -1e4, 1e4), 0.0],
            step_secs,
            // A lock of length l under its own weight bends by about 1 where l^3 g = B: B = g l^3.
            bend: STANDARD_GRAVITY * bend_length.powi(3),
            bend_damping: bounded(settings.bend_damping, default.bend_damping, 0.0, 1.0),
            damping: bounded(settings.damping, default.damping, 0.0, 1e3),
            damping_along: bounded(settings.damping_along, default.damping_along, 0.0, 1e3),
            drag: bounded(settings.drag, default.drag, 0.0, 1e3),
            n_iterations: settings.n_iterations.clamp(1, 64),
            pad: [0; 2],
        }
    }
}

/// State of one vertex. Layout of a vertex's four in `s` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RodVertex {
    /// World, cm.
    pub x: Vec3,
    begun_x: f32,
    /// A step ago; a contact moves it where it takes velocity.
    pub prev: Vec3,
    begun_y: f32,
    /// Over the last step, cm/s2.
    pub acceleration: Vec3,
    begun_z: f32,
    /// Of the edge above, world.
    pub frame: Quat,
}

impl RodVertex {
    /// Where the last step began.
    pub fn begun(&self) -> Vec3 {
        Vec3::new(self.begun_x, self.begun_y, self.begun_z)
    }

    /// See [`RodVertex::begun`].
    pub fn set_begun(&mut self, begun: Vec3) {
        [self.begun_x, self.begun_y, self.begun_z] = begun.to_array();
    }
}

/// Move everything rigidly.
pub fn carry(s: &mut [RodVertex], carry: Pose) {
    for vertex in s {
        vertex.set_begun(carry.apply(vertex.begun()));
        vertex.x = carry.apply(vertex.x);
        vertex.prev = carry.apply(vertex.prev);
        vertex.frame = (carry.rotation * vertex.frame).normalize();
    }
}

/// A matrix that is its own transpose.
#[derive(Debug, Clone, Copy, Default)]
struct Symmetric {
    diagonal: Vec3,
    /// yz, xz, xy.
    off: Vec3,
}

/// What is kept of a strand from sweep to sweep, and from step to step of a frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Eliminated {
    /// What the sweep to the root leaves for the sweep to the tip: omega_k = gain omega_k-1 - turn - lever dx_k.
    gain: Symmetric,
    lever: Mat3,
    turn: Vec3,
    /// How far vertex k is from a contact, cm; 0 where that is not known.
    pub room: f32,
    /// Vertex k presses on what it lies on.
    presses: bool,
}

/// One step: the head goes from `before` to `after`.
pub fn step_rod(
    s: &mut [RodVertex],
    rest: &[RodRest],
    p: &RodParams,
    air: &Air,
    obstacles: Obstacles<'_>,
    pull: &PullParams,
    before: Pose,
    after: Pose,
    eliminated: &mut [Eliminated],
) {
    let carry = after.after_inverse_of(&before);
    sweep_to_root(s, rest, p, air, obstacles, pull, [carry, after], eliminated);
    if sweep_to_tip(s, rest, p, obstacles, [before, carry, after], eliminated) {
        close_lengths(s, rest, p, obstacles, after, eliminated);
    }
}

/// Frame of an edge that goes rigidly with the head: what it has of its own is found against that.
fn carried_frame(s: &[RodVertex], rest: &[RodRest], k: usize, carry: Pose, after: Pose) -> Quat {
    let turned = if k == 0 { after.rotation * rest[0].frame } else { carry.rotation * s[k].frame };
    turned.normalize()
}

/// Eliminate every edge from tip to root.
fn sweep_to_root(
    s: &[RodVertex],
    rest: &[RodRest],
    p: &RodParams,
    air: &Air,
    obstacles: Obstacles<'_>,
    pull: &PullParams,
    [carry, after]: [Pose; 2],
    out: &mut [Eliminated],
) {
    let n = s.len();
    let h = p.step_secs;
    let gravity = Vec3::from_array(p.gravity);
    let (across, along) = (p.damping + p.drag, p.damping_along + DRAG_ALONG * p.drag);
    // The articulated inertia: 1/2 dx.A dx + dx.B omega + 1/2 omega.C omega + px.dx + pw.omega.
    let (mut a, mut b, mut c) = (Symmetric::default(), Mat3::ZERO, Symmetric::default());
    let (mut px, mut pw) = (Vec3::ZERO, Vec3::ZERO);
    let mut load = Vec3::ZERO;
    let mut frame = if n > 2 { carried_frame(s, rest, n - 2, carry, after) } else { Quat::IDENTITY };
    let mut length_above = 0.0;
    for k in (1..n.saturating_sub(1)).rev() {
        let j = k + 1;
        let frame_below = carried_frame(s, rest, k - 1, carry, after);
        let length = rest[k].length;
        let t = rotate(frame, Vec3::Z);
        let e = length * t;
        // Compute what drives vertex j, relative to going rigidly with the head.
        let x = s[j].x;
        let carried = carry.apply(x);
        let own = clamp_length(2.0 * x - s[j].prev - carried, MAX_SPEED * h);
        let [stiffness, exposed] = rest[j].exposure();
        let mass = half_lengths(length, length_above);
        let to_style = after.apply(rest[j].place.xyz()) - carried;
        let (pull_way, pulled) = pull.on(j, n, rest[j].place.xyz(), carried, after);
        let held = gravity + rotate(after.rotation, rest[j].support) + stiffness * to_style;
        let force = held + pulled * pull_way;
        let blown = h * exposed * air.velocity(x) - (carried - x);
        let drag = p.drag * (blown - (1.0 - DRAG_ALONG) * t.dot(blown) * t);
        let r = mass * (own + h * h * force + h * drag);
        // A hand damps what it holds, half as much as would keep it from swinging.
        let d = mass * (1.0 + h * (across + pulled.sqrt()) + h * h * (stiffness + pulled));
        let dragged = outer(t, mass * h * (along - across));
        a.diagonal += d + dragged.diagonal;
        a.off += dragged.off;
        px -= r;
        // What it lies on, where it would go in without: known from the step before, whose acceleration is without it too.
        out[j].presses = false;
        let driven = own + h * h * s[j].acceleration;
        if out[j].room <= STEEPEST * obstacles.way(carried + driven, x, carried) {
            let Barrier { normal, push, goes } = barrier(rest, obstacles, j, x, carried, after);
            out[j].room = (-push).max(0.0);
            let push = push.min(NEARBY);
            let pressed = push - normal.dot(driven);
            out[j].presses = pressed > 0.0 && push > -NEARBY;
            if out[j].presses {
                let slip = own - goes;
                let slip = slip - slip.dot(normal) * normal;
                let rub = (obstacles.params.friction * pressed / slip.length().max(1e-9)).min(KEEPS_OUT);
                let keeps = outer(normal, mass * (KEEPS_OUT - rub));
                a.diagonal += mass * rub + keeps.diagonal;
                a.off += keeps.off;
                px -= mass * (KEEPS_OUT * push * normal + rub * (goes - goes.dot(normal) * normal));
            }
        }
        load += mass * (force - s[j].acceleration);
        // Compute the inertia about vertex k, with dx_j = dx_k + omega x e.
        let ea = cross_columns(e, full(a)).transpose();
        let eb = cross_columns(e, b);
        let b_below = b + ea;
        let eae = cross_columns(e, ea);
        let tension = h * h * load.dot(e).max(0.0);
        let taut = outer(t, tension);
        let spin = SPIN * mass * length.max(MIN_EDGE).powi(2);
        let both = eb + eb.transpose() + eae;
        c.diagonal += Vec3::new(both.x_axis.x, both.y_axis.y, both.z_axis.z) + (tension + spin) - taut.diagonal;
        c.off += Vec3::new(both.y_axis.z, both.x_axis.z, both.x_axis.y) - taut.off;
        let pw_below = pw + e.cross(px);
        // Eliminate omega_k.
        let stiff = p.bend / joint_length(rest, k);
        let g = h * h * moment_of_joint(frame_below, frame, rest[k].joint(), stiff);
        let beta = stiff * (h * h + h * p.bend_damping);
        let inverse = inverse_symmetric(Symmetric { diagonal: c.diagonal + beta, off: c.off });
        let inverse_full = full(inverse);
        let turn = times(inverse, pw_below + g);
        let lever = inverse_full * b_below.transpose();
        let gain = Symmetric { diagonal: beta * inverse.diagonal, off: beta * inverse.off };
        out[k] = Eliminated { gain, lever, turn, ..out[k] };
        let moved = symmetric_product(b_below, lever);
        a.diagonal -= moved.diagonal;
        a.off -= moved.off;
        b = lever.transpose() * beta;
        px -= b_below * turn;
        pw = beta * times(inverse, pw_below) - times(inverse, times(c, g));
        c = symmetric_product(inverse_full, full(c));
        c.diagonal *= beta;
        c.off *= beta;
        frame = frame_below;
        length_above = length;
    }
}

/// Turn the edges from root to tip; true where a vertex touches an obstacle, and lengths are no longer exact.
fn sweep_to_tip(
    s: &mut [RodVertex],
    rest: &[RodRest],
    p: &RodParams,
    obstacles: Obstacles<'_>,
    [before, carry, after]: [Pose; 3],
    eliminated: &mut [Eliminated],
) -> bool {
    let h = p.step_secs;
    let mut touches = false;
    let (mut omega, mut dx) = (Vec3::ZERO, Vec3::ZERO);
    let (mut below, mut was_below) = (Vec3::ZERO, Vec3::ZERO);
    for k in 0..s.len().min(N_PINNED) {
        was_below = s[k].x;
        s[k].prev = was_below;
        below = after.apply(rest[k].place.xyz());
        s[k].x = below;
    }
    if let Some(root) = s.first_mut() {
        root.frame = (after.rotation * rest[0].frame).normalize();
    }
    for k in 1..s.len().saturating_sub(1) {
        let Eliminated { gain, lever, turn, .. } = eliminated[k];
        let length = rest[k].length;
        let mut frame = carried_frame(s, rest, k, carry, after);
        omega = clamp_length(times(gain, omega) - turn - lever * dx, MAX_TURN);
        if omega.length_squared() < STILL * STILL {
            omega = Vec3::ZERO;
        }
        dx += omega.cross(length * rotate(frame, Vec3::Z));
        let half = 0.5 * omega;
        frame = (Quat::from_xyzw(half.x, half.y, half.z, 1.0).normalize() * frame).normalize();
        let mut x = below + length * rotate(frame, Vec3::Z);
        if omega.length_squared() < AT_REST * AT_REST {
            let styled = (after.rotation * rest[k].frame).normalize();
            let styled_x = after.apply(rest[k + 1].place.xyz());
            let aside = (frame - styled).length_squared().max((x - styled_x).length_squared());
            if aside < AT_REST * AT_REST {
                (frame, x) = (styled, styled_x);
            }
        }
        below = x;
        let was = s[k + 1].x;
        let Eliminated { room, presses, .. } = eliminated[k + 1];
        let carried = carry.apply(was);
        let mut acceleration = (x - was) - (was - s[k + 1].prev);
        let mut contacted = collide(rest, obstacles, k + 1, x, was, room, [before, after], carried);
        let edge = [[was_below, was], [s[k].x, contacted.x]];
        contacted = collide_edge(rest, obstacles, k + 1, edge, contacted, [before, after]);
        was_below = was;
        touches |= contacted.x != x;
        if presses {
            // It gives no velocity, and is left out of the acceleration: where that points tells whether it presses still.
            let Barrier { normal, push, goes } = barrier(rest, obstacles, k + 1, was, carried, after);
            let out = (contacted.x - carried - goes) - (contacted.prev - was);
            contacted.prev += out.dot(normal) * normal;
            acceleration -= KEEPS_OUT * (push.min(NEARBY) - dx.dot(normal)) * normal;
        }
        s[k].frame = frame;
        s[k + 1].acceleration = acceleration / (h * h);
        (s[k + 1].x, s[k + 1].prev) = (contacted.x, contacted.prev);
        eliminated[k + 1].room = contacted.room;
    }
    touches
}

/// Keep a vertex out of the head and the colliders; `room` is how far from a contact it was at `prev`.
fn collide(
    rest: &[RodRest],
    obstacles: Obstacles<'_>,
    k: usize,
    x: Vec3,
    prev: Vec3,
    room: f32,
    [before, after]: [Pose; 2],
    carried: Vec3,
) -> Contacted {
    let left = room - STEEPEST * obstacles.way(x, prev, carried);
    if left > 0.0 {
        return Contacted { x, prev, room: left };
    }
    obstacles.collide(x, prev, rest[k].place.w, along(rest, k), before, after)
}

/// Keep the edge between vertex `k`, `contacted` alone, and the one before it out of thin colliders.
fn collide_edge(
    rest: &[RodRest],
    obstacles: Obstacles<'_>,
    k: usize,
    [start, end]: [[Vec3; 2]; 2],
    contacted: Contacted,
    [before, after]: [Pose; 2],
) -> Contacted {
    if !obstacles.has_thin() {
        return contacted;
    }
    let of_edge = obstacles.collide_edge(start, end, contacted.prev, along(rest, k), before, after);
    let room = (contacted.room - STEEPEST * of_edge.x.distance(contacted.x)).max(0.0);
    Contacted { room, ..of_edge }
}

/// What vertex `k` lies on that would go with the head from `prev` to `carried`.
fn barrier(rest: &[RodRest], obstacles: Obstacles<'_>, k: usize, prev: Vec3, carried: Vec3, after: Pose) -> Barrier {
    obstacles.barrier(prev, carried, rest[k].place.w, along(rest, k), after, NEARBY)
}

/// Where on the strand, 0 root to 1 tip.
fn along(rest: &[RodRest], k: usize) -> f32 {
    k as f32 / (rest.len() - 1) as f32
}

/// Put every vertex at its exact distance from the one below and out of all obstacles. Where an obstacle holds a vertex
/// back, those below are pulled to it, and the strand is closed again from the root (after FABRIK, Aristidou and
/// Lasenby 2011): root to tip alone would drag what hangs on a rod through it. Frames follow the edges.
fn close_lengths(
    s: &mut [RodVertex],
    rest: &[RodRest],
    p: &RodParams,
    obstacles: Obstacles<'_>,
    after: Pose,
    kept: &mut [Eliminated],
) {
    for reach in 0..=REACHES {
        if !reach_from_root(s, rest, p, obstacles, after, reach < REACHES, kept) {
            break;
        }
        reach_from_tip(s, rest, obstacles, after, kept);
    }
    for k in 1..s.len() - 1 {
        let frame = s[k].frame;
        let edge = s[k + 1].x - s[k].x;
        s[k].frame = (shortest_turn(rotate(frame, Vec3::Z), edge) * frame).normalize();
    }
}

/// From the root up, without giving velocity; true where a vertex was held back and may be, its edge too long.
fn reach_from_root(
    s: &mut [RodVertex],
    rest: &[RodRest],
    p: &RodParams,
    obstacles: Obstacles<'_>,
    after: Pose,
    may_hold: bool,
    kept: &mut [Eliminated],
) -> bool {
    let mut is_held = false;
    let mut start_below = s[N_PINNED - 1].x;
    for k in N_PINNED..s.len() {
        let below = s[k - 1].x;
        let length = rest[k - 1].length;
        let start = s[k].x;
        let mut x = at_length(below, start, length, s[k - 1].frame);
        for _ in 0..p.n_iterations {
            let kept = keep_out(rest, obstacles, k, [start, x], [start_below, below], kept[k].room, after);
            if kept == x {
                break;
            }
            if may_hold && kept.distance(below) > HELD * length {
                is_held = true;
                x = kept;
                break;
            }
            x = turned_out(below, x, kept, length, s[k - 1].frame);
        }
        start_below = start;
        s[k].prev += x - start;
        s[k].x = x;
        kept[k].room = room_after(kept[k].room, start, x);
    }
    is_held
}

/// From the tip down, edges that are too long; it takes the velocity that made them so.
fn reach_from_tip(
    s: &mut [RodVertex],
    rest: &[RodRest],
    obstacles: Obstacles<'_>,
    after: Pose,
    kept: &mut [Eliminated],
) {
    let mut start_above = s[s.len() - 1].x;
    for k in (N_PINNED..s.len() - 1).rev() {
        let length = rest[k].length;
        let (start, above) = (s[k].x, s[k + 1].x);
        let is_long = start.distance(above) > 1.001 * length;
        if is_long || obstacles.has_thin() {
            let pulled = if is_long { at_length(above, start, length, s[k].frame) } else { start };
            s[k].x = keep_out(rest, obstacles, k, [start, pulled], [start_above, above], kept[k].room, after);
            kept[k].room = room_after(kept[k].room, start, s[k].x);
        }
        start_above = start;
    }
}

/// Keep out a vertex that goes from `start` to `x`; `room` is how far from a contact it was there.
fn keep_out(
    rest: &[RodRest],
    obstacles: Obstacles<'_>,
    k: usize,
    [start, x]: [Vec3; 2],
    [start_beside, beside]: [Vec3; 2],
    room: f32,
    after: Pose,
) -> Vec3 {
    let mut kept = x;
    if room <= STEEPEST * start.distance(x) {
        kept = obstacles.keep_out(start, x, rest[k].place.w, along(rest, k), after);
    }
    if !obstacles.has_thin() {
        return kept;
    }
    obstacles.keep_edge_out([start_beside, start], [beside, kept], along(rest, k), after)
}

/// How far from a contact a vertex still is that has gone from `start` to `x`.
fn room_after(room: f32, start: Vec3, x: Vec3) -> f32 {
    (room - STEEPEST * start.distance(x)).max(0.0)
}

/// The place in the direction of `x` that is as far from `below` as at rest; in the edge's own where there is none.
fn at_length(below: Vec3, x: Vec3, length: f32, frame: Quat) -> Vec3 {
    let edge = x - below;
    let far = edge.length();
    if far > 1e-6 { below + edge * (length / far) } else { below + length * rotate(frame, Vec3::Z) }
}

/// As far from `below` as at rest, and out of what pushed from `x` to `kept`: the edge turns until it is, in one go where
/// the surface is flat. To bring `kept` to its distance alone would take it back in, by half of the push where the edge
/// leans by 45 degrees.
fn turned_out(below: Vec3, x: Vec3, kept: Vec3, length: f32, frame: Quat) -> Vec3 {
    let edge = kept - below;
    let normal = (kept - x).normalize_or_zero();
    let out = edge.dot(normal);
    let across = edge - out * normal;
    let squared = across.length_squared();
    if squared < 1e-12 || out.abs() >= length {
        return at_length(below, kept, length, frame);
    }
    below + out * normal + across * ((length * length - out * out) / squared).sqrt()
}

/// A strand that is not finite starts again from rest: once a frame, after its steps.
pub fn recover(s: &mut [RodVertex], rest: &[RodRest], after: Pose) {
    let mut sum = 0.0;
    for k in 0..s.len() {
        sum += (s[k].x - s[k].prev).abs().element_sum() + s[k].frame.length_squared();
    }
    // False for NaN and infinity too.
    if sum < 1e15 {
        return;
    }
    for (vertex, rest) in s.iter_mut().zip(rest) {
        *vertex = at_rest(rest, after);
    }
}

/// Moment that a joint's deviation from its rest makes on the edge above it, world: 2 B/l sin(theta / 2) about its axis.
fn moment_of_joint(below: Quat, above: Quat, joint: Quat, stiff: f32) -> Vec3 {
    let deviation = joint.conjugate() * (below.conjugate() * above);
    let shortest = if deviation.w < 0.0 { -1.0 } else { 1.0 };
    rotate(above, 2.0 * stiff * shortest * Vec3::new(deviation.x, deviation.y, deviation.z))
}

/// `e x` each column.
fn cross_columns(e: Vec3, m: Mat3) -> Mat3 {
    Mat3::from_cols(e.cross(m.x_axis), e.cross(m.y_axis), e.cross(m.z_axis))
}

fn full(m: Symmetric) -> Mat3 {
    let (d, o) = (m.diagonal, m.off);
    Mat3::from_cols(Vec3::new(d.x, o.z, o.y), Vec3::new(o.z, d.y, o.x), Vec3::new(o.y, o.x, d.z))
}

fn times(m: Symmetric, v: Vec3) -> Vec3 {
    let o = m.off;
    m.diagonal * v + Vec3::new(o.z * v.y + o.y * v.z, o.z * v.x + o.x * v.z, o.y * v.x + o.x * v.y)
}

/// `a b`, known to be its own transpose.
fn symmetric_product(a: Mat3, b: Mat3) -> Symmetric {
    let (x, y, z) = (a.row(0), a.row(1), a.row(2));
    Symmetric {
        diagonal: Vec3::new(x.dot(b.x_axis), y.dot(b.y_axis), z.dot(b.z_axis)),
        off: Vec3::new(y.dot(b.z_axis), x.dot(b.z_axis), x.dot(b.y_axis)),
    }
}

/// `scale` times the outer product of `v` with itself.
fn outer(v: Vec3, scale: f32) -> Symmetric {
    let scaled = scale * v;
    Symmetric { diagonal: scaled * v, off: scaled.yxx() * v.zzy() }
}

/// By cofactors; `m` is positive definite.
fn inverse_symmetric(m: Symmetric) -> Symmetric {
    let (d, o) = (m.diagonal, m.off);
    let off = o.yxx() * o.zzy() - d * o;
    let diagonal = d.yxx() * d.zzy() - o * o;
    let scale = 1.0 / (d.x * diagonal.x + o.z * off.z + o.y * off.y);
    Symmetric { diagonal: scale * diagonal, off: scale * off }
}
