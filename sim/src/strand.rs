//! The law of one strand over one step. Twin of `sim_strand.wgsl`: same names, same order.
//!
//! A strand is a chain of equal masses, integrated by Verlet's rule, then corrected in position (Müller et
//! al. 2007; SIGGRAPH 2010 course on real-time hair, "one simulation step"):
//!
//! 1. `integrate`: the first two vertices follow the head; the others keep their velocity, less damping and
//!    air, plus gravity.
//! 2. `solve_lengths`: one Newton step on all lengths at once. Two batches alone spread a pull by two
//!    vertices an iteration and stretch a shaken chain of 32 vertices by a third.
//! 3. Every iteration: `bend` and `hold` towards the shape at rest, lengths in two disjoint batches, `collide`.
//! 4. `close_lengths`: what error is left goes from root to tip, without becoming velocity, so that lengths are
//!    exact after every step. Let it become velocity, as "follow the leader" does, and curls shake for ever
//!    (measured: coils of 15 cm still moved at 60 cm/s eight seconds after a shake; now at 0.1).
//!
//! **Gravity at rest.** The styled shape is what hair looks like *under* gravity: so the solver knows gravity
//! by what changes. Every vertex is a pendulum about where it rests, as long as the strand is from the root to
//! it: displaced by d it is pulled back by g d / sqrt(s^2 + d^2), g times the sine of the swing. And a head
//! that tilts by R adds g - R g. So a head at rest keeps its style to the last bit, curls and all; long hair
//! swings slowly and short hair fast; a bowed head's hair falls by as much as a rigid pendulum would. Rejected
//! after trying: a support of -g that turns with the strand's own frame, at every vertex or at both ends of
//! every edge. It is exact at rest too, but a follower force: it has no potential, and shaken curls drew energy
//! from it and never came to rest. Solving for a weightless shape that sags into the style: soft or curly
//! strands have many such shapes or none, and those that lie on the head have none at all.
//!
//! **The strand's own frame.** A rotation R from the rest shape is carried from root to tip without twist, each
//! edge adding the shortest turn; bending pulls every edge towards R times its direction at rest. So curls keep
//! their shape while the strand swings. R follows the curve smoothed over a few centimetres, not the edges
//! themselves (after Iben et al. 2013, "Artistic simulation of curly hair"): round and round a coil the turns
//! of the edges add up to a twist that feeds on itself (measured: without, shaken hair never rests).

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::simulation::SimulationSettings;

use crate::air::Air;
use crate::bounded;
use crate::contact::Obstacles;
use crate::pose::{Pose, normalize_or_zero, rotate, shortest_turn};

/// Vertices at the root that follow the head: the root, and the next one for the growing direction.
pub const N_PINNED: usize = 2;
/// Shortest edge for stiffness, centimetres: shorter ones would only be stiffer than a float can tell.
const MIN_EDGE: f32 = 0.05;
/// Rate at which neighbouring vertices of a strand lose their difference in velocity, 1/s: hairs of a lock rub on
/// each other. It stills the quiver of a lock (measured: 10 to 50 do) and leaves its swing alone.
const RUB: f32 = 20.0;
/// Length over which the strand's frame is smoothed, cm: more than a curl's pitch.
const SMOOTHING: f32 = 3.0;
/// Distance from the root at which hair feels half of the wind, cm: it lies in the lee of its neighbours
/// there. Without, a wind along the scalp folds the roots over at the parting.
const SHELTER: f32 = 4.0;
/// Times its length, where the hold has faded to a thousandth and ends.
const HOLD_ENDS: f32 = 7.0;
/// Times that length and obstacles have their say in turns.
const CLOSINGS: usize = 3;
/// Times that a chain which is held is closed from both ends.
const REACHES: usize = 8;
/// An edge stretched by an obstacle to this many times its length is held.
const HELD: f32 = 1.2;
/// Faster hair is not seen, only missed: cm/s.
const MAX_SPEED: f32 = 3000.0;
/// Standard gravity, by which `bend_length` becomes a stiffness; not the scene's gravity, cm/s2.
const STANDARD_GRAVITY: f32 = 981.0;

/// [`SimulationSettings`] made ready for steps: finite, bounded, multiplied out. Layout of `StepParams` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct StepParams {
    /// Displacement by gravity in a step, cm.
    pub gravity_step: [f32; 3],
    /// Share of the velocity relative to the head that a step keeps.
    pub keep: f32,
    /// Share of the air's velocity that a step takes up.
    pub take_up: f32,
    /// Bending stiffness times the step squared, over the iterations, cm^4.
    pub bend: f32,
    /// Hold at the root times the step squared, over the iterations.
    pub hold: f32,
    /// cm.
    pub hold_length: f32,
    /// cm.
    pub max_displacement: f32,
    pub n_iterations: u32,
    pub step_secs: f32,
    /// Share of the difference to each neighbour's velocity that a step takes away.
    pub rub: f32,
}

