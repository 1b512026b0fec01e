//! Lights, and the rig of three that a salon photograph uses.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::camera::direction_from_deg;

/// One light. Colours are linear RGB in Rec. 709 primaries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Light {
    pub name: String,
    pub on: bool,
    pub kind: LightKind,
    pub colour: [f32; 3],
    /// Irradiance that the light gives to a surface facing it at the rig's target, in units of pi times the
    /// radiance that displays as white before exposure. So 1.0 on a white diffuse card gives radiance 1/pi * pi = 1.
    pub intensity: f32,
    pub casts_shadow: bool,
}

/// Where the light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LightKind {
    /// Parallel light from a direction, given as azimuth (0 = front) and elevation.
    Directional { azimuth_deg: f32, elevation_deg: f32 },
    /// A point (small sphere) in world centimetres. `intensity` holds at the distance of the rig's target.
    Point { position: Vec3 },
}

impl Default for Light {
    fn default() -> Self {
        Self::directional("light", 30.0, 40.0, 1.0, [1.0; 3])
    }
}

impl Light {
    pub fn directional(name: &str, azimuth_deg: f32, elevation_deg: f32, intensity: f32, colour: [f32; 3]) -> Self {
        Self {
            name: name.to_owned(),
            on: true,
            kind: LightKind::Directional { azimuth_deg, elevation_deg },
            colour,
            intensity,
            casts_shadow: true,
        }
    }

    /// Unit vector from `at` towards the light.
    pub fn direction_to(&self, at: Vec3) -> Vec3 {
        match self.kind {
            LightKind::Directional { azimuth_deg, elevation_deg } => direction_from_deg(azimuth_deg, elevation_deg),
            LightKind::Point { position } => (position - at).normalize_or(Vec3::Y),
        }
    }
}

/// Key 30-45 degrees to the side and above, a weaker cool fill, a rim from behind.
pub fn three_point_rig() -> Vec<Light> {
    vec![
        Light::directional("key", 40.0, 40.0, 2.6, [1.0, 0.96, 0.90]),
        Light::directional("fill", -50.0, 12.0, 0.7, [0.86, 0.93, 1.0]),
        Light::directional("rim", 190.0, 45.0, 2.4, [1.0, 0.98, 0.95]),
    ]
}
