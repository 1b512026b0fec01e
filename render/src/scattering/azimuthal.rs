//! Azimuthal scattering of a rough cylinder, averaged over its width, in a table:
//!
//! ```text
//! N_p(theta, phi) = 1/2 int_-1^1 A(p, h) D(phi - Phi(p, h)) exp(-sigma_a l(p, h)) dh
//! ```
//!
//! (d'Eon et al. 2011, eq. 10; Chiang et al. 2016 averaged over h). Absorption is not in the table. A texel holds the
//! integral without it, and mean, deviation and skewness of the path lengths l that arrive there; the light is then taken to
//! have gone one of two lengths, those of the Gaussian quadrature with these moments. So one table serves every colour, every
//! strand's own pigment and dyes. A table with the colour inside was rejected for that reason (the choice
//! `marschner-2003-nalu` has one, as the demo had).
//!
//! The integral over h is cut into panels. What a panel sends to a texel is the integral of D over the azimuths that the
//! panel reaches, at least a texel wide, from a table of D's own integral: nothing is missed however narrow D is, and there
//! is one lookup instead of an exponential. Gauss-Legendre quadrature, which d'Eon uses, needs ten times as many points at
//! the lowest roughness; the tests hold this against it.

use std::f32::consts::PI;

use glam::Vec3;

use super::cylinder::{Section, attenuation, attenuation_from};
use super::table::Table;

/// Azimuths 0 to pi.
pub const WIDTH: usize = 256;
/// Inclinations 0 to pi/2.
pub const HEIGHT: usize = 64;
/// R, TT, TRT, and all that crosses more often.
pub const N_LOBES: usize = 4;

/// Panels of h.
const N_PANELS: usize = 128;
/// Crossings from which on light is spread together: Chiang's rest is even anyway, d'Eon's is faint.
fn last_p(blur: Blur) -> u32 {
    match blur {
        Blur::Logistic { .. } => 3,
        Blur::Gaussian { .. } => 5,
    }
}

/// Crossings beyond the last that are told apart by their length. More are worse: the two lengths then stand for a tail that no
/// absorption lets through. With 6, what goes on beyond TRT is within 0.5 % up to 80 degrees and an absorption of 0.15.
const N_BEYOND: u32 = 6;

/// How a rough surface spreads light around the fibre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blur {
    /// Chiang et al. 2016, scale s; what crosses more than twice is spread evenly.
    Logistic { s: f32 },
    /// d'Eon et al. 2011: a wrapped Gaussian of this deviation (radians), for all paths.
    Gaussian { deviation: f32 },
}

impl Blur {
    /// D at an angle.
    pub fn density(self, angle: f32) -> f32 {
        let x = super::cylinder::wrapped(angle);
        match self {
            Self::Logistic { s } => super::cylinder::trimmed_logistic(x, s),
            Self::Gaussian { deviation } => (-3..=3)
                .map(|k| {
                    let q = (x + 2.0 * PI * k as f32) / deviation;
                    (-0.5 * q * q).exp() / (deviation * (2.0 * PI).sqrt())
                })
                .sum(),
        }
    }
}

/// Steps of D's integral for one texel of azimuth.
const STEPS_PER_TEXEL: usize = 8;
const N_HALF: usize = (WIDTH - 1) * STEPS_PER_TEXEL;

/// The integral of D from -pi, going on periodically from -3 pi to 3 pi, in steps of pi / N_HALF.
struct Cumulative(Vec<f32>);

