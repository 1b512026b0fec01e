//! Marschner, Jensen, Cammarano, Worley and Hanrahan 2003 in full: a smooth cylinder whose offsets h are the roots of a
//! cubic, with caustics of TRT replaced by glints, Gaussian M, optionally flat. Baked in both factorings of the Nalu demo
//! (NVIDIA 2004; 004):
//!
//! - [`bake_lobes`]: N of each lobe over (theta_d, phi), absorption outside as in [`super::azimuthal`]; M is computed;
//! - [`bake_nalu`]: M_R, M_TT, M_TRT and cos(theta_d) over (sin(theta_i), sin(theta_r)), then N with the absorption inside over
//!   (cos(phi), cos(theta_d)). 004 calls the second table's axes cos(thetaH) and cos(phiD); what the first lookup must hand on
//!   is theta_d. Its angles are to the tangent, so that its cosines are our sines. Per-strand pigment is added after the
//!   lookup; per-strand tilt, and the spreading of M by fibres in front, are not in this table.
//!
//! Corrected: the length of a crossing is 2 cos(gamma_t) radii, not 2 + 2 cos(2 gamma_t) as printed (2003, eq. after 10; 002,
//! section 2.4.2.7), which is its square; where caustics have merged (eta' > 2) they fade out with eta', so t is 1 -
//! smoothstep; M is per theta_r (see [`super::marschner`]).
//!
//! The model makes light at grazing angles (1 / cos^2(theta_d)), and the closed form does not. A flat fibre changes the index
//! of refraction that TRT sees with the side it turns to the light (2003, section 5.2.3); sides are not known here, so TRT is
//! the average over all.

use std::f32::consts::PI;

use glam::Vec3;
use lorelei_core::look::Marschner2003Params;

use super::azimuthal::{self, HEIGHT, N_LOBES, WIDTH, azimuthal};
use super::cylinder::{Section, attenuation, wrapped};
use super::fibre::Fibre;
use super::marschner::{MIN_COS2, gaussian};
use super::table::Table;
use super::{Directions, volume};

/// Light that arrives at an azimuth: its share, and the length it has gone inside.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Arrival {
    weight: f32,
    length: f32,
}

/// One path through a smooth section: phi(p, gamma_i) = (6 p c / pi - 2) gamma_i - (8 p c / pi^3) gamma_i^3 + p pi, c =
/// asin(1 / eta') (2003, eq. 10).
#[derive(Debug, Clone, Copy)]
struct Smooth {
    section: Section,
    p: u32,
    /// Slope at 0.
    slope: f64,
    /// Factor of the cube.
    cube: f64,
}

impl Smooth {
    fn new(section: Section, p: u32) -> Self {
        let c = f64::from((1.0 / section.eta_prime).min(1.0)).asin();
        let (n, pi) = (f64::from(p), std::f64::consts::PI);
        Self { section, p, slope: 6.0 * n * c / pi - 2.0, cube: 8.0 * n * c / (pi * pi * pi) }
    }

    /// phi - p pi at an angle.
    fn turned(&self, gamma: f64) -> f64 {
        (self.slope - self.cube * gamma * gamma) * gamma
    }

    /// The angle where phi turns back, 0 where it does not: caustics are there.
    fn fold(&self) -> f64 {
        if self.slope > 0.0 { (self.slope / (3.0 * self.cube)).sqrt() } else { 0.0 }
    }

    /// Ask for the angles gamma_i from which light leaves at the azimuth `phi`: the real roots within +-pi/2.
    fn roots(&self, phi: f32, mut found: impl FnMut(f32)) {
        use std::f64::consts::{FRAC_PI_2, PI, TAU};
        let reach = self.turned(FRAC_PI_2).abs().max(self.turned(self.fold()).abs()) + 1e-9;
        let target = f64::from(wrapped(phi - self.p as f32 * PI as f32));
        for target in [target - TAU, target, target + TAU] {
            if target.abs() > reach {
                continue;
            }
            let mut keep = |gamma: f64| {
                if gamma.abs() <= FRAC_PI_2 {
                    found(gamma as f32);
                }
            };
            if self.cube < 1e-9 {
                keep(target / self.slope);
                continue;
            }
            // gamma^3 + p gamma + q = 0, Cardano and Viete.
            let (p, q) = (-self.slope / self.cube, target / self.cube);
            let discriminant = 0.25 * q * q + p * p * p / 27.0;
            if discriminant > 0.0 {
                let root = discriminant.sqrt();
                keep((-0.5 * q + root).cbrt() + (-0.5 * q - root).cbrt());
            } else {
                let size = 2.0 * (-p / 3.0).sqrt();
                let angle = (3.0 * q / (p * size)).clamp(-1.0, 1.0).acos() / 3.0;
                (0..3).for_each(|k| keep(size * (angle - TAU * f64::from(k) / 3.0).cos()));
            }
        }
    }

