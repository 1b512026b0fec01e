//! What happens to a groom, as functions of time alone: the same time, the same pose and the same air.

use glam::{Affine3A, Vec3};
use lorelei_core::camera::direction_from_deg;
use lorelei_core::groom::Groom;
use lorelei_core::motion::{HeadPose, Motion};
use lorelei_core::simulation::{SimulationSettings, Wind};

use crate::stage::neck_of;

/// The head's motion and the settings that follow it.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    pub motion: Motion,
    /// What the head turns about, head space.
    pub neck: Vec3,
    pub settings: SimulationSettings,
}

impl Course {
    pub fn of(groom: &Groom, motion: Motion) -> Self {
        Self { motion, neck: neck_of(groom), settings: groom.simulation.clone() }
    }

    /// World from head at a time.
    pub fn pose(&self, secs: f32) -> Affine3A {
        self.pose_with(secs, HeadPose::default())
    }

    /// As [`Course::pose`], dragged somewhere else.
    pub fn pose_with(&self, secs: f32, dragged: HeadPose) -> Affine3A {
        (self.motion.head_pose(secs) + dragged).world_from_head(self.neck)
    }

    /// The solver's settings at a time.
    pub fn settings_at(&self, secs: f32) -> SimulationSettings {
        let mut settings = self.settings.clone();
        if self.motion.moves_air() {
            let direction = direction_from_deg(settings.wind_azimuth_deg, settings.wind_elevation_deg);
            let steady = if settings.wind == Wind::Off { Vec3::ZERO } else { settings.wind_velocity() };
            settings.set_wind_velocity(self.motion.wind(secs, steady, direction));
        }
        settings
    }

    /// The first time from `secs` on at which a preset has come to its end, where head and air are still.
    pub fn end_after(&self, secs: f32) -> f32 {
        let period = self.motion.period_secs();
        if period > 0.0 { (secs / period - 1e-4).ceil().max(0.0) * period } else { secs }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_ends_where_its_preset_rests() {
        let course = Course { motion: Motion::Shake, neck: Vec3::ZERO, settings: SimulationSettings::default() };
        let period = Motion::Shake.period_secs();
        assert_eq!(course.end_after(0.0), 0.0);
        assert_eq!(course.end_after(1.0), period);
        assert_eq!(course.end_after(period), period);
        assert_eq!(Course { motion: Motion::None, ..course }.end_after(1.0), 1.0);
    }
}