impl Cumulative {
    fn new(blur: Blur) -> Self {
        let n = 2 * N_HALF;
        let step = PI / N_HALF as f64 as f32;
        let mut sums = vec![0.0f64; n + 1];
        for i in 0..n {
            // Simpson's rule within the step: D may be as narrow as three steps.
            let at = |share: f32| f64::from(blur.density((i as f32 + share) * step - PI));
            sums[i + 1] = sums[i] + (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0;
        }
        let total = sums[n];
        Self((0..3).flat_map(|turn| sums[..n].iter().map(move |sum| (sum / total + f64::from(turn)) as f32)).collect())
    }

    /// The place of an angle within -3 pi to 3 pi: index and share of the next.
    fn place(angle: f32) -> (usize, f32) {
        let x = ((angle + 3.0 * PI) * (N_HALF as f32 / PI)).clamp(0.0, (6 * N_HALF - 2) as f32);
        (x as usize, x.fract())
    }
}

/// Sums of weight times the powers 0 to 3 of length.
pub(super) type Moments = [f32; 4];

/// What light of a length adds to the moments.
pub(super) fn moments(weight: f32, length: f32) -> Moments {
    [weight, weight * length, weight * length * length, weight * length * length * length]
}

/// Value, mean length, its deviation and skewness from the moments.
pub(super) fn finished([weight, first, second, third]: Moments) -> [f32; 4] {
    if weight <= 1e-12 {
        return [0.0; 4];
    }
    let (mean, second, third) = (first / weight, second / weight, third / weight);
    let deviation = (second - mean * mean).max(0.0).sqrt();
    if deviation <= 0.02 * mean {
        // Rounding is all that is left for the skewness, and it does not matter.
        return [weight, mean, deviation, 0.0];
    }
    let skewness = (third - 3.0 * mean * second + 2.0 * mean * mean * mean) / deviation.powi(3);
    [weight, mean, deviation, skewness.clamp(-8.0, 8.0)]
}

/// The four lobes' tables: x is phi / pi, y is theta / (pi / 2).
pub fn bake(eta: f32, blur: Blur) -> [Table; N_LOBES] {
    let cumulative = Cumulative::new(blur);
    let mut tables: [Table; N_LOBES] = std::array::from_fn(|_| Table::new(WIDTH, HEIGHT));
    let rows = on_all_cores(HEIGHT, |rows| rows.map(|row| bake_row(eta, blur, &cumulative, row)).collect());
    for (row, lobes) in rows.into_iter().enumerate() {
        for (table, texels) in tables.iter_mut().zip(lobes) {
            table.texels[row * WIDTH..(row + 1) * WIDTH].copy_from_slice(&texels);
        }
    }
    tables
}

/// `n` things in order, made by as many threads as there are cores; `make` makes a range of them.
pub(super) fn on_all_cores<T: Send>(n: usize, make: impl Fn(std::ops::Range<usize>) -> Vec<T> + Sync) -> Vec<T> {
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from).min(8);
    let each = n.div_ceil(n_threads);
    let made = std::thread::scope(|scope| {
        let make = &make;
        let spawn = |thread_idx: usize| {
            let range = (thread_idx * each).min(n)..((thread_idx + 1) * each).min(n);
            scope.spawn(move || make(range))
        };
        let workers: Vec<_> = (0..n_threads).map(spawn).collect();
        workers.into_iter().map(std::thread::ScopedJoinHandle::join).collect::<Vec<_>>()
    });
    // A thread that panicked hands its panic on.
    made.into_iter().flat_map(|part| part.unwrap_or_else(|why| std::panic::resume_unwind(why))).collect()
}

