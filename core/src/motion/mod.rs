//! How the head moves: presets that show what hair does ([`Motion`]), keyed poses ([`PoseTrack`]), the pose that a person
//! drags, and the timeline that the document keeps ([`Movement`]).

mod movement;
mod preset;
mod track;

use glam::{Affine3A, EulerRot, Mat3, Quat, Vec3};

use crate::mesh::TriMesh;

pub use movement::{AtEnd, Movement};
pub use preset::Motion;
pub use track::{PoseKey, PoseTrack};

/// Where the head is, as turns about the neck and a shift. Zero is the rest pose.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadPose {
    /// Radians about +Y: positive turns the nose to the model's left (+X).
    pub yaw: f32,
    /// Radians about +X: positive lowers the nose.
    pub pitch: f32,
    /// Radians about +Z: positive lays the head on the model's right shoulder.
    pub roll: f32,
    /// Centimetres.
    pub shift: Vec3,
}

impl HeadPose {
    pub fn rotation(self) -> Quat {
        Quat::from_euler(EulerRot::YXZ, self.yaw, self.pitch, self.roll)
    }

    /// The same turns, somewhere else.
    pub fn shifted(self, shift: Vec3) -> Self {
        Self { shift: self.shift + shift, ..self }
    }

    /// Rotate about a pivot in head space, then shift.
    pub fn world_from_head(self, pivot: Vec3) -> Affine3A {
        let rotation = self.rotation();
        Affine3A::from_mat3_translation(Mat3::from_quat(rotation), pivot + self.shift - rotation * pivot)
    }
}

impl std::ops::Add for HeadPose {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            yaw: self.yaw + other.yaw,
            pitch: self.pitch + other.pitch,
            roll: self.roll + other.roll,
            shift: self.shift + other.shift,
        }
    }
}

/// Where the head turns: on the axis of its upper part, a head's height below the crown and a little behind
/// the middle, where the spine is. The origin where the mesh is empty.
pub fn neck_pivot(head: &TriMesh) -> Vec3 {
    // From the crown to the joint under the skull are 16-17 cm in adults; the spine runs 1.5 cm behind the
    // middle of the skull.
    const CROWN_TO_NECK: f32 = 16.5;
    const BEHIND_MIDDLE: f32 = 1.5;
    let Some((min, max)) = head.bounds() else { return Vec3::ZERO };
    let neck = (max.y - CROWN_TO_NECK).max(min.y);
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &p in head.positions.iter().filter(|p| p.y >= 0.5 * (max.y + neck)) {
        low = low.min(p);
        high = high.max(p);
    }
    let middle = 0.5 * (low + high);
    let pivot = Vec3::new(middle.x, neck, middle.z - BEHIND_MIDDLE);
    if pivot.is_finite() { pivot } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pivot_stays_and_a_nod_lowers_the_nose() {
        let pivot = Vec3::new(0.0, -4.0, -1.0);
        let nodding = HeadPose { pitch: 0.3, ..HeadPose::default() }.world_from_head(pivot);
        assert!(nodding.transform_point3(pivot).distance(pivot) < 1e-5);
        assert!(nodding.transform_point3(Vec3::new(0.0, 0.0, 10.0)).y < -2.0);
        let turning = HeadPose { yaw: 0.3, ..HeadPose::default() }.world_from_head(pivot);
        assert!(turning.transform_point3(Vec3::new(0.0, 0.0, 10.0)).x > 2.0);
    }

    #[test]
    fn the_neck_of_a_ball_is_inside_it() {
        let head = crate::mesh_query::tests::sphere(Vec3::new(1.0, 160.0, 2.0), 11.0, 12);
        let pivot = neck_pivot(&head);
        assert!(pivot.distance(Vec3::new(1.0, 160.0, 2.0)) < 8.0, "{pivot}");
        assert_eq!(neck_pivot(&TriMesh::default()), Vec3::ZERO);
    }
}