impl StepParams {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let dt = 1.0 / bounded(settings.steps_per_second, default.steps_per_second, 15.0, 2000.0);
        let n_iterations = settings.n_iterations.clamp(1, 64);
        let gravity = bounded(settings.gravity, default.gravity, -1e4, 1e4);
        let bend_length = bounded(settings.bend_length, default.bend_length, 0.0, 100.0);
        let hold = std::f32::consts::TAU * bounded(settings.hold, default.hold, 0.0, 100.0);
        Self {
            gravity_step: [0.0, -gravity * dt * dt, 0.0],
            keep: (-bounded(settings.damping, default.damping, 0.0, 1e3) * dt).exp(),
            take_up: 1.0 - (-bounded(settings.drag, default.drag, 0.0, 1e3) * dt).exp(),
            // A lock of length l under its own weight bends by about 1 where l^3 g = B: B = g l^3.
            bend: STANDARD_GRAVITY * bend_length.powi(3) * dt * dt / n_iterations as f32,
            hold: hold * hold * dt * dt / n_iterations as f32,
            hold_length: bounded(settings.hold_length, default.hold_length, 0.01, 1e4),
            max_displacement: MAX_SPEED * dt,
            n_iterations,
            step_secs: dt,
            rub: (RUB * dt).min(0.25),
        }
    }
}

/// One strand's arrays, all of one length.
#[derive(Debug)]
pub struct Strand<'a> {
    /// xyz head space, w the distance from the obstacles at rest.
    pub rest: &'a [Vec4],
    /// xyz world now, w scratch of `solve_lengths`.
    pub x: &'a mut [Vec4],
    /// xyz world one step ago, w scratch of `solve_lengths`.
    pub prev: &'a mut [Vec4],
}

/// One step: the head goes from `before` to `after`.
pub fn step_strand(s: &mut Strand<'_>, p: &StepParams, air: Air, obstacles: Obstacles<'_>, before: Pose, after: Pose) {
    integrate(s, p, air, before, after);
    solve_lengths(s);
    for _ in 0..p.n_iterations {
        bend(s, p, after);
        hold(s, p, after);
        length_batch(s, 0);
        length_batch(s, 1);
        collide(s, obstacles, before, after);
    }
    close_lengths(s, obstacles, after);
    recover(s, after);
}

/// Verlet's rule. Pinned vertices go with the head.
fn integrate(s: &mut Strand<'_>, p: &StepParams, air: Air, before: Pose, after: Pose) {
    let carry = after.after_inverse_of(&before);
    let gravity_step = Vec3::from_array(p.gravity_step);
    // What gravity has become for a head that is not upright: zero while it is.
    let tilt = gravity_step - rotate(before.rotation, gravity_step);
    let with_head = |x: Vec3| carry.apply(x) - x;
    let mut from_root = 0.0;
    let (mut own_below, mut own) = (Vec3::ZERO, Vec3::ZERO);
    for k in 0..s.x.len() {
        let x = s.x[k].xyz();
        // Compute the next vertex's velocity relative to the head, before it is moved.
        let mut own_above = own;
        if k + 1 < s.x.len() && k + 1 >= N_PINNED {
            let above = s.x[k + 1].xyz();
            own_above = above - s.prev[k + 1].xyz() - with_head(above);
        }
        set(&mut s.prev[k], x);
        if k > 0 {
            from_root += s.rest[k].xyz().distance(s.rest[k - 1].xyz());
        }
        if k < N_PINNED {
            set(&mut s.x[k], after.apply(s.rest[k].xyz()));
        } else {
            // Level the velocity out with the neighbours', lose some of it to the head and to the air.
            let levelled = own + p.rub * (own_below + own_above - 2.0 * own);
            let mut v = with_head(x) + p.keep * levelled;
            // Near the scalp the air stands still between the hairs.
            let exposed = from_root / (from_root + SHELTER);
            v += p.take_up * (exposed * p.step_secs * air.velocity(x) - v);
            let aside = x - before.apply(s.rest[k].xyz());
            let swing = (from_root * from_root + aside.length_squared()).sqrt();
            let pendulum = -aside * (gravity_step.length() / swing.max(MIN_EDGE));
            set(&mut s.x[k], x + clamp_length(v, p.max_displacement) + tilt + pendulum);
        }
        own_below = own;
        own = own_above;
    }
}