fn bake_row(eta: f32, blur: Blur, cumulative: &Cumulative, row: usize) -> [Vec<[f32; 4]>; N_LOBES] {
    let theta = row as f32 / (HEIGHT - 1) as f32 * 0.5 * PI;
    let section = Section::new(eta, theta.cos());
    let mut sums = vec![[[0.0f32; 4]; WIDTH]; N_LOBES];
    let mut even = [0.0f32; 4];
    let last_p = last_p(blur);
    for panel in 0..N_PANELS {
        for p in 0..=last_p {
            // What is faint is cut half as fine.
            let n = if p < 3 { 1 } else { 2 };
            if panel % n != 0 {
                continue;
            }
            // Even steps of gamma_i: finest at the edges, where everything changes the fastest.
            let gamma = |share: f32| ((panel as f32 + share * n as f32) / N_PANELS as f32 - 0.5) * PI;
            let (low, middle, high) = (gamma(0.0).sin(), gamma(0.5).sin(), gamma(1.0).sin());
            let share = 0.5 * (high - low);
            let (f, chord) = (section.fresnel(middle), section.chord(middle));
            let mut arriving = [0.0f32; 4];
            let mut add = |p: u32, a: f32| {
                for (sum, moment) in arriving.iter_mut().zip(moments(share * a, p as f32 * chord)) {
                    *sum += moment;
                }
            };
            if p < last_p {
                add(p, attenuation(p, f));
            } else {
                (p..p + N_BEYOND).for_each(|p| add(p, attenuation(p, f)));
                add(p + N_BEYOND, attenuation_from(p + N_BEYOND, f));
            }
            if p == last_p && matches!(blur, Blur::Logistic { .. }) {
                for (sum, moment) in even.iter_mut().zip(arriving) {
                    *sum += moment / (2.0 * PI);
                }
            } else if arriving[0] > 1e-9 {
                let ends = [section.exit_azimuth(p as f32, low), section.exit_azimuth(p as f32, high)];
                spread(&mut sums[(p as usize).min(3)], cumulative, ends, arriving);
            }
        }
    }
    for texel in &mut sums[3] {
        for (sum, even) in texel.iter_mut().zip(even) {
            *sum += even;
        }
    }
    std::array::from_fn(|lobe| sums[lobe].iter().map(|&sum| finished(sum)).collect())
}

/// Add to every azimuth what a panel sends there: D averaged over the azimuths between `ends`.
fn spread(texels: &mut [Moments; WIDTH], cumulative: &Cumulative, ends: [f32; 2], arriving: Moments) {
    const TEXEL: f32 = PI / (WIDTH - 1) as f32;
    let centre = super::cylinder::wrapped(0.5 * (ends[0] + ends[1]));
    let half = 0.5 * (ends[1] - ends[0]).abs().max(TEXEL);
    let sums = &cumulative.0;
    let (from, from_share) = Cumulative::place(-centre - half);
    let (to, to_share) = Cumulative::place(-centre + half);
    let scale = 0.5 / half;
    for (x, texel) in texels.iter_mut().enumerate() {
        let at = |idx: usize, share: f32| sums[idx] + share * (sums[idx + 1] - sums[idx]);
        let step = x * STEPS_PER_TEXEL;
        let density = scale * (at(to + step, to_share) - at(from + step, from_share));
        for (sum, moment) in texel.iter_mut().zip(arriving) {
            *sum += density * moment;
        }
    }
}

/// What a texel shows at an absorption. The two lengths and their shares: those of the Gaussian quadrature of a distribution
/// with this mean, deviation and skewness, exact up to the third moment.
pub fn absorbed([value, mean, deviation, skewness]: [f32; 4], sigma_a: Vec3) -> Vec3 {
    let (half, root) = (0.5 * skewness, (1.0 + 0.25 * skewness * skewness).sqrt());
    let far_share = 0.5 - 0.5 * half / root;
    let near = (sigma_a * -(mean + deviation * (half - root)).max(0.0)).exp();
    let far = (sigma_a * -(mean + deviation * (half + root))).exp();
    value * ((1.0 - far_share) * near + far_share * far)
}

