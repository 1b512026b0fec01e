//! Rods before they move: what is made of a style when it is bound, and a strand put somewhere.
//!
//! The style is what hair looks like *under* gravity. Every joint is given the rest rotation whose moment carries the weight
//! beyond it: M_k = M_k+1 + e_k x N_k, from tip to root, exactly. Where a joint would have to be bent farther than hair can
//! be relied on to hold (`SELF_SUPPORT`), the rest is carried by a force on the next vertex that turns with the head: what
//! scalp, neighbours and product do. Without that bound a soft lock that is styled sideways is balanced on a knife's edge,
//! and the first shake brings it down for good (measured).

use glam::{Quat, Vec3, Vec4, Vec4Swizzles};

use crate::pose::{Pose, clamp_length, rotate, shortest_turn};
use crate::rest::Exposure;
use crate::rod::{RodParams, RodVertex, STANDARD_GRAVITY};

/// Shortest edge for masses and stiffness, cm.
pub(crate) const MIN_EDGE: f32 = 0.01;
/// Most that a joint bends by itself to carry weight at rest, as a curvature times the bending length.
const SELF_SUPPORT: f32 = 0.5;
/// Largest half of a joint's moment over its stiffness: beyond, the rotation that carries it does not exist.
const MOST_MOMENT: f32 = 0.8;

/// What does not change while a strand moves. Layout of a vertex's four in `rest` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct RodRest {
    /// xyz head space, w the distance from the obstacles at rest.
    pub place: Vec4,
    /// Frame of the edge above, head space; the tip has none.
    pub frame: Quat,
    /// Of the rotation of the joint in which it has no moment the imaginary part; the real one is not negative.
    joint: Vec3,
    /// Of the edge above, cm.
    pub length: f32,
    /// What carries the vertex beside its own strand, head space, cm/s2.
    pub support: Vec3,
    /// See [`packed`].
    exposure: f32,
}

impl RodRest {
    pub(crate) fn joint(&self) -> Quat {
        let Vec3 { x, y, z } = self.joint;
        Quat::from_xyzw(x, y, z, (1.0 - self.joint.length_squared()).max(0.0).sqrt())
    }

    fn set_joint(&mut self, joint: Quat) {
        let joint = if joint.w < 0.0 { -joint } else { joint };
        self.joint = Vec3::new(joint.x, joint.y, joint.z);
    }

    /// Hold and share of the wind, as they were packed.
    pub(crate) fn exposure(&self) -> [f32; 2] {
        let bits = self.exposure.to_bits();
        [f32::from_bits(bits & 0xffff_0000), (bits & 0xffff) as f32 / 65_535.0]
    }
}

/// In the bits of one number the hold with 8 bits of its digits (half a percent) and the share of the wind with 16.
fn packed(exposure: Exposure) -> f32 {
    let hold = exposure.hold.max(0.0).to_bits();
    // To the nearest; a tie goes up.
    let hold = (hold + 0x8000) & 0xffff_0000;
    f32::from_bits(hold | (exposure.wind.clamp(0.0, 1.0) * 65_535.0 + 0.5) as u32)
}

