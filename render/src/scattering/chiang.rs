//! Chiang, Bitterli, Tappan and Burley 2016, as in pbrt-v4's `HairBxDF`: energy-conserving M, logistic blur around the
//! fibre, what crosses three times or more in one wide lobe.
//!
//! - Near field, where the caller knows the offset h: closed form, no table.
//! - Far field: the same averaged over h, from the tables of [`super::azimuthal`].
//!
//! Departures from pbrt, none of which changes the model: roughness along the fibre is the material's deviation of R in
//! theta_h, so that v = (2 beta)^2 (Chiang's own beta_m of 0.3 is 8.33 degrees here); scales tilt as everywhere here,
//! positive towards the root. The value is M N: pbrt's f times |cos(theta_i)|. So under a constant environment it shows
//! the environment whatever the eye's inclination, and it is not exactly reciprocal, as pbrt is not: inclinations of the eye
//! decide about A.
//!
//! Twin of `shaders/wgsl/scatter_chiang.wgsl`.

use glam::Vec3;

use super::azimuthal::{N_LOBES, azimuthal};
use super::cylinder::{Section, attenuation, trimmed_logistic, wrapped};
use super::fibre::Fibre;
use super::longitudinal::{longitudinal, tilted};
use super::table::Table;
use super::{Directions, NO_OFFSET};

/// L / E of one fibre.
pub fn scatter(fibre: &Fibre, tables: &[Table], d: &Directions) -> Vec3 {
    let n = if d.h < NO_OFFSET { near(fibre, d) } else { far(fibre, tables, d) };
    (0..N_LOBES).map(|p| weight(fibre, p) * lobe_m(fibre, d, p) * n[p]).sum()
}

/// Weight of R, TT, TRT and the rest.
pub fn weight(fibre: &Fibre, p: usize) -> f32 {
    if p < 3 { fibre.weight[p] } else { fibre.weight_rest }
}

/// M_p: variances v, v/4, 4v, 4v and tilts 2, -1, -4, 0 times the scales' (pbrt-v4).
fn lobe_m(fibre: &Fibre, d: &Directions, p: usize) -> f32 {
    let beta = fibre.beta[p.min(2)];
    let shift = [2.0, -1.0, -4.0, 0.0][p] * fibre.alpha[0];
    longitudinal(4.0 * beta * beta, (d.sin_theta_i, d.cos_theta_i), tilted(d.sin_theta_r, d.cos_theta_r, shift))
}

/// A_p N_p of each lobe at the offset.
fn near(fibre: &Fibre, d: &Directions) -> [Vec3; N_LOBES] {
    let h = d.h.clamp(-1.0, 1.0);
    let section = Section::new(fibre.eta, d.cos_theta_r);
    let f = section.fresnel(h);
    let t = (Vec3::from_array(fibre.sigma_a) * -section.chord(h)).exp();
    let phi = d.sin_phi.atan2(d.cos_phi);
    let around = |p: f32| trimmed_logistic(wrapped(phi - section.exit_azimuth(p, h)), fibre.logistic);
    let rest = (1.0 - f) * (1.0 - f) * f * f * t * t * t / (Vec3::ONE - f * t).max(Vec3::splat(1e-6));
    [
        Vec3::splat(attenuation(0, f) * around(0.0)),
        attenuation(1, f) * around(1.0) * t,
        attenuation(2, f) * around(2.0) * t * t,
        rest / std::f32::consts::TAU,
    ]
}

fn far(fibre: &Fibre, tables: &[Table], d: &Directions) -> [Vec3; N_LOBES] {
    std::array::from_fn(|p| azimuthal(&tables[p], Vec3::from_array(fibre.sigma_a), d.cos_phi, d.cos_theta_r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::laws::{self, at};
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::{Look, Scattering};

    fn with(change: impl FnOnce(&mut HairMaterial)) -> (Fibre, Vec<Table>) {
        laws::fibre_and_tables(Scattering::Chiang, change)
    }

    #[test]
    fn a_white_furnace_stays_white_within_one_percent_at_every_roughness_and_angle() {
        for (beta_m_deg, beta_n) in [(3.0, 0.1), (7.5, 0.3), (15.0, 0.6), (30.0, 0.9)] {
            let (fibre, tables) = with(|m| {
                laws::white(m);
                (m.beta_m_deg, m.beta_n) = (beta_m_deg, beta_n);
            });
            for theta_r in [0.0f32, 30.0, -60.0, 80.0, 88.0] {
                let far = laws::furnace(theta_r, beta_m_deg, NO_OFFSET, |d| scatter(&fibre, &tables, d)).x;
                assert!((far - 1.0).abs() < 0.01, "beta_m {beta_m_deg}, beta_n {beta_n}, theta {theta_r}: {far}");
            }
            for h in [-0.95, -0.4, 0.0, 0.7] {
                let near = laws::furnace(30.0, beta_m_deg, h, |d| scatter(&fibre, &tables, d)).x;
                assert!((near - 1.0).abs() < 0.01, "beta_m {beta_m_deg}, beta_n {beta_n}, h {h}: {near}");
            }
        }
    }

    #[test]
    fn pigment_only_takes_away_and_nothing_is_negative() {
        let (white, tables) = with(laws::white);
        let dark = Fibre::new(&HairMaterial { eumelanin: 0.8, ..HairMaterial::default() }, &Look::default());
        laws::each_direction(|d| {
            for h in [-0.8, 0.3, NO_OFFSET] {
                let d = Directions { h, ..*d };
                let (light, dark) = (scatter(&white, &tables, &d), scatter(&dark, &tables, &d));
                assert!(dark.is_finite() && dark.min_element() >= 0.0, "{d:?}: {dark}");
                assert!(dark.cmple(light + 1e-5).all(), "{d:?}: {dark} {light}");
            }
        });
    }

    #[test]
    fn the_average_of_the_near_field_is_the_far_field() {
        let (fibre, tables) = with(|m| (m.eumelanin, m.pheomelanin) = (0.3, 0.1));
        for (theta_i, theta_r, phi) in
            [(10.0, -12.0, 20.0), (-40.0, 30.0, 175.0), (5.0, 0.0, 90.0), (60.0, -65.0, 140.0)]
        {
            let d = at(theta_i, theta_r, phi);
            let n = 4000;
            let mean: Vec3 = (0..n)
                .map(|i| scatter(&fibre, &tables, &Directions { h: 2.0 * (i as f32 + 0.5) / n as f32 - 1.0, ..d }))
                .sum::<Vec3>()
                / n as f32;
            let far = scatter(&fibre, &tables, &d);
            assert!((mean / far - 1.0).abs().max_element() < 0.01, "{theta_i} {theta_r} {phi}: {mean} {far}");
        }
    }

    #[test]
    fn the_near_field_is_brightest_where_the_light_is() {
        // Light from the right of a strand that runs up: R is seen on its right half.
        let (fibre, tables) = with(|m| m.eumelanin = 8.0);
        let d = Directions::new(Vec3::Y, Vec3::new(0.9, 0.0, 0.43).normalize(), Vec3::Z);
        let l = |h: f32| scatter(&fibre, &tables, &Directions { h, ..d }).x;
        assert!(l(0.55) > 4.0 * l(-0.55), "{} {}", l(0.55), l(-0.55));
    }
}