/// N_p of a lobe from its table.
pub fn azimuthal(table: &Table, sigma_a: Vec3, cos_phi: f32, cos_theta: f32) -> Vec3 {
    let x = cos_phi.clamp(-1.0, 1.0).acos() / PI;
    let y = cos_theta.clamp(0.0, 1.0).acos() / (0.5 * PI);
    absorbed(table.sample(x, y), sigma_a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::cylinder::logistic_scale;

    /// Nodes and weights of Gauss and Legendre on -1..1.
    fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
        (0..n)
            .map(|i| {
                let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
                let mut slope = 1.0;
                for _ in 0..50 {
                    let (mut p0, mut p1) = (1.0, x);
                    for k in 2..=n {
                        (p0, p1) = (p1, ((2 * k - 1) as f64 * x * p1 - (k - 1) as f64 * p0) / k as f64);
                    }
                    slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                    x -= p1 / slope;
                }
                (x, 2.0 / ((1.0 - x * x) * slope * slope))
            })
            .collect()
    }

    /// N_p by quadrature over h with the absorption inside.
    fn by_quadrature(n: usize, eta: f32, blur: Blur, p: u32, sigma_a: f32, phi: f32, theta: f32) -> f32 {
        let section = Section::new(eta, theta.cos());
        let sum: f64 = gauss_legendre(n)
            .into_iter()
            .map(|(h, weight)| {
                let h = h as f32;
                let a = attenuation(p, section.fresnel(h)) * (-sigma_a * p as f32 * section.chord(h)).exp();
                f64::from(a * blur.density(phi - section.exit_azimuth(p as f32, h))) * weight
            })
            .sum();
        0.5 * sum as f32
    }

    #[test]
    fn a_table_agrees_with_gauss_legendre_quadrature_at_every_absorption() {
        for blur in [Blur::Logistic { s: logistic_scale(0.3) }, Blur::Gaussian { deviation: 0.35 }] {
            let tables = bake(1.55, blur);
            for p in 0..3 {
                for theta in [0.0f32, 0.4, 0.9, 1.3] {
                    for phi in [0.0f32, 0.5, 1.5, 2.5, 3.1] {
                        for sigma_a in [0.0, 0.2, 1.0, 3.0] {
                            let expected = by_quadrature(200, 1.55, blur, p, sigma_a, phi, theta);
                            let table = &tables[p as usize];
                            let got = azimuthal(table, Vec3::splat(sigma_a), phi.cos(), theta.cos()).x;
                            let error = (got - expected).abs();
                            assert!(
                                error < 0.01 * expected + 2e-4,
                                "{blur:?} p {p} theta {theta} phi {phi} sigma {sigma_a}: {got} {expected}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn thirty_five_points_are_enough_at_usual_roughness_and_not_at_low() {
        // d'Eon et al. 2011 take 35; the reason for panels. The worst over azimuths, as a share of the largest.
        let worst = |deviation| {
            let blur = Blur::Gaussian { deviation };
            let at = |points, phi| by_quadrature(points, 1.55, blur, 2, 0.0, phi, 0.2);
            let phis = || (0..40).map(|i| PI * i as f32 / 40.0);
            let largest = phis().map(|phi| at(400, phi)).fold(0.0, f32::max);
            phis().map(|phi| (at(35, phi) - at(400, phi)).abs()).fold(0.0, f32::max) / largest
        };
        assert!(worst(0.3) < 0.005, "{}", worst(0.3));
        assert!(worst(0.02) > 0.05, "{}", worst(0.02));
    }

    #[test]
    fn all_lobes_together_keep_the_energy_at_every_angle_and_roughness() {
        for blur in [0.05, 0.3, 0.9]
            .map(|b| Blur::Logistic { s: logistic_scale(b) })
            .into_iter()
            .chain([Blur::Gaussian { deviation: 0.02 }, Blur::Gaussian { deviation: 0.4 }])
        {
            let tables = bake(1.55, blur);
            for row in [0, 20, 45, 60, 63] {
                let total: f32 = tables
                    .iter()
                    .flat_map(|table| {
                        (0..WIDTH).map(move |x| {
                            let ends = if x == 0 || x == WIDTH - 1 { 0.5 } else { 1.0 };
                            2.0 * ends * table.texels[row * WIDTH + x][0] * PI / (WIDTH - 1) as f32
                        })
                    })
                    .sum();
                assert!((total - 1.0).abs() < 3e-3, "{blur:?} row {row}: {total}");
            }
        }
    }
}
