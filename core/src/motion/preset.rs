//! The preset movements as functions of time: where the head is, and how the air moves.
//!
//! Presets are minimum-jerk moves (Flash and Hogan 1985), which human head turns follow closely, sinusoids that swell
//! and fade, and a jump that is a parabola between two bends of the knees. Each starts at rest, ends at rest and
//! repeats, with a pause in which the hair can be seen to settle.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};

use super::HeadPose;
use crate::look::{Choice, ChoiceInfo, choices};

choices! {
    /// A preset movement.
    #[derive(Default)]
    Motion {
        #[default]
        None = "none", "Still", "The head rests, or goes where it is dragged";
        Turn = "turn", "Turn", "Looks over one shoulder, then over the other";
        Nod = "nod", "Nod", "Yes: three nods and a pause";
        Shake = "shake", "Shake", "No: a brisk shake and a pause";
        Walk = "walk", "Walk", "Nine steps on the spot in the air of a walk, and a pause";
        Jump = "jump", "Jump", "Bends the knees, jumps 18 cm high, lands, and a pause";
        Gust = "gust", "Gust", "The head rests; two gusts of wind come over it from where the wind is set to blow";
    }
}

/// Steps a second: 110 a minute, a walk's usual cadence.
const CADENCE: f32 = 1.83;
/// Speed of that walk, cm/s: the air comes towards whoever walks.
const WALKING_SPEED: f32 = 130.0;
/// What a gust adds at its strongest, cm/s: a fresh breeze of 9 m/s.
const GUST_SPEED: f32 = 900.0;
/// Height of the jump, centimetres, and its fall.
const JUMP_HEIGHT: f32 = 18.0;
const FALL: f32 = 981.0;

impl Motion {
    /// Seconds after which the preset repeats; 0 where it does not.
    pub fn period_secs(self) -> f32 {
        match self {
            Self::None => 0.0,
            Self::Turn => 5.6,
            Self::Nod | Self::Shake => 4.5,
            Self::Walk => 8.0,
            Self::Jump => 4.0,
            Self::Gust => 7.0,
        }
    }

    /// A time within the period; `None` before the start and where it is no number.
    fn within_period(self, t_secs: f32) -> Option<f32> {
        let is_time = t_secs.is_finite() && t_secs >= 0.0;
        is_time.then(|| if self.period_secs() > 0.0 { t_secs % self.period_secs() } else { 0.0 })
    }

    /// The head's pose a time after the start. Negative and non-finite times are the rest pose.
    pub fn head_pose(self, t_secs: f32) -> HeadPose {
        let Some(t) = self.within_period(t_secs) else { return HeadPose::default() };
        match self {
            Self::None | Self::Gust => HeadPose::default(),
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
            Self::Walk => walk(t),
            Self::Jump => jump(t),
        }
    }

    /// Velocity of the air, cm/s, a time after the start, where `steady` is the wind that is set and `direction` (a unit
    /// vector) where it blows to.
    pub fn wind(self, t_secs: f32, steady: Vec3, direction: Vec3) -> Vec3 {
        let Some(t) = self.within_period(t_secs) else { return steady };
        match self {
            Self::None | Self::Turn | Self::Nod | Self::Shake | Self::Jump => steady,
            Self::Walk => steady - Vec3::Z * (WALKING_SPEED * walking(t)),
            Self::Gust => steady + direction * (GUST_SPEED * gust(t)),
        }
    }

    /// Whether [`Motion::wind`] is ever another than the steady wind.
    pub fn moves_air(self) -> bool {
        match self {
            Self::Walk | Self::Gust => true,
            Self::None | Self::Turn | Self::Nod | Self::Shake | Self::Jump => false,
        }
    }

    /// As [`Motion::head_pose`], as the transform about a pivot such as [`super::neck_pivot`].
    pub fn pose(self, t_secs: f32, pivot: Vec3) -> Affine3A {
        self.head_pose(t_secs).world_from_head(pivot)
    }
}

