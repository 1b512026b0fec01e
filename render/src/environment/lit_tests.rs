//! Environments from pictures against integrals over all directions, turned grooms, and where light gets in.

use glam::{DVec3, Quat};
use lorelei_core::camera::direction_from_deg;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Look, Scattering, Surroundings};
use lorelei_core::panorama::embedded::embedded;
use lorelei_core::panorama::{Panorama, direction_of};

use super::*;
use crate::environment::{Harmonics, lights_of};
use crate::scattering::table::Table;
use crate::scattering::tables::{Baked, Recipe};
use crate::scattering::{chiang, deon, kajiya_kay, marschner};

const MODELS: [Scattering; 4] = [Scattering::Marschner, Scattering::KajiyaKay, Scattering::Deon, Scattering::Chiang];

fn fibre_of(scattering: Scattering, beta_m_deg: f32) -> (Fibre, Vec<Table>) {
    let look = Look { scattering, ..Look::default() };
    let material = HairMaterial { eumelanin: 0.3, beta_m_deg, ..HairMaterial::default() };
    (Fibre::new(&material, &look), Baked::new(&Recipe::of(&material, &look)).azimuthal)
}

fn scatter(scattering: Scattering, fibre: &Fibre, tables: &[Table], d: &Directions) -> Vec3 {
    match scattering {
        Scattering::KajiyaKay => kajiya_kay::scatter(fibre, d),
        Scattering::Deon => deon::scatter(fibre, tables, d),
        Scattering::Chiang => chiang::scatter(fibre, tables, d),
        _ => marschner::scatter(fibre, d),
    }
}

/// Tangents and directions to the eye.
fn frames() -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..12).map(|k| {
        let k = k as f32;
        (direction_from_deg(95.0 * k, 70.0 - 13.0 * k), direction_from_deg(31.0 * k - 60.0, 24.0 - 5.0 * k))
    })
}

/// The mean of `seen` over all directions, weighted with what the fibre scatters, in f64.
fn by_all_directions(
    tangent: Vec3,
    to_eye: Vec3,
    scatter: impl Fn(&Directions) -> Vec3,
    seen: impl Fn(Vec3) -> Vec3,
) -> Vec3 {
    let (mut scattered, mut lit) = (DVec3::ZERO, DVec3::ZERO);
    let n = 256;
    for row in 0..n / 2 {
        for column in 0..n {
            let d = direction_of([(column as f32 + 0.5) / n as f32, (row as f32 + 0.5) / (n / 2) as f32]);
            let solid_angle = f64::from((1.0 - d.y * d.y).max(0.0).sqrt());
            let f = scatter(&Directions::new(tangent, d, to_eye)).as_dvec3() * solid_angle;
            scattered += f;
            lit += f * seen(d).as_dvec3();
        }
    }
    (lit / scattered).as_vec3()
}

#[test]
fn turning_the_environment_is_turning_the_hair_and_the_eye_the_other_way() {
    let (fibre, tables) = fibre_of(Scattering::Marschner, 7.5);
    let studio = Harmonics::of(&embedded(Surroundings::Studio).unwrap());
    let look = |rotation_deg: f32| {
        let mut look = Look::default();
        look.environment_picture.rotation_deg = rotation_deg;
        look
    };
    let heap = crate::scattering::volume::volume(&fibre);
    for (tangent, to_eye) in frames() {
        let shown = |(tangent, to_eye): (Vec3, Vec3), rotation_deg: f32| {
            let lights = lights_of(&studio, &look(rotation_deg));
            let scatter = |d: &Directions| scatter(Scattering::Marschner, &fibre, &tables, d);
            harmonics(&fibre, &heap, (tangent, to_eye), &Open::WIDE, &lights, scatter)
        };
        let back = Quat::from_rotation_y(-50f32.to_radians());
        let (a, b) = (shown((tangent, to_eye), 50.0), shown((back * tangent, back * to_eye), 0.0));
        assert!((a - b).abs().max_element() < 1e-3 * b.max_element(), "{a} {b}");
    }
}

/// The fan of 156 directions against 32,768 of them, both of the same harmonics; and the harmonics against the picture itself.
#[test]
fn the_fan_agrees_with_an_integral_over_all_directions() {
    for picture in [Surroundings::Studio, Surroundings::Sunset] {
        let texels = embedded(picture).unwrap();
        let lights = lights_of(&Harmonics::of(&texels), &Look::default());
        for scattering in MODELS {
            for beta_m_deg in [5.0, 10.0] {
                let (fibre, tables) = fibre_of(scattering, beta_m_deg);
                let scatter = |d: &Directions| scatter(scattering, &fibre, &tables, d);
                let (mut fan, mut bands, mut most) = (Vec::new(), Vec::new(), 0f32);
                for (tangent, to_eye) in frames() {
                    let seen = |d: Vec3| radiance(&lights.radiance, d);
                    let diffuse = irradiance(&lights.irradiance, facing(tangent, to_eye));
                    let quick = single(&fibre, tangent, to_eye, scatter, seen, diffuse);
                    let exact = by_all_directions(tangent, to_eye, scatter, seen);
                    let pictured = by_all_directions(tangent, to_eye, scatter, |d| texels.radiance(d));
                    fan.push((quick - exact).abs().max_element());
                    bands.push((quick - pictured).abs().max_element());
                    most = most.max(exact.max_element());
                }
                let mean = |errors: &[f32]| errors.iter().sum::<f32>() / errors.len() as f32 / most;
                let worst = |errors: &[f32]| errors.iter().copied().fold(0.0, f32::max) / most;
                println!(
                    "{picture:?} {scattering:?} {beta_m_deg}: fan mean {:.3} worst {:.3}; four bands mean {:.3} worst {:.3}",
                    mean(&fan),
                    worst(&fan),
                    mean(&bands),
                    worst(&bands)
                );
                assert!(mean(&fan) < 0.015 && worst(&fan) < 0.04, "{picture:?} {scattering:?}");
                // A sun is as wide as four bands make it: 37 % on average, three times the most at worst.
                assert!(mean(&bands) < 0.15 || picture == Surroundings::Sunset, "{picture:?} {scattering:?}");
            }
        }
    }
}

#[test]
fn light_comes_from_where_it_is_open() {
    let (fibre, tables) = fibre_of(Scattering::Marschner, 7.5);
    let heap = crate::scattering::volume::volume(&fibre);
    // Light from behind only.
    let behind = Panorama::from_fn(64, 32, |d| Vec3::splat((-d.z).max(0.0)));
    let lights = lights_of(&Harmonics::of(&behind), &Look::default());
    let shown = |towards: Vec3| {
        let scatter = |d: &Directions| scatter(Scattering::Marschner, &fibre, &tables, d);
        harmonics(&fibre, &heap, (Vec3::X, Vec3::Z), &Open { share: Vec3::ONE, towards }, &lights, scatter).x
    };
    assert!(shown(Vec3::Z) < 0.4 * shown(Vec3::ZERO) && shown(Vec3::NEG_Z) > shown(Vec3::ZERO));
}
