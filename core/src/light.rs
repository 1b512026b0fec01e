//! Lights, and the rig of three that a salon photograph uses.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::camera::direction_from_deg;

/// One light. Colours are linear RGB in Rec. 709 primaries.
///
/// **Unit.** `intensity` is the radiance that a white diffuse card facing the light shows, in display units: 1 is
/// white before exposure. The light's irradiance there is therefore E = pi * intensity * colour, and a
/// diffuse surface of albedo a shows a * intensity * colour * cos. For a [`LightKind::Directional`] the card may be
/// anywhere; for the others it is 100 cm from the light (from a small rectangle: on its axis), and E falls with the
/// square of the distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Light {
    pub name: String,
    pub on: bool,
    pub kind: LightKind,
    pub colour: [f32; 3],
    /// See above.
    pub intensity: f32,
    pub casts_shadow: bool,
}

/// Where the light comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum LightKind {
    /// Parallel light from a direction, given as azimuth (0 = front) and elevation.
    Directional { azimuth_deg: f32, elevation_deg: f32 },
    /// A point (small sphere) in world centimetres.
    Point { position: Vec3 },
    /// A square that emits evenly from its face, which looks at `target`. World centimetres; `size` is its side.
    Rect { position: Vec3, target: Vec3, size: f32 },
}

impl Default for Light {
    fn default() -> Self {
        Self::directional("light", 30.0, 40.0, 1.0, [1.0; 3])
    }
}

/// Distance at which [`Light::intensity`] holds for lights that have a place, centimetres.
pub const INTENSITY_DISTANCE: f32 = 100.0;

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

    /// A square area light of a radiant power, as other programs give it (Blender's area lights).
    ///
    /// A flat emitter of power P and area A has radiance P / (pi A), so on its axis at distance d the irradiance is
    /// P / (pi d^2) and the intensity, at d = 1 m, P / pi^2: the size does not enter.
    pub fn rect_from_watts(name: &str, position: Vec3, target: Vec3, size: f32, watts: f32) -> Self {
        Self {
            name: name.to_owned(),
            on: true,
            kind: LightKind::Rect { position, target, size },
            colour: [1.0; 3],
            intensity: watts / std::f32::consts::PI.powi(2),
            casts_shadow: true,
        }
    }

    /// Unit vector from `at` towards the light (its middle).
    pub fn direction_to(&self, at: Vec3) -> Vec3 {
        match self.kind {
            LightKind::Directional { azimuth_deg, elevation_deg } => direction_from_deg(azimuth_deg, elevation_deg),
            LightKind::Point { position } | LightKind::Rect { position, .. } => (position - at).normalize_or(Vec3::Y),
        }
    }
}

impl Light {
    /// Let the light come from a direction, seen from `at`; its distance stays.
    pub fn aim_from(&mut self, at: Vec3, direction: Vec3) {
        match &mut self.kind {
            LightKind::Directional { azimuth_deg, elevation_deg } => {
                *azimuth_deg = direction.x.atan2(direction.z).to_degrees();
                *elevation_deg = direction.y.clamp(-1.0, 1.0).asin().to_degrees();
            }
            LightKind::Point { position } => *position = at + position.distance(at) * direction,
            LightKind::Rect { position, target, .. } => {
                *position = at + position.distance(at) * direction;
                *target = at;
            }
        }
    }
}

/// Key 30-45 degrees to the side and above, a weaker cool fill, a rim from behind.
pub fn three_point_rig() -> Vec<Light> {
    vec![
        Light::directional("key", 42.0, 38.0, 1.5, [1.0, 0.96, 0.90]),
        Light::directional("fill", -50.0, 12.0, 0.7, [0.86, 0.93, 1.0]),
        Light::directional("rim", 205.0, 32.0, 0.8, [1.0, 0.98, 0.95]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn watts_become_what_a_card_at_a_metre_shows() {
        let light = Light::rect_from_watts("key", Vec3::ZERO, Vec3::Z, 50.0, 25.0);
        // Integrate the emitter's radiance 25 W / (pi A) over its square, seen from 10 m on its axis, W and m.
        let (side, distance) = (0.5f32, 10.0f32);
        let radiance = 25.0 / (std::f32::consts::PI * side * side);
        let n = 50;
        let mut irradiance = 0.0;
        for i in 0..n * n {
            let at = |k: usize| (k as f32 + 0.5) / n as f32 * side - 0.5 * side;
            let (x, y) = (at(i % n), at(i / n));
            let d2 = x * x + y * y + distance * distance;
            let cos = distance / d2.sqrt();
            irradiance += radiance * cos * cos / d2 * (side / n as f32).powi(2);
        }
        let at_a_metre = irradiance * distance * distance;
        assert!((light.intensity * std::f32::consts::PI / at_a_metre - 1.0).abs() < 2e-3);
    }
}