/// From standing to walking and back, 0-1.
fn walking(t: f32) -> f32 {
    minimum_jerk(t / 0.8) * (1.0 - minimum_jerk((t - 5.0) / 0.8))
}

/// A head of somebody who walks: up and down 4 cm with every step, aside 4 cm and back with every second, as in
/// Murray et al. 1964, "Walking patterns of normal men"; the gaze stays ahead, so pitch and yaw go against the shift.
fn walk(t: f32) -> HeadPose {
    let (share, step) = (walking(t), TAU * CADENCE * t);
    let stride = 0.5 * step;
    HeadPose {
        yaw: share * 2.5_f32.to_radians() * stride.sin(),
        pitch: share * 1.8_f32.to_radians() * step.cos(),
        roll: share * -1.5_f32.to_radians() * stride.sin(),
        shift: share * Vec3::new(2.0 * stride.sin(), -2.0 * step.cos(), 0.8 * step.sin()),
    }
}

/// Down 14 cm, up to the parabola of a jump, down 14 cm again and upright. Position, velocity and acceleration are
/// continuous.
fn jump(t: f32) -> HeadPose {
    const KNEES: f32 = 14.0;
    // Push-off and landing take about as long as an even acceleration between rest and take-off would.
    const PUSH: f32 = 0.2;
    let take_off = (2.0 * FALL * JUMP_HEIGHT).sqrt();
    let flight = 2.0 * take_off / FALL;
    let (down, up) = (0.55, 0.55 + PUSH);
    let landing = up + flight;
    let low = landing + PUSH;
    let y = if t < down {
        -KNEES * minimum_jerk(t / down)
    } else if t < up {
        quintic(t - down, PUSH, [-KNEES, 0.0, 0.0], [0.0, take_off, -FALL])
    } else if t < landing {
        (take_off - 0.5 * FALL * (t - up)) * (t - up)
    } else if t < low {
        quintic(t - landing, PUSH, [0.0, -take_off, -FALL], [-KNEES, 0.0, 0.0])
    } else {
        -KNEES * (1.0 - minimum_jerk((t - low) / 0.6))
    };
    // The chin goes down with the knees.
    HeadPose { pitch: 8_f32.to_radians() * (-y / KNEES).max(0.0).powi(3).min(1.0), ..HeadPose::default() }
        .shifted(Vec3::Y * y)
}

/// Strength of the air above the steady wind, 0-1: a long gust and a shorter one, each of the shape 1 - cos
/// (MIL-F-8785C), with flutter on top where they are strong.
fn gust(t: f32) -> f32 {
    let swell = |from: f32, secs: f32| {
        let share = ((t - from) / secs).clamp(0.0, 1.0);
        0.5 - 0.5 * (TAU * share).cos()
    };
    let strength = swell(0.1, 2.4) + 0.7 * swell(2.3, 1.5);
    let flutter = 0.12 * (TAU * 2.7 * t).sin() + 0.08 * (TAU * 4.9 * t + 1.0).sin();
    strength * (1.0 + flutter)
}