    /// N_p(phi) = sum over roots of A(p, h) |2 dphi/dh|^-1 (2003, eq. 8), without absorption.
    fn each(&self, phi: f32, mut add: impl FnMut(Arrival)) {
        self.roots(phi, |gamma| {
            let h = gamma.sin();
            let d_phi_d_gamma = (self.slope - 3.0 * self.cube * f64::from(gamma * gamma)).abs() as f32;
            // dphi/dh = dphi/dgamma / cos(gamma). 1e-4: at a caustic's very edge.
            let weight = attenuation(self.p, self.section.fresnel(h)) * 0.5 * gamma.cos() / d_phi_d_gamma.max(1e-4);
            add(Arrival { weight, length: self.p as f32 * self.section.chord(h) });
        });
    }
}

/// TRT with its caustics replaced by glints of width w_c (2003, figure 11).
#[derive(Debug, Clone, Copy)]
struct Glints {
    smooth: Smooth,
    w_c: f32,
    phi_c: f32,
    /// Share of the caustics that is replaced.
    t: f32,
    /// A glint's peak.
    glint: Arrival,
}

impl Glints {
    fn new(section: Section, params: &Marschner2003Params) -> Self {
        let smooth = Smooth::new(section, 2);
        let w_c = params.glint_width_deg.to_radians();
        let gamma_c = smooth.fold();
        let (delta_h, t) = if gamma_c > 0.0 {
            // d^2 phi / dh^2 where dphi/dgamma is 0.
            let second = 6.0 * smooth.cube * gamma_c / gamma_c.cos().powi(2).max(1e-4);
            (params.glint_limit.min(2.0 * (2.0 * w_c / second.max(1e-6) as f32).sqrt()), 1.0)
        } else {
            // In the cubic as in truth caustics merge at eta' = 2, where c = pi / 6.
            let x = ((section.eta_prime - 2.0) / params.glint_fade).clamp(0.0, 1.0);
            (params.glint_limit, 1.0 - x * x * (3.0 - 2.0 * x))
        };
        let h_c = gamma_c.sin() as f32;
        let peak = delta_h / (w_c * (2.0 * PI).sqrt());
        let weight = t * params.glint * attenuation(2, section.fresnel(h_c)) * peak;
        let phi_c = smooth.turned(gamma_c) as f32;
        Self { smooth, w_c, phi_c, t, glint: Arrival { weight, length: 2.0 * section.chord(h_c) } }
    }

    fn each(&self, phi: f32, mut add: impl FnMut(Arrival)) {
        let bell = |x: f32| (-0.5 * (wrapped(x) / self.w_c).powi(2)).exp();
        let (one, other) = (bell(phi - self.phi_c), bell(phi + self.phi_c));
        let kept = (1.0 - self.t * one) * (1.0 - self.t * other);
        self.smooth.each(phi, |arrival| add(Arrival { weight: kept * arrival.weight, ..arrival }));
        add(Arrival { weight: (one + other) * self.glint.weight, ..self.glint });
    }
}

/// From how many sides a flat fibre is seen.
const N_SIDES: usize = 4;

/// Indices of refraction that TRT sees of a fibre whose axes have the ratio a: eta*(phi_h) between 2 (eta - 1) a^2 - eta + 2
/// and 2 (eta - 1) / a^2 - eta + 2 (2003, section 5.2.3).
fn etas_of_trt(eta: f32, eccentricity: f32) -> [f32; N_SIDES] {
    let a2 = eccentricity * eccentricity;
    let (one, two) = (2.0 * (eta - 1.0) * a2 - eta + 2.0, 2.0 * (eta - 1.0) / a2 - eta + 2.0);
    std::array::from_fn(|i| {
        let cos_2_phi_h = (PI * (i as f32 + 0.5) / N_SIDES as f32).cos();
        (0.5 * ((one + two) + cos_2_phi_h * (one - two))).max(1.05)
    })
}

/// R, TT and TRT of a smooth fibre at one theta_d.
struct Lobes {
    r_and_tt: [Smooth; 2],
    trt: Vec<Glints>,
}

