//! d'Eon, Francois, Hill, Letteri and Aubry 2011: a rough cylinder that keeps energy, far field.
//!
//! M is [`super::longitudinal`], N the average over the width blurred by a wrapped Gaussian, from the tables of
//! [`super::azimuthal`], taken at theta_d. What crosses three times or more (their TRRT, and all beyond) is the fourth lobe.
//!
//! Read so that it compares with the others: v = (2 beta_p)^2 with Marschner's beta_R, beta_TT, beta_TRT, since beta is
//! a deviation of theta_h; tilts are Marschner's; the Gaussian's deviation is that of Chiang's logistic distribution, pi / sqrt(3)
//! of its scale, so that the same azimuthal roughness looks alike; theta_d is taken with the tilt off, so that all lobes share
//! the light of one angle (otherwise tilted scales make 7 % of light at 75 degrees). The value is M N, d'Eon's S times cos(theta_i); without
//! tilt it is the same with light and eye exchanged.
//!
//! Twin of `shaders/wgsl/scatter_deon.wgsl`.

use glam::Vec3;

use super::Directions;
use super::azimuthal::{Blur, N_LOBES, azimuthal};
use super::chiang::weight;
use super::cylinder::logistic_scale;
use super::fibre::Fibre;
use super::longitudinal::{longitudinal, tilted};
use super::table::Table;

/// The Gaussian that stands for an azimuthal roughness 0-1.
pub fn blur(beta_n: f32) -> Blur {
    Blur::Gaussian { deviation: std::f32::consts::PI / 3f32.sqrt() * logistic_scale(beta_n) }
}

/// L / E of one fibre.
pub fn scatter(fibre: &Fibre, tables: &[Table], d: &Directions) -> Vec3 {
    (0..N_LOBES)
        .map(|p| {
            let shift = if p < 3 { 2.0 * fibre.alpha[p] } else { 0.0 };
            let n = azimuthal(&tables[p], Vec3::from_array(fibre.sigma_a), d.cos_phi, cos_untilted(d, shift));
            weight(fibre, p) * lobe_m(fibre, d, p, shift) * n
        })
        .sum()
}

/// Cosine of theta_d with a lobe's shift of theta_i + theta_r taken off the light's inclination.
fn cos_untilted(d: &Directions, shift: f32) -> f32 {
    let sin_theta_d = 0.5 * (d.sin_theta_r * d.cos_theta_i - d.cos_theta_r * d.sin_theta_i) / d.cos_theta_d;
    let (s, c) = (0.5 * shift).sin_cos();
    (d.cos_theta_d * c - sin_theta_d * s).max(0.0)
}

fn lobe_m(fibre: &Fibre, d: &Directions, p: usize, shift: f32) -> f32 {
    let beta = fibre.beta[p.min(2)];
    longitudinal(4.0 * beta * beta, (d.sin_theta_i, d.cos_theta_i), tilted(d.sin_theta_r, d.cos_theta_r, shift))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::NO_OFFSET;
    use crate::scattering::laws::{self, at};
    use lorelei_core::look::Scattering;

    /// Lobes reach different theta_d, where the shares of the light are others, the more so the rougher the fibre and the
    /// flatter the eye: the model's own error. It loses light there and makes none.
    #[test]
    fn a_white_furnace_stays_white_within_one_percent_up_to_45_degrees_and_over_the_sphere() {
        for (tilt_deg, tolerance) in [(0.0, 0.01), (3.0, 0.015)] {
            for (beta_m_deg, beta_n) in [(3.0, 0.1), (7.5, 0.3), (12.0, 0.6)] {
                let (fibre, tables) = laws::fibre_and_tables(Scattering::Deon, |m| {
                    laws::white(m);
                    (m.beta_m_deg, m.beta_n, m.tilt_deg) = (beta_m_deg, beta_n, tilt_deg);
                });
                let (mut mean, mut weight) = (0.0, 0.0);
                for theta_r in [-75.0f32, -45.0, -15.0, 15.0, 45.0, 75.0] {
                    let l = laws::furnace(theta_r, beta_m_deg, NO_OFFSET, |d| scatter(&fibre, &tables, d)).x;
                    let place =
                        format!("tilt {tilt_deg}, beta_m {beta_m_deg}, beta_n {beta_n}, theta {theta_r}: {l:.4}");
                    println!("{place}");
                    assert!(l < 1.0 + tolerance, "{place}");
                    assert!(theta_r.abs() > 45.0 || (l - 1.0).abs() < tolerance, "{place}");
                    // What the fibre's side shows to the eye, and the sphere's share.
                    let share = theta_r.to_radians().cos().powi(2);
                    (mean, weight) = (mean + share * l, weight + share);
                }
                println!("mean {:.4}", mean / weight);
                assert!((mean / weight - 1.0).abs() < 0.01, "tilt {tilt_deg}, beta_m {beta_m_deg}");
            }
        }
    }

    #[test]
    fn light_and_eye_may_be_exchanged_where_scales_are_flat() {
        let (fibre, tables) = laws::fibre_and_tables(Scattering::Deon, |m| m.tilt_deg = 0.0);
        for (theta_i, theta_r, phi) in [(10.0, -25.0, 40.0), (60.0, -50.0, 170.0), (-30.0, 34.0, 5.0)] {
            let ab = scatter(&fibre, &tables, &at(theta_i, theta_r, phi));
            let ba = scatter(&fibre, &tables, &at(theta_r, theta_i, phi));
            assert!((ab - ba).abs().max_element() < 1e-4 * ab.max_element(), "{ab} {ba}");
        }
    }

    #[test]
    fn nothing_is_negative_or_infinite() {
        for beta_m_deg in [1.0, 7.5, 40.0] {
            let (fibre, tables) = laws::fibre_and_tables(Scattering::Deon, |m| m.beta_m_deg = beta_m_deg);
            laws::each_direction(|d| {
                let l = scatter(&fibre, &tables, d);
                assert!(l.is_finite() && l.min_element() >= 0.0, "{d:?}: {l}");
            });
        }
    }
}