/// One Newton step on all lengths: the tridiagonal system of their multipliers, by Thomas's algorithm.
fn solve_lengths(s: &mut Strand<'_>) {
    let n = s.x.len();
    let mut normal_below = Vec3::ZERO;
    // After elimination, multiplier k is d[k] - c[k] * multiplier k + 1; c is in x.w, d in prev.w.
    let (mut c, mut d) = (0.0, 0.0);
    for k in N_PINNED..n {
        let edge = s.x[k].xyz() - s.x[k - 1].xyz();
        let length = edge.length();
        let normal = normalize_or_zero(edge);
        let error = length - s.rest[k].xyz().distance(s.rest[k - 1].xyz());
        let w_below = if k > N_PINNED { 1.0 } else { 0.0 };
        let a = -w_below * normal_below.dot(normal);
        let above = if k + 1 < n { normalize_or_zero(s.x[k + 1].xyz() - s.x[k].xyz()) } else { Vec3::ZERO };
        let pivot = 1.0 + w_below - a * c;
        d = (error - a * d) / pivot;
        c = -normal.dot(above) / pivot;
        s.x[k].w = c;
        s.prev[k].w = d;
        normal_below = normal;
    }
    let mut above = Vec3::ZERO;
    let mut multiplier_above = 0.0;
    for k in (N_PINNED..n).rev() {
        let normal = normalize_or_zero(s.x[k].xyz() - s.x[k - 1].xyz());
        let multiplier = s.prev[k].w - s.x[k].w * multiplier_above;
        let x = s.x[k].xyz() - multiplier * normal + multiplier_above * above;
        set(&mut s.x[k], x);
        above = normal;
        multiplier_above = multiplier;
    }
}

/// Bend every joint towards its angle at rest, in the frame carried from the root. Both ends of the edge move:
/// linear momentum is kept.
fn bend(s: &mut Strand<'_>, p: &StepParams, after: Pose) {
    let n = s.x.len();
    let mut frame = after.rotation;
    let mut smooth = s.x[1].xyz() - s.x[0].xyz();
    let mut rest_smooth = s.rest[1].xyz() - s.rest[0].xyz();
    let mut h_below = rest_smooth.length();
    for k in 1..n - 1 {
        let rest_edge = s.rest[k + 1].xyz() - s.rest[k].xyz();
        let h_above = rest_edge.length();
        let deviation = s.x[k + 1].xyz() - s.x[k].xyz() - rotate(frame, rest_edge);
        let h = (0.5 * (h_below + h_above)).max(MIN_EDGE);
        let stiffness = p.bend / (h * h * h * h);
        let w_joint = weight(k);
        let share = stiffness / (1.0 + stiffness * (1.0 + w_joint));
        let top = s.x[k + 1].xyz() - share * deviation;
        let joint = s.x[k].xyz() + w_joint * share * deviation;
        set(&mut s.x[k + 1], top);
        set(&mut s.x[k], joint);
        let blend = h_above / (h_above + SMOOTHING);
        smooth += blend * (top - joint - smooth);
        rest_smooth += blend * (rest_edge - rest_smooth);
        frame = shortest_turn(rotate(frame, rest_smooth), smooth) * frame;
        h_below = h_above;
    }
}

/// Spring back towards the style, strongest at the root.
fn hold(s: &mut Strand<'_>, p: &StepParams, after: Pose) {
    let mut from_root = s.rest[1].xyz().distance(s.rest[0].xyz());
    for k in N_PINNED..s.x.len() {
        from_root += s.rest[k].xyz().distance(s.rest[k - 1].xyz());
        if from_root > HOLD_ENDS * p.hold_length {
            break;
        }
        let stiffness = p.hold * (-from_root / p.hold_length).exp();
        let x = s.x[k].xyz();
        set(&mut s.x[k], x + (after.apply(s.rest[k].xyz()) - x) * (stiffness / (1.0 + stiffness)));
    }
}

/// Lengths of every second edge: the edges of one batch share no vertex.
fn length_batch(s: &mut Strand<'_>, batch: usize) {
    for k in (N_PINNED + batch..s.x.len()).step_by(2) {
        let edge = s.x[k].xyz() - s.x[k - 1].xyz();
        let error = edge.length() - s.rest[k].xyz().distance(s.rest[k - 1].xyz());
        let w_below = weight(k - 1);
        let correction = normalize_or_zero(edge) * (error / (1.0 + w_below));
        let (below, x) = (s.x[k - 1].xyz() + w_below * correction, s.x[k].xyz() - correction);
        set(&mut s.x[k - 1], below);
        set(&mut s.x[k], x);
    }
}