impl Lobes {
    fn new(eta: f32, params: &Marschner2003Params, cos_theta_d: f32) -> Self {
        let section = Section::new(eta, cos_theta_d);
        let is_round = (params.eccentricity - 1.0).abs() < 1e-3;
        let etas = if is_round { vec![eta] } else { etas_of_trt(eta, params.eccentricity).to_vec() };
        Self {
            r_and_tt: [0, 1].map(|p| Smooth::new(section, p)),
            trt: etas.into_iter().map(|eta| Glints::new(Section::new(eta, cos_theta_d), params)).collect(),
        }
    }

    /// What arrives in lobe 0 R, 1 TT or 2 TRT.
    fn each(&self, lobe: usize, phi: f32, mut add: impl FnMut(Arrival)) {
        if lobe < 2 {
            return self.r_and_tt[lobe].each(phi, add);
        }
        let share = 1.0 / self.trt.len() as f32;
        for trt in &self.trt {
            trt.each(phi, |arrival| add(Arrival { weight: share * arrival.weight, ..arrival }));
        }
    }

    /// N of a lobe with its absorption.
    fn n(&self, lobe: usize, sigma_a: Vec3, phi: f32) -> Vec3 {
        let mut n = Vec3::ZERO;
        self.each(lobe, phi, |arrival| n += arrival.weight * (sigma_a * -arrival.length).exp());
        n
    }
}

/// Places within a texel at which TT and TRT are asked: they have edges.
const N_WITHIN: usize = 3;

/// Where within a texel a lobe is asked, in texels from its centre.
fn within(lobe: usize) -> impl Iterator<Item = f32> + Clone {
    let n = if lobe == 0 { 1 } else { N_WITHIN };
    (0..n).map(move |i| (i as f32 + 0.5) / n as f32 - 0.5)
}

/// N of R, TT, TRT in the layout of [`azimuthal::bake`], and an empty fourth.
pub fn bake_lobes(eta: f32, params: &Marschner2003Params) -> Vec<Table> {
    bake_rows(|y| {
        let cos_theta_d = (y as f32 / (HEIGHT - 1) as f32 * 0.5 * PI).cos();
        let lobes = Lobes::new(eta, params, cos_theta_d);
        move |lobe, x| {
            let mut sums = [0.0f32; 4];
            let places = within(lobe);
            let share = 1.0 / places.clone().count() as f32;
            for offset in places {
                lobes.each(lobe, (x as f32 + offset) / (WIDTH - 1) as f32 * PI, |arrival| {
                    let moments = azimuthal::moments(share * arrival.weight, arrival.length);
                    sums.iter_mut().zip(moments).for_each(|(sum, moment)| *sum += moment);
                });
            }
            azimuthal::finished(sums)
        }
    })
}

/// Sides of the table of M.
pub const M_SIDE: usize = 256;

/// M_R, M_TT, M_TRT and cos(theta_d); x is sin(theta_i), y is sin(theta_r), both -1 to 1.
pub fn bake_m(beta: [f32; 3], alpha: [f32; 3]) -> Table {
    let mut table = Table::new(M_SIDE, M_SIDE);
    for (i, texel) in table.texels.iter_mut().enumerate() {
        let sine = |i: usize| 2.0 * i as f32 / (M_SIDE - 1) as f32 - 1.0;
        let (sin_i, sin_r) = (sine(i % M_SIDE), sine(i / M_SIDE));
        let (theta_i, theta_r) = (sin_i.asin(), sin_r.asin());
        let m = |p: usize| gaussian(beta[p], 0.5 * (theta_i + theta_r) - alpha[p]);
        *texel = [m(0), m(1), m(2), (0.5 * (theta_r - theta_i)).cos().max(0.0)];
    }
    table
}

/// N with the absorption inside: R (in x), TT and TRT (RGB), and an empty fourth; x is (cos(phi) + 1) / 2, y is cos(theta_d).
pub fn bake_nalu(eta: f32, params: &Marschner2003Params, sigma_a: Vec3) -> Vec<Table> {
    bake_rows(|y| {
        let lobes = Lobes::new(eta, params, y as f32 / (HEIGHT - 1) as f32);
        move |lobe, x| {
            let places = within(lobe);
            let share = 1.0 / places.clone().count() as f32;
            let at = |offset: f32| {
                let cos_phi = 2.0 * (x as f32 + offset) / (WIDTH - 1) as f32 - 1.0;
                lobes.n(lobe, sigma_a, cos_phi.clamp(-1.0, 1.0).acos())
            };
            (share * places.map(at).sum::<Vec3>()).extend(0.0).to_array()
        }
    })
}

