//! Where something rigid is, and the rotations that solvers calculate with. Twin of `sim_pose.wgsl`: same names, same
//! order of operations.

use glam::{Affine3A, Quat, Vec3};

/// A rotation and a translation, world from head.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    pub rotation: Quat,
    pub translation: Vec3,
}

impl Pose {
    pub const IDENTITY: Self = Self { rotation: Quat::IDENTITY, translation: Vec3::ZERO };

    /// The rigid part of a transform; the identity where it is not finite.
    pub fn new(world_from_head: &Affine3A) -> Self {
        let (_, rotation, translation) = world_from_head.to_scale_rotation_translation();
        let pose = Self { rotation: rotation.normalize(), translation };
        // The exact identity keeps a strand at rest bit-equal to its rest shape.
        if pose.rotation.is_finite() && translation.is_finite() { pose } else { Self::IDENTITY }
    }

    pub fn apply(&self, p: Vec3) -> Vec3 {
        rotate(self.rotation, p) + self.translation
    }

    pub fn apply_inverse(&self, p: Vec3) -> Vec3 {
        rotate(self.rotation.conjugate(), p - self.translation)
    }

    /// First the inverse of `from`, then this.
    pub fn after_inverse_of(&self, from: &Self) -> Self {
        let rotation = (self.rotation * from.rotation.conjugate()).normalize();
        Self { rotation, translation: self.translation - rotate(rotation, from.translation) }
    }

    pub(crate) const N_NUMBERS: usize = 7;

    pub(crate) fn to_numbers(self) -> [f64; Self::N_NUMBERS] {
        let [x, y, z, w] = self.rotation.to_array().map(f64::from);
        let [tx, ty, tz] = self.translation.to_array().map(f64::from);
        [x, y, z, w, tx, ty, tz]
    }

    /// `None` where they are no pose.
    pub(crate) fn of_numbers(numbers: &[f64]) -> Option<Self> {
        let &[x, y, z, w, tx, ty, tz] = numbers else { return None };
        let pose = Self {
            rotation: Quat::from_xyzw(x as f32, y as f32, z as f32, w as f32),
            translation: Vec3::new(tx as f32, ty as f32, tz as f32),
        };
        (pose.rotation.is_finite() && pose.translation.is_finite()).then_some(pose)
    }

    pub(crate) fn lerp(&self, to: &Self, t: f32) -> Self {
        if self == to {
            return *self;
        }
        let rotation = self.rotation.slerp(to.rotation, t).normalize();
        Self { rotation, translation: self.translation.lerp(to.translation, t) }
    }
}

/// `v` turned by the unit quaternion `q`, in the order of operations that the WGSL twin has.
pub fn rotate(q: Quat, v: Vec3) -> Vec3 {
    let u = Vec3::new(q.x, q.y, q.z);
    let t = 2.0 * u.cross(v);
    v + q.w * t + u.cross(t)
}

/// The smallest rotation that takes the direction of `from` to that of `to`.
pub fn shortest_turn(from: Vec3, to: Vec3) -> Quat {
    let scale = (from.length_squared() * to.length_squared()).sqrt();
    if scale < 1e-12 {
        return Quat::IDENTITY;
    }
    let w = scale + from.dot(to);
    if w < 1e-5 * scale {
        // Half a turn about any axis across.
        let across = if from.x.abs() < from.y.abs().max(from.z.abs()) { Vec3::X } else { Vec3::Y };
        let axis = normalize_or_zero(from.cross(across));
        return Quat::from_xyzw(axis.x, axis.y, axis.z, 0.0);
    }
    let axis = from.cross(to);
    let length = (axis.length_squared() + w * w).sqrt();
    Quat::from_xyzw(axis.x / length, axis.y / length, axis.z / length, w / length)
}

/// One over the length of `v`; zero where it has none.
pub fn inverse_length(v: Vec3) -> f32 {
    let squared = v.length_squared();
    if squared > 1e-18 { 1.0 / squared.sqrt() } else { 0.0 }
}

/// What the smallest rotation that takes the direction of `a` to that of `b` makes of `v`. `by_a`: one over the length of `a`, 0
/// where it has none; `along_a`: how far `v` goes along the direction of `a`.
pub fn turned_as(a: Vec3, by_a: f32, along_a: f32, b: Vec3, v: Vec3) -> Vec3 {
    let by_b = inverse_length(b);
    let (a_unit, b_unit) = (by_a * a, by_b * b);
    let w = 1.0 + a_unit.dot(b_unit);
    if w < 1e-5 || by_a * by_b == 0.0 {
        return rotate(shortest_turn(a, b), v);
    }
    let share = (along_a + b_unit.dot(v)) / w;
    v - share * a_unit + (2.0 * along_a - share) * b_unit
}

/// The direction of `v`; zero where it has none.
pub fn normalize_or_zero(v: Vec3) -> Vec3 {
    let length = v.length();
    if length > 1e-9 { v / length } else { Vec3::ZERO }
}

/// `v`, no longer than `max`. Twin of the one in `sim_frame.wgsl`.
pub fn clamp_length(v: Vec3, max: f32) -> Vec3 {
    let length = v.length();
    if length > max { v * (max / length) } else { v }
}
