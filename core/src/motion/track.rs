//! A movement as keyed poses, such as one that was read from a glTF animation: plain data of the document.

use glam::{Affine3A, Quat, Vec3};
use serde::{Deserialize, Serialize};

/// Where a body is at a time, against where it is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseKey {
    pub secs: f32,
    /// A unit quaternion.
    pub rotation: Quat,
    /// Centimetres.
    pub shift: Vec3,
}

/// Keys in ascending order of time; in between, shifts are interpolated linearly and rotations along the shortest arc.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct PoseTrack {
    /// What it was read from, for a person.
    pub name: String,
    pub keys: Vec<PoseKey>,
}

impl PoseTrack {
    /// Time of the last key.
    pub fn secs(&self) -> f32 {
        self.keys.last().map_or(0.0, |key| key.secs)
    }

    /// The pose at a time: before the first key and behind the last one theirs. A track without keys, and keys that are no
    /// numbers, are the rest pose.
    pub fn at(&self, secs: f32) -> (Quat, Vec3) {
        let behind = self.keys.partition_point(|key| key.secs <= secs);
        let (before, after) = match (self.keys.get(behind.wrapping_sub(1)), self.keys.get(behind)) {
            (Some(before), Some(after)) => (before, after),
            (Some(only), None) | (None, Some(only)) => (only, only),
            (None, None) => return (Quat::IDENTITY, Vec3::ZERO),
        };
        let share = ((secs - before.secs) / (after.secs - before.secs).max(1e-6)).clamp(0.0, 1.0);
        let share = if share.is_finite() { share } else { 0.0 };
        let (from, mut to) = (before.rotation, after.rotation);
        if from.dot(to) < 0.0 {
            to = -to;
        }
        let rotation = if from == to { from } else { from.slerp(to, share) };
        let rotation = if rotation.is_finite() && rotation.length_squared() > 1e-6 {
            rotation.normalize()
        } else {
            Quat::IDENTITY
        };
        let shift = before.shift.lerp(after.shift, share);
        (rotation, if shift.is_finite() { shift } else { Vec3::ZERO })
    }

    /// The transform about a pivot in head space.
    pub fn world_from_body(&self, secs: f32, pivot: Vec3) -> Affine3A {
        let (rotation, shift) = self.at(secs);
        Affine3A::from_rotation_translation(rotation, pivot + shift - rotation * pivot)
    }

    /// Without keys that the others give within `cm` and `radians`.
    pub fn simplified(mut self, cm: f32, radians: f32) -> Self {
        let mut kept: Vec<PoseKey> = Vec::new();
        let mut first = 0;
        while first < self.keys.len() {
            kept.push(self.keys[first]);
            // The farthest key to which a straight piece passes all in between.
            let mut last = first + 1;
            while last + 1 < self.keys.len() {
                let piece = Self { name: String::new(), keys: vec![self.keys[first], self.keys[last + 1]] };
                let is_straight = self.keys[first + 1..=last].iter().all(|key| {
                    let (rotation, shift) = piece.at(key.secs);
                    shift.distance(key.shift) <= cm && rotation.angle_between(key.rotation) <= radians
                });
                if !is_straight || last - first > 240 {
                    break;
                }
                last += 1;
            }
            first = last;
        }
        self.keys = kept;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(secs: f32, yaw: f32, x: f32) -> PoseKey {
        PoseKey { secs, rotation: Quat::from_rotation_y(yaw), shift: Vec3::X * x }
    }

    #[test]
    fn a_track_passes_its_keys_and_stays_at_its_ends() {
        let track =
            PoseTrack { name: String::new(), keys: vec![key(1.0, 0.0, 0.0), key(2.0, 1.0, 4.0), key(3.0, 0.5, 4.0)] };
        assert_eq!(track.at(0.0), track.at(1.0));
        assert_eq!(track.at(9.0), track.at(3.0));
        let (rotation, shift) = track.at(1.5);
        assert!(rotation.angle_between(Quat::from_rotation_y(0.5)) < 1e-3 && shift.distance(Vec3::X * 2.0) < 1e-5);
        let pivot = Vec3::new(1.0, 2.0, 3.0);
        let moved = track.world_from_body(2.0, pivot).transform_point3(pivot);
        assert!(moved.distance(pivot + Vec3::X * 4.0) < 1e-4);
    }

    #[test]
    fn broken_tracks_are_the_rest_pose_and_never_nan() {
        assert_eq!(PoseTrack::default().at(1.0), (Quat::IDENTITY, Vec3::ZERO));
        let nan = f32::NAN;
        let broken = PoseKey { secs: nan, rotation: Quat::from_xyzw(nan, 0.0, 0.0, 0.0), shift: Vec3::splat(nan) };
        let track = PoseTrack { name: String::new(), keys: vec![broken, key(1.0, 0.0, 1.0), broken] };
        for secs in [nan, -1.0, 0.5, 1.0, 2.0, f32::INFINITY] {
            let (rotation, shift) = track.at(secs);
            assert!(rotation.is_finite() && shift.is_finite(), "{secs}");
        }
    }

    #[test]
    fn simplified_tracks_move_the_same_with_fewer_keys() {
        let keys: Vec<PoseKey> = (0..100)
            .map(|i| {
                let t = i as f32 * 0.02;
                key(t, if t < 1.0 { 0.0 } else { 0.7 * (t - 1.0) }, t)
            })
            .collect();
        let whole = PoseTrack { name: String::new(), keys };
        let simple = whole.clone().simplified(1e-3, 1e-3);
        assert!(simple.keys.len() < 8, "{}", simple.keys.len());
        for i in 0..200 {
            let t = i as f32 * 0.01;
            let ((ra, sa), (rb, sb)) = (whole.at(t), simple.at(t));
            assert!(ra.angle_between(rb) < 3e-3 && sa.distance(sb) < 3e-3, "{t}");
        }
        assert_eq!(simple.secs(), whole.secs());
    }
}