/// Tables of R, TT, TRT and an empty fourth, on all cores. `row` makes what a row has in common, and that makes texels by
/// lobe and x.
fn bake_rows<F: Fn(usize, usize) -> [f32; 4]>(row: impl Fn(usize) -> F + Sync) -> Vec<Table> {
    let bake = |rows: std::ops::Range<usize>| -> Vec<[Vec<[f32; 4]>; 3]> {
        rows.map(|y| {
            let texel = row(y);
            std::array::from_fn(|lobe| (0..WIDTH).map(|x| texel(lobe, x)).collect())
        })
        .collect()
    };
    let mut tables: Vec<Table> = (0..N_LOBES).map(|_| Table::new(WIDTH, HEIGHT)).collect();
    for (y, lobes) in azimuthal::on_all_cores(HEIGHT, bake).into_iter().enumerate() {
        for (table, texels) in tables.iter_mut().zip(lobes) {
            table.texels[y * WIDTH..(y + 1) * WIDTH].copy_from_slice(&texels);
        }
    }
    tables
}

/// L / E of one fibre from the tables of its lobes.
pub fn scatter(fibre: &Fibre, tables: &[Table], d: &Directions) -> Vec3 {
    let lobes: Vec3 = (0..3)
        .map(|p| {
            let n = azimuthal(&tables[p], Vec3::from_array(fibre.sigma_a), d.cos_phi, d.cos_theta_d);
            fibre.weight[p] * gaussian(fibre.beta[p], d.theta_h - fibre.alpha[p]) * n
        })
        .sum();
    lobes * d.cos_theta_i / (d.cos_theta_d * d.cos_theta_d).max(MIN_COS2)
}

