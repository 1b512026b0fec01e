//! A light's view of the scene: parallel or perspective, around the ball that holds head and hair.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, Vec3, Vec4};

use crate::scene::{Ball, SceneLight};

/// Twin of `ShadowLight` in `shadow_map.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct ShadowLight {
    /// World centimetres to (texel x * w, texel y * w, depth along the light's axis in cm, w); columns.
    pub map_from_world: [f32; 16],
    /// As [`SceneLight::place`].
    pub place: [f32; 4],
    /// Texels of one centimetre at w = 1.
    pub texels_per_cm: f32,
    pub casts: u32,
    /// Depths between which everything lies, centimetres.
    pub near: f32,
    pub far: f32,
    /// Radius of the blur of a shadow's edge for each centimetre between what casts and what receives it.
    pub softness: f32,
    pad: [f32; 3],
}

/// Widest half angle of a point light's map: a light inside the hair lights only what is before it.
const MAX_HALF_ANGLE: f32 = 1.1;

impl ShadowLight {
    /// Fit a map of `resolution` texels to the ball. The ball turns with the head into itself, and under parallel light it
    /// moves by whole texels: shadows do not swim.
    pub fn new(light: &SceneLight, casts: bool, ball: Ball, world_from_head: Affine3A, resolution: u32) -> Self {
        let centre = world_from_head.transform_point3(ball.centre);
        let size = resolution as f32;
        let place = Vec3::from_slice(&light.place[..3]);
        let casts = u32::from(casts);
        if light.place[3] == 0.0 {
            let forward = -place;
            let (right, up) = basis(forward);
            let texels_per_cm = size / (2.0 * ball.radius);
            let snap = |axis: Vec3| 0.5 * size - (centre.dot(axis) * texels_per_cm).round();
            let near_plane = ball.radius - centre.dot(forward);
            let rows = [
                (right * texels_per_cm).extend(snap(right)),
                (up * texels_per_cm).extend(snap(up)),
                forward.extend(near_plane),
                Vec4::W,
            ];
            return Self {
                map_from_world: from_rows(rows),
                place: light.place,
                texels_per_cm,
                casts,
                near: 0.0,
                far: 2.0 * ball.radius,
                softness: light.radius,
                pad: [0.0; 3],
            };
        }
        let towards = centre - place;
        let distance = towards.length().max(1e-3);
        let forward = towards / distance;
        let (right, up) = basis(forward);
        let half_angle = (ball.radius / distance).clamp(0.0, 1.0).asin().min(MAX_HALF_ANGLE);
        let texels_per_cm = 0.5 * size / half_angle.tan();
        let axis = forward.extend(-place.dot(forward));
        let rows = [
            (right * texels_per_cm).extend(-place.dot(right) * texels_per_cm) + 0.5 * size * axis,
            (up * texels_per_cm).extend(-place.dot(up) * texels_per_cm) + 0.5 * size * axis,
            axis,
            axis,
        ];
        let near = (distance - ball.radius).max(0.5);
        Self {
            map_from_world: from_rows(rows),
            place: light.place,
            texels_per_cm,
            casts,
            near,
            far: distance + ball.radius,
            softness: light.radius / distance,
            pad: [0.0; 3],
        }
    }

    /// (texel x, texel y, depth, w). Twin of `map_place`.
    pub fn map_place(&self, position: Vec3) -> Vec4 {
        let q = Mat4::from_cols_array(&self.map_from_world) * position.extend(1.0);
        Vec4::new(q.x / q.w, q.y / q.w, q.z, q.w)
    }
}

/// Two axes across `forward`, the same for equal directions.
fn basis(forward: Vec3) -> (Vec3, Vec3) {
    let up = if forward.y.abs() < 0.99 { Vec3::Y } else { Vec3::Z };
    let right = forward.cross(up).normalize();
    (right, right.cross(forward))
}

fn from_rows([x, y, z, w]: [Vec4; 4]) -> [f32; 16] {
    Mat4::from_cols(x, y, z, w).transpose().to_cols_array()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::SceneLights;
    use lorelei_core::light::{Light, LightKind};

    const BALL: Ball = Ball { centre: Vec3::new(1.0, 150.0, -2.0), radius: 20.0 };

    fn camera(kind: LightKind, world_from_head: Affine3A) -> ShadowLight {
        let light = Light { kind, ..Light::directional("key", 40.0, 30.0, 1.0, [1.0; 3]) };
        ShadowLight::new(&SceneLights::new(&[light]).lights[0], true, BALL, world_from_head, 512)
    }

    #[test]
    fn the_ball_fills_the_map_and_its_depths() {
        for kind in [
            LightKind::Directional { azimuth_deg: 40.0, elevation_deg: 30.0 },
            LightKind::Directional { azimuth_deg: 0.0, elevation_deg: 90.0 },
            LightKind::Point { position: Vec3::new(60.0, 200.0, 80.0) },
        ] {
            let light = camera(kind, Affine3A::IDENTITY);
            let (mut lo, mut hi) = (Vec3::MAX, Vec3::MIN);
            for i in 0..2000 {
                // A golden spiral over the ball.
                let z = 1.0 - 2.0 * (i as f32 + 0.5) / 2000.0;
                let (sin, cos) = (2.399_963 * i as f32).sin_cos();
                let r = (1.0 - z * z).sqrt();
                let place = light.map_place(BALL.centre + BALL.radius * Vec3::new(r * cos, r * sin, z));
                (lo, hi) = (lo.min(place.truncate()), hi.max(place.truncate()));
            }
            assert!(lo.x > -1.0 && lo.y > -1.0 && hi.x < 513.0 && hi.y < 513.0, "{kind:?}: {lo} {hi}");
            assert!(hi.x - lo.x > 500.0, "{kind:?}: {lo} {hi}");
            assert!(lo.z > light.near - 0.1 && hi.z < light.far + 0.1, "{kind:?}: {lo} {hi}");
        }
    }

    #[test]
    fn texels_stay_on_the_world_when_the_head_moves() {
        let kind = LightKind::Directional { azimuth_deg: 40.0, elevation_deg: 30.0 };
        let still = camera(kind, Affine3A::IDENTITY);
        let moved = camera(kind, Affine3A::from_translation(Vec3::new(0.33, 0.71, 0.05)));
        let p = Vec3::new(3.0, 148.0, 1.0);
        let shift = moved.map_place(p) - still.map_place(p);
        assert!((shift.x - shift.x.round()).abs() < 2e-3 && (shift.y - shift.y.round()).abs() < 2e-3, "{shift}");
    }
}
