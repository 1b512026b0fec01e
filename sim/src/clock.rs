//! Cuts frames of any length into steps of one length, and says where the head is at each.
//!
//! The head's pose is known at the frames; at a step between two of them it is interpolated. What is left of
//! a frame is carried over, and the picture extrapolates over it, so that neither the frame rate nor its
//! jitter shows in the movement.

use crate::pose::Pose;

/// Steps that one frame may take: a quarter of a second at 240 steps a second. Time beyond is dropped, or
/// a slow frame would make the next one slower.
pub const MAX_STEPS_PER_FRAME: usize = 64;
/// Moving the head farther than this between two frames carries the hair along unswung, centimetres.
const TELEPORT_SHIFT: f32 = 30.0;
/// Likewise, radians. The fastest preset turns 27 degrees in a frame of a tenth of a second.
const TELEPORT_TURN: f32 = 1.1;

/// What one call of `advance` does.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Move everything rigidly first: the head was put somewhere else.
    pub carry: Option<Pose>,
    /// The head before the first step, then after each: one more than there are steps.
    pub poses: Vec<Pose>,
    /// The head as the picture shows it.
    pub shown: Pose,
    /// How far the picture is past the last step, in steps (0-1).
    pub ahead: f32,
}

impl Frame {
    pub fn n_steps(&self) -> usize {
        self.poses.len() - 1
    }
}

/// Time and pose between frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Seconds of the frames so far that no step has covered yet.
    left_secs: f64,
    /// The head at the last step.
    at_step: Pose,
    /// The head at the last frame.
    at_frame: Pose,
}

impl Clock {
    /// At rest at a pose.
    pub fn new(pose: Pose) -> Self {
        Self { left_secs: 0.0, at_step: pose, at_frame: pose }
    }

    /// Let `frame_secs` pass, at the end of which the head is at `pose`. Time that is not finite or negative
    /// stands still; while it does, hair moves rigidly with the head.
    pub fn advance(&mut self, frame_secs: f32, step_secs: f64, pose: Pose) -> Frame {
        let frame_secs = if frame_secs.is_finite() { f64::from(frame_secs.max(0.0)) } else { 0.0 };
        if frame_secs == 0.0 || is_far(&pose, &self.at_frame) {
            let carry = (pose != self.at_step).then(|| pose.after_inverse_of(&self.at_step));
            self.at_step = pose;
            self.at_frame = pose;
            if frame_secs == 0.0 {
                let ahead = (self.left_secs / step_secs).clamp(0.0, 1.0) as f32;
                return Frame { carry, poses: vec![pose], shown: pose, ahead };
            }
            return Frame { carry, ..self.steps(frame_secs, step_secs, pose) };
        }
        self.steps(frame_secs, step_secs, pose)
    }

    pub(crate) const N_NUMBERS: usize = 1 + 2 * Pose::N_NUMBERS;

    pub(crate) fn to_numbers(&self) -> [f64; Self::N_NUMBERS] {
        let mut numbers = [self.left_secs; Self::N_NUMBERS];
        numbers[1..=Pose::N_NUMBERS].copy_from_slice(&self.at_step.to_numbers());
        numbers[1 + Pose::N_NUMBERS..].copy_from_slice(&self.at_frame.to_numbers());
        numbers
    }

    pub(crate) fn of_numbers(numbers: &[f64]) -> Option<Self> {
        let (&left_secs, poses) = numbers.split_first()?;
        let (at_step, at_frame) = poses.split_at_checked(Pose::N_NUMBERS)?;
        let is_time = left_secs.is_finite() && left_secs >= 0.0;
        is_time.then_some(())?;
        Some(Self { left_secs, at_step: Pose::of_numbers(at_step)?, at_frame: Pose::of_numbers(at_frame)? })
    }

    /// Where the head was at the last step.
    pub fn pose_at_step(&self) -> Pose {
        self.at_step
    }

