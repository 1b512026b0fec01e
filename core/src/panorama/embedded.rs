//! The studio's own surroundings, made by formulas and not by photographs: nothing is stored, and nobody else's picture is in
//! it. Each has the same mean luminance, [`MEAN_LUMINANCE`], so that choosing another one changes where light comes from and
//! not the exposure.

use std::sync::{Arc, LazyLock};

use glam::Vec3;

use super::Panorama;
use crate::camera::direction_from_deg;
use crate::look::{Choice, Surroundings};

/// Mean luminance over the sphere: about that of the default look's constant environment.
pub const MEAN_LUMINANCE: f32 = 0.3;

/// Texels across: half a degree more than the smallest source, the low sun.
const WIDTH: u32 = 256;

/// The picture of a choice; `None` for the one that is loaded from a file. Made once.
pub fn embedded(choice: Surroundings) -> Option<Arc<Panorama>> {
    static MADE: LazyLock<Vec<Option<Arc<Panorama>>>> =
        LazyLock::new(|| Surroundings::ALL.iter().map(|&choice| Some(Arc::new(made(formula(choice)?)))).collect());
    let at = Surroundings::ALL.iter().position(|&other| other == choice)?;
    MADE[at].clone()
}

fn formula(choice: Surroundings) -> Option<fn(Vec3) -> Vec3> {
    match choice {
        Surroundings::Studio => Some(studio),
        Surroundings::Overcast => Some(overcast),
        Surroundings::Sunset => Some(sunset),
        Surroundings::Ring => Some(ring),
        Surroundings::File => None,
    }
}

fn made(radiance: fn(Vec3) -> Vec3) -> Panorama {
    let mut picture = Panorama::from_fn(WIDTH, WIDTH / 2, radiance);
    let scale = MEAN_LUMINANCE / picture.mean_luminance();
    for value in &mut picture.texels {
        *value *= scale;
    }
    picture
}