/// Keep vertices out of the head and the colliders.
fn collide(s: &mut Strand<'_>, obstacles: Obstacles<'_>, before: Pose, after: Pose) {
    for k in N_PINNED..s.x.len() {
        let along = k as f32 / (s.x.len() - 1) as f32;
        let (x, prev) = obstacles.collide(s.x[k].xyz(), s.prev[k].xyz(), s.rest[k].w, along, before, after);
        set(&mut s.x[k], x);
        set(&mut s.prev[k], prev);
    }
}

/// Put every vertex at its exact distance from the one below and out of all obstacles. Where an obstacle holds a vertex
/// back, those below are pulled to it, and the chain is closed again from the root (after FABRIK, Aristidou and
/// Lasenby 2011): root to tip alone would drag what hangs on a rod through it.
fn close_lengths(s: &mut Strand<'_>, obstacles: Obstacles<'_>, after: Pose) {
    for reach in 0..=REACHES {
        if !reach_from_root(s, obstacles, after, reach < REACHES) {
            return;
        }
        reach_from_tip(s, obstacles, after);
    }
}

/// From the root up, without giving velocity; true where a vertex was held back and may be, its edge too long.
fn reach_from_root(s: &mut Strand<'_>, obstacles: Obstacles<'_>, after: Pose, may_hold: bool) -> bool {
    let mut is_held = false;
    for k in N_PINNED..s.x.len() {
        let below = s.x[k - 1].xyz();
        let rest_edge = s.rest[k].xyz() - s.rest[k - 1].xyz();
        let along = k as f32 / (s.x.len() - 1) as f32;
        let start = s.x[k].xyz();
        let mut x = at_length(below, start, rest_edge, after);
        for _ in 0..CLOSINGS {
            let kept = obstacles.keep_out(start, x, s.rest[k].w, along, after);
            if kept == x {
                break;
            }
            x = at_length(below, kept, rest_edge, after);
            if may_hold && kept.distance(below) > HELD * rest_edge.length() {
                is_held = true;
                x = kept;
                break;
            }
        }
        let prev = s.prev[k].xyz() + (x - start);
        set(&mut s.x[k], x);
        set(&mut s.prev[k], prev);
    }
    is_held
}

/// From the tip down, edges that are too long; it takes the velocity that made them so.
fn reach_from_tip(s: &mut Strand<'_>, obstacles: Obstacles<'_>, after: Pose) {
    for k in (N_PINNED..s.x.len() - 1).rev() {
        let rest_edge = s.rest[k + 1].xyz() - s.rest[k].xyz();
        let along = k as f32 / (s.x.len() - 1) as f32;
        let (x, above) = (s.x[k].xyz(), s.x[k + 1].xyz());
        if x.distance(above) > 1.001 * rest_edge.length() {
            let pulled = at_length(above, x, rest_edge, after);
            let kept = obstacles.keep_out(x, pulled, s.rest[k].w, along, after);
            set(&mut s.x[k], kept);
        }
    }
}

/// The place in the direction of `x` that is as far from `below` as at rest.
fn at_length(below: Vec3, x: Vec3, rest_edge: Vec3, after: Pose) -> Vec3 {
    let edge = x - below;
    let length = edge.length();
    // Vertices at one place have no direction: take the one at rest.
    let correction =
        if length > 1e-6 { edge * ((rest_edge.length() - length) / length) } else { rotate(after.rotation, rest_edge) };
    x + correction
}

/// A strand that is not finite starts again from rest.
fn recover(s: &mut Strand<'_>, after: Pose) {
    let mut sum = 0.0;
    for k in 0..s.x.len() {
        sum += (s.x[k].xyz() - s.prev[k].xyz()).abs().element_sum();
    }
    // False for NaN and infinity too.
    if sum < 1e15 {
        return;
    }
    for k in 0..s.x.len() {
        let x = after.apply(s.rest[k].xyz());
        set(&mut s.x[k], x);
        set(&mut s.prev[k], x);
    }
}

/// Inverse mass: nothing moves a pinned vertex.
fn weight(k: usize) -> f32 {
    if k < N_PINNED { 0.0 } else { 1.0 }
}

fn set(vertex: &mut Vec4, p: Vec3) {
    *vertex = p.extend(vertex.w);
}

fn clamp_length(v: Vec3, max: f32) -> Vec3 {
    let length = v.length();
    if length > max { v * (max / length) } else { v }
}
