//! What the tests of scattering models share: places to ask them at, and the furnace.

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Choice, Look, Scattering};

use super::parity::on_cpu;
use super::table::Table;
use super::tables::{Baked, Recipe};
use super::{Directions, Fibre};

/// A fibre of the default material, changed, with the tables of a model.
pub fn fibre_and_tables(scattering: Scattering, change: impl FnOnce(&mut HairMaterial)) -> (Fibre, Vec<Table>) {
    let mut material = HairMaterial::default();
    change(&mut material);
    let look = Look { scattering, ..Look::default() };
    (Fibre::new(&material, &look), Baked::new(&Recipe::of(&material, &look)).azimuthal)
}

/// Take the pigment out.
pub fn white(material: &mut HairMaterial) {
    (material.eumelanin, material.pheomelanin) = (0.0, 0.0);
}

/// Light at inclination `theta_i`, eye at `theta_r`, `phi` between them, degrees.
pub fn at(theta_i: f32, theta_r: f32, phi: f32) -> Directions {
    let direction = |theta: f32, phi: f32| {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        Vec3::new(theta.sin(), theta.cos() * phi.cos(), theta.cos() * phi.sin())
    };
    Directions::new(Vec3::X, direction(theta_i, phi), direction(theta_r, 0.0))
}

/// Directions all over both spheres, grazing ones among them.
pub fn each_direction(mut check: impl FnMut(&Directions)) {
    for theta_i in (-89..=89).step_by(8) {
        for theta_r in (-89..=89).step_by(7) {
            for phi in (0..=360).step_by(15) {
                check(&at(theta_i as f32, theta_r as f32, phi as f32));
            }
        }
    }
}

/// Radiance under a constant environment of radiance 1, for an eye at `theta_r` degrees and an offset.
pub fn furnace(theta_r: f32, beta_m_deg: f32, h: f32, scatter: impl Fn(&Directions) -> Vec3) -> Vec3 {
    // A tenth of TT's deviation.
    let n_theta = (180.0 / (0.1 * beta_m_deg).min(0.5)) as usize;
    let n_phi = 180;
    let mut total = Vec3::ZERO;
    for i in 0..n_theta {
        let theta_i = -90.0 + 180.0 * (i as f32 + 0.5) / n_theta as f32;
        let mut ring = Vec3::ZERO;
        for j in 0..n_phi {
            ring += scatter(&Directions { h, ..at(theta_i, theta_r, 360.0 * (j as f32 + 0.5) / n_phi as f32) });
        }
        let solid_angle =
            theta_i.to_radians().cos() * std::f32::consts::PI / n_theta as f32 * std::f32::consts::TAU / n_phi as f32;
        total += ring * solid_angle;
    }
    total
}

#[test]
fn every_model_is_smooth_in_every_parameter() {
    type Parameter = (&'static str, [f32; 3], f32, fn(&mut HairMaterial, f32));
    // Name, values, a small step, and how it is set.
    let parameters: [Parameter; 6] = [
        ("beta_m", [2.0, 7.5, 39.9], 0.02, |m, v| m.beta_m_deg = v),
        ("tilt", [-10.0, 0.0, 9.0], 0.01, |m, v| m.tilt_deg = v),
        ("eumelanin", [0.0, 0.3, 9.9], 0.005, |m, v| m.eumelanin = v),
        ("index", [1.15, 1.5, 2.15], 0.002, |m, v| m.index_of_refraction = v),
        ("beta_n", [0.05, 0.3, 0.95], 0.001, |m, v| m.beta_n = v),
        ("pheomelanin", [0.0, 0.3, 9.9], 0.005, |m, v| m.pheomelanin = v),
    ];
    let places =
        [(0.0, 3.0, 10.0), (30.0, -28.0, 70.0), (-50.0, 45.0, 178.0), (70.0, -20.0, 120.0), (20.0, -24.0, 40.0)];
    for &scattering in Scattering::ALL {
        let look = Look { scattering, ..Look::default() };
        for (name, values, step, set) in parameters {
            for value in values {
                let at_value = |value: f32| {
                    let mut material = HairMaterial::default();
                    set(&mut material, value);
                    let (fibre, baked) = (Fibre::new(&material, &look), Baked::new(&Recipe::of(&material, &look)));
                    places.map(|(theta_i, theta_r, phi)| on_cpu(scattering, &baked, &fibre, &at(theta_i, theta_r, phi)))
                };
                for (place, (here, there)) in places.iter().zip(at_value(value).into_iter().zip(at_value(value + step)))
                {
                    let case = format!("{scattering:?}, {name} {value} at {place:?}: {here} {there}");
                    assert!(here.is_finite() && here.min_element() >= 0.0, "{case}");
                    // 1e-3: a hundredth of what a card of 30 % shows.
                    assert!((here - there).abs().max_element() < 0.05 * here.max_element() + 1e-3, "{case}");
                }
            }
        }
    }
}
