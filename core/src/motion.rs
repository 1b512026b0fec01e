//! How the head moves: presets that show what hair does, and the pose that a person drags.
//!
//! Presets are minimum-jerk moves (Flash and Hogan 1985), which human head turns follow closely, and
//! sinusoids that swell and fade. Each starts at rest, ends at rest and repeats, with a pause in which the
//! hair can be seen to settle.

use std::f32::consts::TAU;

use glam::{Affine3A, EulerRot, Mat3, Quat, Vec3};
use serde::{Deserialize, Serialize};

use crate::look::{Choice, ChoiceInfo, choices};
use crate::mesh::TriMesh;

choices! {
    /// A preset movement of the head.
    #[derive(Default)]
    Motion {
        #[default]
        None = "none", "Still", "The head rests, or goes where it is dragged";
        Turn = "turn", "Turn", "Looks over one shoulder, then over the other";
        Nod = "nod", "Nod", "Yes: three nods and a pause";
        Shake = "shake", "Shake", "No: a brisk shake and a pause";
    }
}

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
    /// Rotate about a pivot in head space, then shift.
    pub fn world_from_head(self, pivot: Vec3) -> Affine3A {
        let rotation = Quat::from_euler(EulerRot::YXZ, self.yaw, self.pitch, self.roll);
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

impl Motion {
    /// Seconds after which the preset repeats; 0 where it does not.
    pub fn period_secs(self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Turn => 5.6,
            Self::Nod | Self::Shake => 4.5,
        }
    }

    /// The head's pose a time after the start. Negative and non-finite times are the rest pose.
    pub fn head_pose(self, t_secs: f32) -> HeadPose {
        if !(t_secs.is_finite() && t_secs >= 0.0) {
            return HeadPose::default();
        }
        let t = if self.period_secs() > 0.0 { t_secs % self.period_secs() } else { 0.0 };
        match self {
            Self::None => HeadPose::default(),
            // 55 degrees in 0.65 s peaks at 160 deg/s: a brisk look aside. Heads reach 75 degrees and 400 deg/s.
            Self::Turn => {
                let share =
                    minimum_jerk(t / 0.65) - 2.0 * minimum_jerk((t - 1.7) / 0.95) + minimum_jerk((t - 3.7) / 0.65);
                let yaw = 55_f32.to_radians() * share;
                // A head that turns leans a little into the turn and lowers the chin.
                HeadPose { yaw, pitch: 0.06 * yaw.abs(), roll: -0.05 * yaw, shift: Vec3::ZERO }
            }
            // 1.4 Hz, chin down 22 degrees and up 5.
            Self::Nod => {
                let wave = 0.5 - 0.5 * (TAU * 1.4 * t).cos();
                let swell = minimum_jerk(t / 0.3) * (1.0 - minimum_jerk((t - 1.84) / 0.3));
                HeadPose { pitch: (22.0 * wave - 5.0 * (1.0 - wave)).to_radians() * swell, ..HeadPose::default() }
            }
            // 1.8 Hz over 2 x 24 degrees peaks at 270 deg/s.
            Self::Shake => {
                let swell = minimum_jerk(t / 0.5) * (1.0 - minimum_jerk((t - 1.7) / 0.6));
                HeadPose { yaw: 24_f32.to_radians() * (TAU * 1.8 * t).sin() * swell, ..HeadPose::default() }
            }
        }
    }

    /// As [`Motion::head_pose`], as the transform about a pivot such as [`neck_pivot`].
    pub fn pose(self, t_secs: f32, pivot: Vec3) -> Affine3A {
        self.head_pose(t_secs).world_from_head(pivot)
    }
}

/// From 0 at 0 to 1 at 1 with no velocity and no acceleration at either end.
fn minimum_jerk(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
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

    fn angle(motion: Motion, t: f32) -> f32 {
        let pose = motion.head_pose(t);
        Quat::from_euler(EulerRot::YXZ, pose.yaw, pose.pitch, pose.roll).angle_between(Quat::IDENTITY)
    }

    #[test]
    fn presets_start_and_end_at_rest_and_move_as_a_head_can() {
        for &motion in Motion::ALL {
            let period = motion.period_secs();
            assert!(angle(motion, 0.0) < 1e-4 && angle(motion, period * 0.9999) < 1e-3, "{motion:?}");
            let dt = 1.0 / 240.0;
            let mut fastest = 0.0_f32;
            let mut largest = 0.0_f32;
            let mut previous = Quat::IDENTITY;
            for step in 1..=(period / dt) as u32 {
                let pose = motion.pose(step as f32 * dt, Vec3::ZERO);
                let (_, rotation, _) = pose.to_scale_rotation_translation();
                fastest = fastest.max(rotation.angle_between(previous).to_degrees() / dt);
                largest = largest.max(rotation.angle_between(Quat::IDENTITY).to_degrees());
                previous = rotation;
                // The first step is slow: nothing jerks.
                assert!(step > 1 || fastest < 10.0, "{motion:?} starts at {fastest} deg/s");
            }
            assert!(largest < 75.0 && fastest < 400.0, "{motion:?}: {largest} deg at {fastest} deg/s");
            assert!(motion == Motion::None || largest > 15.0, "{motion:?} moves {largest} deg");
        }
        assert_eq!(Motion::Turn.head_pose(f32::NAN), HeadPose::default());
    }

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
