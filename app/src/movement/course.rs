//! What happens to a groom, as functions of time alone: the same time, the same pose and the same air.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use lorelei_core::camera::direction_from_deg;
use lorelei_core::groom::Groom;
use lorelei_core::motion::{HeadPose, Motion, Movement, PoseTrack};
use lorelei_core::simulation::{SimulationSettings, Wind};

use crate::stage::neck_of;

/// The head's motion and the settings that follow it.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    pub motion: Motion,
    /// Keyed poses beneath it.
    pub track: Option<Arc<PoseTrack>>,
    /// What the head turns about, head space.
    pub neck: Vec3,
    pub settings: SimulationSettings,
}

impl Course {
    pub fn of(groom: &Groom) -> Self {
        let Movement { motion, track, .. } = &groom.movement;
        let settings = groom.simulation.clone();
        Self { motion: *motion, track: track.clone(), neck: neck_of(groom), settings }
    }

    /// Nothing happens.
    pub fn still(neck: Vec3, settings: SimulationSettings) -> Self {
        Self { motion: Motion::None, track: None, neck, settings }
    }

    /// World from head at a time.
    pub fn pose(&self, secs: f32) -> Affine3A {
        self.pose_with(secs, HeadPose::default())
    }

    /// As [`Course::pose`], dragged somewhere else.
    pub fn pose_with(&self, secs: f32, dragged: HeadPose) -> Affine3A {
        let of_head = (self.motion.head_pose(secs) + dragged).world_from_head(self.neck);
        match &self.track {
            Some(track) => track.world_from_body(secs, self.neck) * of_head,
            None => of_head,
        }
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
        let preset = if period > 0.0 { (secs / period - 1e-4).ceil().max(0.0) * period } else { secs };
        self.track.as_ref().map_or(preset, |track| preset.max(track.secs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_ends_where_its_preset_rests() {
        let course = Course { motion: Motion::Shake, ..Course::still(Vec3::ZERO, SimulationSettings::default()) };
        let period = Motion::Shake.period_secs();
        assert_eq!(course.end_after(0.0), 0.0);
        assert_eq!(course.end_after(1.0), period);
        assert_eq!(course.end_after(period), period);
        assert_eq!(Course { motion: Motion::None, ..course }.end_after(1.0), 1.0);
    }
}