/// From 0 at 0 to 1 at 1 with no velocity and no acceleration at either end.
fn minimum_jerk(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

/// The polynomial of degree five with a place, a velocity and an acceleration at 0 and at `secs`.
fn quintic(t: f32, secs: f32, [p0, v0, a0]: [f32; 3], [p1, v1, a1]: [f32; 3]) -> f32 {
    let u = (t / secs).clamp(0.0, 1.0);
    let (v0, v1, a0, a1) = (v0 * secs, v1 * secs, a0 * secs * secs, a1 * secs * secs);
    let rise = p1 - p0;
    let c3 = 10.0 * rise - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
    let c4 = -15.0 * rise + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
    let c5 = 6.0 * rise - 3.0 * (v0 + v1) - 0.5 * (a0 - a1);
    p0 + u * (v0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5))))
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    fn angle(motion: Motion, t: f32) -> f32 {
        let pose = motion.head_pose(t);
        pose.rotation().angle_between(Quat::IDENTITY)
    }

    #[test]
    fn presets_start_and_end_at_rest_and_move_as_a_head_can() {
        for &motion in Motion::ALL {
            let period = motion.period_secs();
            assert!(angle(motion, 0.0) < 1e-4 && angle(motion, period * 0.9999) < 1e-3, "{motion:?}");
            let dt = 1.0 / 240.0;
            let (mut fastest, mut largest, mut shifted) = (0.0_f32, 0.0_f32, 0.0_f32);
            let (mut quickest, mut hardest) = (0.0_f32, 0.0_f32);
            let (mut previous, mut shift, mut velocity) = (Quat::IDENTITY, Vec3::ZERO, Vec3::ZERO);
            for step in 1..=(period / dt) as u32 {
                let t = step as f32 * dt;
                let (_, rotation, translation) = motion.pose(t, Vec3::ZERO).to_scale_rotation_translation();
                fastest = fastest.max(rotation.angle_between(previous).to_degrees() / dt);
                largest = largest.max(rotation.angle_between(Quat::IDENTITY).to_degrees());
                shifted = shifted.max(translation.length());
                let now = (translation - shift) / dt;
                hardest = hardest.max((now - velocity).length() / dt);
                quickest = quickest.max(now.length());
                (previous, shift, velocity) = (rotation, translation, now);
                // The first step is slow: nothing jerks.
                assert!(step > 1 || (fastest < 10.0 && quickest < 10.0), "{motion:?} starts at {fastest} deg/s");
            }
            assert!(shift.length() < 1e-3 && velocity.length() < 1e-2, "{motion:?} ends at {shift}");
            assert!(largest < 75.0 && fastest < 400.0, "{motion:?}: {largest} deg at {fastest} deg/s");
            // Three times its weight is what a jump puts on somebody; a gap in a course would be a hundred times.
            assert!(quickest < 250.0 && hardest < 3500.0, "{motion:?}: {quickest} cm/s, {hardest} cm/s2");
            assert!(
                motion == Motion::None || motion.moves_air() || largest > 15.0 || shifted > 15.0,
                "{motion:?} moves {largest} deg and {shifted} cm"
            );
        }
        assert_eq!(Motion::Turn.head_pose(f32::NAN), HeadPose::default());
    }

    #[test]
    fn a_jump_falls_as_everything_falls() {
        let dt = 1e-2;
        let y = |t: f32| Motion::Jump.head_pose(t).shift.y;
        let top = (0..400).map(|i| i as f32 * 0.01).max_by(|a, b| y(*a).total_cmp(&y(*b))).unwrap();
        assert!((y(top) - JUMP_HEIGHT).abs() < 0.2, "{}", y(top));
        let fall = (y(top + dt) - 2.0 * y(top) + y(top - dt)) / (dt * dt);
        assert!((fall + FALL).abs() < 20.0, "{fall} cm/s2");
    }

    #[test]
    fn gusts_add_to_the_wind_that_is_set_and_cease() {
        let steady = Vec3::X * 100.0;
        let speed = |t: f32| Motion::Gust.wind(t, steady, Vec3::X).x;
        assert!((speed(0.0) - 100.0).abs() < 1e-3 && (speed(6.9) - 100.0).abs() < 1e-3);
        let strongest = (0..700).map(|i| speed(i as f32 * 0.01)).fold(0.0, f32::max);
        assert!((850.0..1300.0).contains(&strongest), "{strongest} cm/s");
        assert!((0..700).all(|i| speed(i as f32 * 0.01) >= 99.0));
        for &motion in Motion::ALL {
            let is_steady = (0..800).all(|i| motion.wind(i as f32 * 0.01, steady, Vec3::X) == steady);
            assert_eq!(is_steady, !motion.moves_air(), "{motion:?}");
            assert_eq!(motion.wind(f32::NAN, steady, Vec3::X), steady);
        }
    }
}
