//! What the tests of scattering models share: places to ask them at, and the furnace.

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Look, Scattering};

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