    /// Exactly one step, at the end of which the head is at `pose`.
    pub fn step_once(&mut self, pose: Pose) -> Frame {
        let carry = is_far(&pose, &self.at_step).then(|| pose.after_inverse_of(&self.at_step));
        let before = if carry.is_some() { pose } else { self.at_step };
        *self = Self::new(pose);
        Frame { carry, poses: vec![before, pose], shown: pose, ahead: 0.0 }
    }

    fn steps(&mut self, frame_secs: f64, step_secs: f64, pose: Pose) -> Frame {
        // A thousandth of a step is given, so that frames of exactly four steps are not cut 3, 5, 4.
        let n_due = ((self.left_secs + frame_secs) / step_secs + 1e-3).floor();
        let n_steps = n_due.min(MAX_STEPS_PER_FRAME as f64) as usize;
        let dropped = n_due > MAX_STEPS_PER_FRAME as f64;
        let mut poses = vec![self.at_step];
        for step in 1..=n_steps {
            let t = if dropped {
                step as f64 / n_steps as f64
            } else {
                (step as f64 * step_secs - self.left_secs) / frame_secs
            };
            poses.push(self.at_frame.lerp(&pose, t.clamp(0.0, 1.0) as f32));
        }
        self.left_secs =
            if dropped { 0.0 } else { (self.left_secs + frame_secs - n_steps as f64 * step_secs).max(0.0) };
        self.at_step = poses[n_steps];
        self.at_frame = pose;
        Frame { carry: None, poses, shown: pose, ahead: (self.left_secs / step_secs).clamp(0.0, 1.0) as f32 }
    }
}

/// Farther than heads move in a frame.
fn is_far(a: &Pose, b: &Pose) -> bool {
    a.translation.distance(b.translation) > TELEPORT_SHIFT || a.rotation.angle_between(b.rotation) > TELEPORT_TURN
}

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::*;

    fn turned(yaw: f32) -> Pose {
        Pose { rotation: Quat::from_rotation_y(yaw), translation: Vec3::new(yaw, 0.0, 0.0) }
    }

    #[test]
    fn every_frame_rate_takes_the_same_steps_at_the_same_poses() {
        let step_secs = 1.0 / 240.0;
        let poses_at = |frames_per_second: u32| {
            let mut clock = Clock::new(Pose::IDENTITY);
            let mut poses = Vec::new();
            for frame in 1..=frames_per_second {
                // A steady turn is linear between frames, whichever they are.
                let pose = turned(0.5 * frame as f32 / frames_per_second as f32);
                let frame = clock.advance(1.0 / frames_per_second as f32, step_secs, pose);
                poses.extend_from_slice(&frame.poses[1..]);
            }
            poses
        };
        let reference = poses_at(30);
        assert_eq!(reference.len(), 240);
        for frames_per_second in [60, 144, 7] {
            let poses = poses_at(frames_per_second);
            assert_eq!(poses.len(), 240, "{frames_per_second}");
            for (a, b) in reference.iter().zip(&poses) {
                assert!(a.rotation.angle_between(b.rotation) < 2e-3 && a.translation.distance(b.translation) < 1e-4);
            }
        }
    }

    #[test]
    fn long_and_broken_frames_are_bounded() {
        let mut clock = Clock::new(Pose::IDENTITY);
        for frame_secs in [1e30, f32::INFINITY, f32::NAN, -1.0, 0.0, 100.0] {
            let frame = clock.advance(frame_secs, 1.0 / 240.0, turned(0.1));
            assert!(frame.n_steps() <= MAX_STEPS_PER_FRAME && (0.0..=1.0).contains(&frame.ahead));
        }
    }

    #[test]
    fn a_far_move_carries_the_hair() {
        let mut clock = Clock::new(Pose::IDENTITY);
        let far = Pose { rotation: Quat::from_rotation_y(2.0), translation: Vec3::splat(100.0) };
        let frame = clock.advance(1.0 / 60.0, 1.0 / 240.0, far);
        let carry = frame.carry.unwrap();
        assert!(carry.apply(Vec3::ONE).distance(far.apply(Vec3::ONE)) < 1e-4);
        assert!(frame.poses.iter().all(|pose| *pose == far));
        assert!(clock.advance(1.0 / 60.0, 1.0 / 240.0, far).carry.is_none());
    }
}
