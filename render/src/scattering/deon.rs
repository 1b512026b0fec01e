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
//! M and N each keep energy, and their product does not: a wide lobe reaches other theta_d than a narrow one, where its share
//! of the light is another. Taken as printed, 7 to 19 % are lost for an eye at 75 degrees. [`balance`] gives that light back
//! by a factor that depends on theta_d alone, so that light and eye may still be exchanged: flat scales then show a white
//! furnace to four digits from all inclinations, tilted ones from the brighter end of the fibre. Shares taken at the eye's own
//! inclination, as Chiang has them, keep energy too and were rejected: then they may not.
//!
//! Twin of `shaders/wgsl/scatter_deon.wgsl`.

use std::f32::consts::PI;

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
    Blur::Gaussian { deviation: PI / 3f32.sqrt() * logistic_scale(beta_n) }
}

/// Places of theta_i that a lobe is summed over, and its deviations that they reach.
const N_THETA: usize = 96;
const REACH: f32 = 6.0;
/// Steps of the iteration, and the largest factor: at grazing angles more than a lobe's width is cut off.
const N_STEPS: usize = 80;
const MOST: f32 = 3.0;

/// Multiply the lobes with the factor of theta_d for which a fibre without absorption shows a white furnace as it is, from
/// every inclination: found by dividing by what it shows, over and over.
pub fn balance(tables: &mut [Table], beta: [f32; 3], alpha: [f32; 3]) {
    let height = tables[0].height;
    let row_of = |cos_theta: f32| cos_theta.clamp(0.0, 1.0).acos() / (0.5 * PI) * (height - 1) as f32;
    let power: Vec<Vec<f32>> = tables.iter().map(powers).collect();
    // What a factor of one row adds to what an eye at another sees, from either end of the fibre.
    let mut reached = [1.0, -1.0].map(|_| vec![0.0f32; height * height]);
    for eye_row in 0..height {
        for (reached, side) in reached.iter_mut().zip([1.0, -1.0]) {
            let to = &mut reached[eye_row * height..][..height];
            let theta_r = side * 0.5 * PI * eye_row as f32 / (height - 1) as f32;
            for (p, power) in power.iter().enumerate() {
                let beta = beta[p.min(2)];
                let shift = if p < 3 { 2.0 * alpha[p] } else { 0.0 };
                let (middle, reach) = (shift - theta_r, REACH * 2.0 * beta);
                let (from, end) = ((middle - reach).max(-0.5 * PI), (middle + reach).min(0.5 * PI));
                let step = (end - from) / N_THETA as f32;
                let weight_at = |k: usize| {
                    let theta_i = from + (k as f32 + 0.5) * step;
                    let (sin_r, cos_r) = theta_r.sin_cos();
                    let m = longitudinal(4.0 * beta * beta, theta_i.sin_cos(), tilted(sin_r, cos_r, shift));
                    (m * theta_i.cos(), (0.5 * (theta_r - theta_i + shift)).cos())
                };
                // M integrates to 1; what the sum misses of it is the sum's.
                let total: f32 = (0..N_THETA).map(|k| weight_at(k).0).sum();
                for (weight, cos_theta_d) in (0..N_THETA).map(weight_at) {
                    let row = row_of(cos_theta_d);
                    let low = (row as usize).min(height - 2);
                    let share = weight / total.max(1e-12);
                    to[low] += share * (low as f32 + 1.0 - row) * power[low];
                    to[low + 1] += share * (row - low as f32) * power[low + 1];
                }
            }
        }
    }
    let mut factors = vec![1.0f32; height];
    for _ in 0..N_STEPS {
        let shown = |from: usize, row: usize| -> f32 {
            let to = &reached[from][row * height..][..height];
            to.iter().zip(&factors).map(|(share, factor)| share * factor).sum()
        };
        // With tilted scales the ends of a fibre differ: the brighter one is white, and no light is made.
        let shown: Vec<f32> = (0..height).map(|row| shown(0, row).max(shown(1, row))).collect();
        for (factor, shown) in factors.iter_mut().zip(shown) {
            // The root: full steps swing where lobes are wide.
            *factor = (*factor / shown.max(1e-3).sqrt()).min(MOST);
        }
    }
    for table in tables {
        for (row, factor) in table.texels.chunks_mut(table.width).zip(&factors) {
            for texel in row {
                texel[0] *= factor;
            }
        }
    }
}

/// Of each row, the share of the light that the lobe sends on: N over the circle.
fn powers(table: &Table) -> Vec<f32> {
    let row_power = |row: &[[f32; 4]]| {
        let ends = 0.5 * (row[0][0] + row[table.width - 1][0]);
        let inner: f32 = row[1..table.width - 1].iter().map(|texel| texel[0]).sum();
        2.0 * PI / (table.width - 1) as f32 * (ends + inner)
    };
    table.texels.chunks(table.width).map(row_power).collect()
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

    #[test]
    fn a_white_furnace_stays_white_within_one_percent_where_scales_are_flat_and_no_light_is_made_where_not() {
        // With tilted scales one end of a fibre is white and the other loses, the more the flatter the eye.
        for (tilt_deg, most_lost) in [(0.0, 0.01), (3.0, 0.1)] {
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
                    assert!(l < 1.01 && l > 1.0 - most_lost, "{place}");
                    assert!(theta_r.abs() > 45.0 || l > 0.985, "{place}");
                    // What the fibre's side shows to the eye, and the sphere's share.
                    let share = theta_r.to_radians().cos().powi(2);
                    (mean, weight) = (mean + share * l, weight + share);
                }
                println!("mean {:.4}", mean / weight);
                assert!((mean / weight - 1.0).abs() < 0.015, "tilt {tilt_deg}, beta_m {beta_m_deg}");
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