/// Make one strand of [`Rest`](crate::rest::Rest) ready. The style is the shape under gravity; where `is_weightless` it is the
/// shape without.
pub fn rest_of(places: &[Vec4], exposures: &[Exposure], p: &RodParams, is_weightless: bool) -> Vec<RodRest> {
    let n_edges = places.len().saturating_sub(1);
    let edge = |k: usize| places[k + 1].xyz() - places[k].xyz();
    let mut rest: Vec<RodRest> = places.iter().map(|&place| RodRest { place, ..RodRest::default() }).collect();
    let mut frame = Quat::IDENTITY;
    for k in 0..n_edges {
        // The smallest turn from edge to edge: frames without twist.
        frame = (shortest_turn(rotate(frame, Vec3::Z), edge(k)) * frame).normalize();
        rest[k].frame = frame;
        rest[k].length = edge(k).length();
    }
    for (rest, &exposure) in rest.iter_mut().zip(exposures) {
        rest.exposure = packed(exposure);
    }
    let bend_length = (p.bend / STANDARD_GRAVITY).cbrt();
    let stiff = |rest: &[RodRest], k: usize| p.bend / joint_length(rest, k);
    // The same at every joint: a twist is handed down as it is, and must be within what the next joint holds.
    let softest = (1..n_edges).map(|k| stiff(&rest, k)).fold(f32::INFINITY, f32::min);
    let most = (SELF_SUPPORT * p.bend / bend_length.max(MIN_EDGE)).min(2.0 * MOST_MOMENT * softest);
    let (mut moment, mut load) = (Vec3::ZERO, Vec3::ZERO);
    for k in (1..n_edges).rev() {
        let e = edge(k);
        if !is_weightless {
            let mass = mass(&rest, k + 1);
            load += mass * Vec3::from_array(p.gravity);
            let needed = moment + e.cross(load);
            // A force on the edge's end carries what is across the edge, and none of what twists it.
            let twist = moment.dot(e) / e.length_squared().max(MIN_EDGE * MIN_EDGE) * e;
            let across = needed - twist;
            let held = clamp_length(across, (most * most - twist.length_squared()).max(0.0).sqrt());
            let carried = -(across - held).cross(e) / e.length_squared().max(MIN_EDGE * MIN_EDGE);
            load += carried;
            rest[k + 1].support = carried / mass;
            moment = twist + held;
        }
        let stiff = stiff(&rest, k);
        let v = rotate(rest[k].frame.conjugate(), moment) / (2.0 * stiff.max(f32::MIN_POSITIVE));
        let deviation = Quat::from_xyzw(v.x, v.y, v.z, (1.0 - v.length_squared()).max(0.0).sqrt());
        let joint = rest[k - 1].frame.conjugate() * rest[k].frame * deviation.conjugate();
        rest[k].set_joint(joint.normalize());
    }
    rest
}

/// Length of hair whose bending joint `k` stands for, cm. The first is clamped by the head on one side.
pub(crate) fn joint_length(rest: &[RodRest], k: usize) -> f32 {
    half_lengths(if k <= 1 { 0.0 } else { rest[k - 1].length }, rest[k].length)
}

/// Length of hair whose mass vertex `k` stands for, cm: mass is told in centimetres of hair.
fn mass(rest: &[RodRest], k: usize) -> f32 {
    half_lengths(if k == 0 { 0.0 } else { rest[k - 1].length }, rest[k].length)
}

/// Length of hair whose mass or bending is that of the ends of two edges, cm.
pub(crate) fn half_lengths(below: f32, above: f32) -> f32 {
    (0.5 * (below + above)).max(MIN_EDGE)
}

/// At rest on a head at `pose`.
pub fn at_rest(rest: &RodRest, pose: Pose) -> RodVertex {
    let x = pose.apply(rest.place.xyz());
    let mut vertex = RodVertex::default();
    (vertex.x, vertex.prev) = (x, x);
    vertex.frame = (pose.rotation * rest.frame).normalize();
    vertex.set_begun(x);
    vertex
}

/// Put a strand to given places, as little twisted against rest as they allow.
pub fn put(s: &mut [RodVertex], rest: &[RodRest], x: &[Vec3], prev: &[Vec3]) {
    for k in 0..s.len() {
        (s[k].x, s[k].prev, s[k].acceleration) = (x[k], prev[k], Vec3::ZERO);
        s[k].set_begun(prev[k]);
    }
    for k in 1..s.len().saturating_sub(1) {
        let frame = (s[k - 1].frame * rest[k - 1].frame.conjugate() * rest[k].frame).normalize();
        s[k].frame = (shortest_turn(rotate(frame, Vec3::Z), x[k + 1] - x[k]) * frame).normalize();
    }
}