/// L / E of one fibre from the tables of the demo.
pub fn scatter_nalu(fibre: &Fibre, m: &Table, tables: &[Table], d: &Directions) -> Vec3 {
    let [m_r, m_tt, m_trt, cos_theta_d] = m.sample(0.5 + 0.5 * d.sin_theta_i, 0.5 + 0.5 * d.sin_theta_r);
    let n = |p: usize| Vec3::from_slice(&tables[p].sample(0.5 + 0.5 * d.cos_phi, cos_theta_d)[..3]);
    let added = Vec3::from_array(fibre.sigma_a) - Vec3::from_array(fibre.baked_sigma_a);
    let chord = 2.0 * volume::chord(fibre.eta, cos_theta_d.max(1e-3), super::marschner::H_CHORD_TT);
    let t = (added * -chord).exp();
    let lobes = fibre.weight[0] * m_r * Vec3::splat(n(0).x)
        + fibre.weight[1] * m_tt * n(1) * t
        + fibre.weight[2] * m_trt * n(2) * t * t;
    lobes * d.cos_theta_i / (cos_theta_d * cos_theta_d).max(MIN_COS2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// N of a lobe straight from the roots.
    fn exact(params: &Marschner2003Params, lobe: usize, sigma_a: Vec3, phi: f32, cos_theta_d: f32) -> Vec3 {
        Lobes::new(1.55, params, cos_theta_d).n(lobe, sigma_a, phi)
    }

    #[test]
    fn roots_are_roots_of_the_exit_azimuth_and_trt_has_one_or_three() {
        let section = Section::new(1.55, 1.0);
        for p in 0..3 {
            let smooth = Smooth::new(section, p);
            for phi in [-3.0f32, -1.0, -0.2, 0.0, 0.1, 0.3, 1.0, 2.0, 3.1] {
                let mut n = 0;
                smooth.roots(phi, |gamma| {
                    n += 1;
                    let left = wrapped(section.exit_azimuth(p as f32, gamma.sin()) - phi);
                    // The cubic stands for asin; at this index it is within 0.03 for each crossing.
                    assert!(left.abs() < 0.06 * p as f32 + 1e-4, "{p} {phi} {gamma}: {left}");
                });
                // TT and TRT do not reach every azimuth.
                assert!(n <= 1 || (p == 2 && n == 3), "{p} {phi}: {n}");
            }
        }
        let mut n = 0;
        Smooth::new(section, 2).roots(0.1, |_| n += 1);
        assert_eq!(n, 3);
    }

    #[test]
    fn smooth_lobes_carry_the_energy_of_their_paths() {
        for theta_d in [0.0f32, 40.0, 70.0] {
            let section = Section::new(1.55, theta_d.to_radians().cos());
            for p in 0..2 {
                let n = 20_000;
                let mut got = 0.0;
                for i in 0..n {
                    let phi = (i as f32 + 0.5) / n as f32 * 2.0 * PI - PI;
                    Smooth::new(section, p).each(phi, |arrival| got += arrival.weight * 2.0 * PI / n as f32);
                }
                let m = 4000;
                let expected: f32 =
                    (0..m).map(|i| attenuation(p, section.fresnel((i as f32 + 0.5) / m as f32)) / m as f32).sum();
                assert!((got / expected - 1.0).abs() < 0.02, "{p} at {theta_d}: {got} {expected}");
            }
        }
    }

    /// At normal incidence, where M's 1 / cos^2 makes nothing.
    #[test]
    fn a_fibre_that_absorbs_nothing_returns_about_what_it_gets() {
        for glint in [0.0, 1.0] {
            let mut total = 0.0;
            for lobe in 0..3 {
                let params = Marschner2003Params { glint, ..Marschner2003Params::default() };
                let n = 2000;
                let at = |i| exact(&params, lobe, Vec3::ZERO, (i as f32 + 0.5) / n as f32 * PI, 1.0).x;
                total += (0..n).map(at).sum::<f32>() * 2.0 * PI / n as f32;
            }
            // Glints of strength 1 carry about what the caustics did.
            println!("glint {glint}: {total:.3}");
            assert!((0.9..1.02).contains(&total), "{glint}: {total}");
        }
    }

    #[test]
    fn caustics_are_finite_and_the_glint_scales_them() {
        let at = |glint, phi| {
            let params = Marschner2003Params { glint, ..Marschner2003Params::default() };
            exact(&params, 2, Vec3::ZERO, phi, 1.0).x
        };
        let mut brightest = (0.0f32, 0.0f32);
        let mut last = at(1.0, 0.0);
        for i in 0..=1000 {
            let phi = i as f32 / 1000.0 * PI;
            let l = at(1.0, phi);
            assert!(l.is_finite() && l >= 0.0 && (l - last).abs() < 0.02, "{phi}: {last} {l}");
            last = l;
            brightest = if l > brightest.1 { (phi, l) } else { brightest };
        }
        // At eta' = 1.55 the caustics are at 0.35 rad.
        assert!(brightest.0 < 0.6, "{brightest:?}");
        assert!(at(3.0, brightest.0) > 2.0 * at(1.0, brightest.0));
    }

    #[test]
    fn merged_caustics_fade_without_a_jump() {
        let params = Marschner2003Params::default();
        let mut last: Option<f32> = None;
        for step in 0..=400 {
            // eta' from 1.55 to beyond 2.5.
            let cos_theta = (0.2 * step as f32).to_radians().cos();
            let l = exact(&params, 2, Vec3::ZERO, 0.05, cos_theta).x;
            if let Some(last) = last {
                assert!((l - last).abs() < 0.012, "{step}: {last} {l}");
            }
            last = Some(l);
        }
    }

    #[test]
    fn tables_agree_with_the_roots_at_every_absorption() {
        let params = Marschner2003Params { eccentricity: 0.9, ..Marschner2003Params::default() };
        let lobes = bake_lobes(1.55, &params);
        let sigma_a = Vec3::new(0.1, 0.5, 2.0);
        let nalu = bake_nalu(1.55, &params, sigma_a);
        for lobe in 0..3 {
            for phi in [0.2f32, 0.6, 1.2, 2.0, 2.8] {
                for theta_d in [0.05f32, 0.5, 1.0, 1.3] {
                    let expected = exact(&params, lobe, sigma_a, phi, theta_d.cos());
                    let separate = azimuthal(&lobes[lobe], sigma_a, phi.cos(), theta_d.cos());
                    let inside = nalu[lobe].sample(0.5 + 0.5 * phi.cos(), theta_d.cos());
                    assert!(
                        (separate - expected).abs().max_element() < 0.02 * expected.x + 1e-3,
                        "{lobe} {phi} {theta_d}: {separate} {expected}"
                    );
                    assert!(
                        (inside[0] - expected.x).abs() < 0.03 * expected.x + 2e-3,
                        "{lobe} {phi} {theta_d}: {inside:?} {expected}"
                    );
                }
            }
        }
    }
}