/// 0 below `from`, 1 above `to`, smooth between.
fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let x = ((x - from) / (to - from)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// A lit rectangle at an azimuth and elevation, so many degrees wide and high, with soft borders: 0-1.
fn panel(d: Vec3, [azimuth_deg, elevation_deg]: [f32; 2], [wide_deg, high_deg]: [f32; 2]) -> f32 {
    let axis = direction_from_deg(azimuth_deg, elevation_deg);
    let side = Vec3::Y.cross(axis).normalize_or(Vec3::X);
    let (x, y, z) = (d.dot(side), d.dot(axis.cross(side)), d.dot(axis));
    let inside = |angle: f32, size_deg: f32| 1.0 - smoothstep(0.42, 0.5, angle.to_degrees().abs() / size_deg);
    if z <= 0.0 { 0.0 } else { inside(x.atan2(z), wide_deg) * inside(y.atan2(z), high_deg) }
}

/// A dark room with a large soft box to the front, a weaker cool one on the other side, and two strips behind.
fn studio(d: Vec3) -> Vec3 {
    let room = Vec3::new(0.030, 0.028, 0.027) * (1.2 + 0.8 * d.y);
    room + 2.6 * panel(d, [45.0, 32.0], [56.0, 70.0]) * Vec3::new(1.0, 0.95, 0.88)
        + 0.7 * panel(d, [-62.0, 8.0], [50.0, 80.0]) * Vec3::new(0.86, 0.93, 1.0)
        + 4.0 * panel(d, [152.0, 24.0], [16.0, 80.0]) * Vec3::new(1.0, 0.98, 0.95)
        + 3.0 * panel(d, [-150.0, 30.0], [14.0, 70.0]) * Vec3::new(0.95, 0.97, 1.0)
}

/// The overcast sky of the CIE (Moon and Spencer 1942): three times as bright above as at the horizon; and the ground.
fn overcast(d: Vec3) -> Vec3 {
    let sky = Vec3::new(0.88, 0.95, 1.05) * ((1.0 + 2.0 * d.y.max(0.0)) / 3.0);
    // What arrives from above, 7/9 of the zenith's radiance, sent back by a fifth.
    let ground = Vec3::new(0.17, 0.155, 0.135);
    ground.lerp(sky, smoothstep(-0.03, 0.03, d.y))
}

/// A clear evening: the sun five degrees up behind the model's right shoulder, its glow, and the blue opposite.
fn sunset(d: Vec3) -> Vec3 {
    let sun = direction_from_deg(-118.0, 5.0);
    let off_deg = d.dot(sun).clamp(-1.0, 1.0).acos().to_degrees();
    let up = d.y.max(0.0);
    let towards_sun = 0.5 + 0.5 * d.dot(Vec3::new(sun.x, 0.0, sun.z).normalize());
    let horizon = Vec3::new(0.85, 0.42, 0.20).lerp(Vec3::new(0.42, 0.40, 0.50), 1.0 - towards_sun * towards_sun);
    let zenith = Vec3::new(0.10, 0.17, 0.38);
    let sky = horizon.lerp(zenith, 1.0 - (-4.0 * up).exp());
    let glow = Vec3::new(1.0, 0.55, 0.22) * (2.2 * (-off_deg / 14.0).exp());
    // Twice as wide as the sun is, and as much dimmer: its light is the same, and 256 texels hold it.
    let disc = Vec3::new(1.0, 0.60, 0.30) * (420.0 * (1.0 - smoothstep(1.2, 2.2, off_deg)));
    let ground = Vec3::new(0.075, 0.055, 0.045);
    ground.lerp(sky + glow + disc, smoothstep(-0.03, 0.03, d.y))
}

/// A ring of light around the camera in front, two coloured strips behind, and else the dark.
fn ring(d: Vec3) -> Vec3 {
    let off_deg = d.dot(direction_from_deg(0.0, 5.0)).clamp(-1.0, 1.0).acos().to_degrees();
    let around = smoothstep(15.0, 18.0, off_deg) * (1.0 - smoothstep(27.0, 30.0, off_deg));
    Vec3::splat(0.02)
        + 3.0 * around * Vec3::new(1.0, 0.99, 0.97)
        + 2.2 * panel(d, [125.0, 15.0], [24.0, 100.0]) * Vec3::new(0.30, 0.55, 1.0)
        + 2.2 * panel(d, [-125.0, 15.0], [24.0, 100.0]) * Vec3::new(1.0, 0.35, 0.55)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_embedded_picture_is_light_of_the_same_mean_and_no_two_are_alike() {
        let mut seen: Vec<Arc<Panorama>> = Vec::new();
        for &choice in Surroundings::ALL {
            let Some(picture) = embedded(choice) else {
                assert_eq!(choice, Surroundings::File);
                continue;
            };
            assert!(picture.texels.iter().all(|v| v.is_finite() && *v >= 0.0), "{choice:?}");
            assert!((picture.mean_luminance() / MEAN_LUMINANCE - 1.0).abs() < 1e-4, "{choice:?}");
            assert!(seen.iter().all(|other| other.texels != picture.texels), "{choice:?}");
            seen.push(picture);
        }
        assert_eq!(seen.len(), 4);
    }

    #[test]
    fn light_is_where_the_descriptions_say() {
        let bright = |choice, azimuth: f32, elevation: f32| {
            embedded(choice).unwrap().radiance(direction_from_deg(azimuth, elevation)).x
        };
        assert!(bright(Surroundings::Studio, 45.0, 32.0) > 20.0 * bright(Surroundings::Studio, 0.0, -60.0));
        assert!(
            (bright(Surroundings::Overcast, 0.0, 89.0) / bright(Surroundings::Overcast, 0.0, 2.5) - 2.8).abs() < 0.2
        );
        assert!(bright(Surroundings::Sunset, -118.0, 5.0) > 50.0 * bright(Surroundings::Sunset, 62.0, 5.0));
        assert!(bright(Surroundings::Ring, 22.0, 5.0) > 20.0 * bright(Surroundings::Ring, 0.0, 5.0));
    }
}
