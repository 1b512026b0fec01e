//! A hair material as the scattering formulas want it: what needs integrals or special functions is done here, once
//! a frame, so that the GPU multiplies.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::hash;
use lorelei_core::look::{Fresnel, Look, Offsets, Switch};

use super::cylinder;
use super::marschner::{H_CHORD_TRT, H_CHORD_TT, H_FRESNEL_TRT, H_FRESNEL_TT};

/// Twin of `Fibre` in `scatter_fibre.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct Fibre {
    /// Absorption per fibre radius, RGB.
    pub sigma_a: [f32; 3],
    /// Index of refraction.
    pub eta: f32,
    /// Standard deviations of R, TT, TRT in theta_h, radians.
    pub beta: [f32; 3],
    /// Concentration of TT around phi = pi.
    pub kappa_tt: f32,
    /// Centres of R, TT, TRT in theta_h, radians.
    pub alpha: [f32; 3],
    /// Concentration of TRT around phi = 0.
    pub kappa_trt: f32,
    /// Weights of R, TT, TRT.
    pub weight: [f32; 3],
    /// 1 / (2 pi exp(-kappa) I0(kappa)) of TT.
    pub norm_tt: f32,
    /// The same of TRT.
    pub norm_trt: f32,
    /// Share of TT that leaves on the side that diffuse light comes from.
    pub tt_back: f32,
    /// Spread of the absorption from strand to strand.
    pub colour_variation: f32,
    /// Share of the absorption that is gone at the tip.
    pub tip_lightening: f32,
    pub kk_diffuse: f32,
    pub kk_specular: f32,
    pub kk_exponent: f32,
    pub multiple_weight: f32,
    /// Absorption that went into the table, where one has the colour inside.
    pub baked_sigma_a: [f32; 3],
    /// First layer of this material's tables.
    pub table: u32,
    /// Offsets of the closed form: TT's reflectance and chord, TRT's. TT's reflectance below 0: Karis' approximation.
    pub offsets: [f32; 4],
    /// Weight of what crosses three times or more.
    pub weight_rest: f32,
    /// Scale of Chiang's azimuthal logistic distribution.
    pub logistic: f32,
    /// 1 where the closed form takes Schlick's reflectance, else 0.
    pub schlick: f32,
    /// Deviation of the logarithm of the longitudinal roughness, from strand to strand.
    pub roughness_variation: f32,
    /// The dye's absorption per fibre radius.
    pub dye_sigma_a: [f32; 3],
    /// Share of the own absorption that it takes the place of.
    pub dye: f32,
    /// Shares of the strand's length where the dye begins and where it is full.
    pub dye_from: f32,
    pub dye_to: f32,
    /// Deviation of the scales' tilt from strand to strand, radians, beside what follows the colour's.
    pub tilt_variation: f32,
    pub pad: f32,
}

impl Fibre {
    pub fn new(material: &HairMaterial, look: &Look) -> Self {
        let b = material.beta_m_deg.to_radians();
        let tilt = material.tilt_deg.to_radians();
        let (kappa_tt, kappa_trt) = azimuthal_concentrations(material.beta_n, material.index_of_refraction);
        let on = |switch: Switch, weight: f32| match switch {
            Switch::On => weight,
            Switch::Off => 0.0,
        };
        Self {
            sigma_a: material.sigma_a().to_array(),
            eta: material.index_of_refraction,
            // Marschner et al. 2003, table 1: the scales turn R to the root, TT and TRT to the tip.
            beta: [b, 0.5 * b, 2.0 * b],
            kappa_tt,
            alpha: [-tilt, 0.5 * tilt, 1.5 * tilt],
            kappa_trt,
            weight: [
                on(look.lobe_r, look.weight_r),
                on(look.lobe_tt, look.weight_tt),
                on(look.lobe_trt, look.weight_trt),
            ],
            norm_tt: von_mises_norm(kappa_tt),
            norm_trt: von_mises_norm(kappa_trt),
            tt_back: share_behind(kappa_tt),
            colour_variation: material.colour_variation,
            tip_lightening: material.tip_lightening,
            kk_diffuse: look.kajiya_kay.diffuse,
            kk_specular: look.kajiya_kay.specular,
            kk_exponent: look.kajiya_kay.exponent,
            multiple_weight: look.multiple_scattering_weight,
            baked_sigma_a: material.sigma_a().to_array(),
            table: 0,
            offsets: match look.offsets {
                Offsets::Fitted => [H_FRESNEL_TT, H_CHORD_TT, H_FRESNEL_TRT, H_CHORD_TRT],
                // 002, eq. 4.19, 4.24 and 4.25.
                Offsets::Tafuri => [0.0, 0.0, 0.866_025_4, 0.866_025_4],
                // 002, eq. 4.16.
                Offsets::Karis => [-1.0, -1.0, 0.866_025_4, 0.866_025_4],
            },
            weight_rest: look.rest_weight,
            logistic: cylinder::logistic_scale(material.beta_n),
            schlick: match look.fresnel {
                Fresnel::Exact => 0.0,
                Fresnel::Schlick => 1.0,
            },
            roughness_variation: material.roughness_variation,
            dye_sigma_a: material.dye_sigma_a().to_array(),
            dye: material.dye,
            dye_from: material.dye_from,
            dye_to: material.dye_to,
            tilt_variation: material.tilt_variation_deg.to_radians(),
            pad: 0.0,
        }
    }

    /// The fibre of one strand at a share `t` of its length (0 root, 1 tip), which takes a share `painted_dye` of the dye: pigment differs from strand to strand,
    /// and so does the way its scales lie, which is what breaks a highlight up.
    #[must_use]
    pub fn vary(&self, strand_seed: u32, t: f32, painted_dye: f32) -> Self {
        let mut fibre = *self;
        // Sums of uniforms: close to normal with a standard deviation of 1, never beyond 3.
        let bytes = strand_seed.to_le_bytes().map(|byte| f32::from(byte) / 255.0);
        let pigment = 2.45 * (bytes[0] + bytes[1] - 1.0);
        let scales = 2.45 * (bytes[2] + bytes[3] - 1.0);
        let absorption = (self.colour_variation * pigment).exp() * (1.0 - self.tip_lightening * t * t);
        let dyed = self.dye * painted_dye * ramp(self.dye_from, self.dye_to, t);
        let own = Vec3::from_array(self.sigma_a) * absorption;
        fibre.sigma_a = own.lerp(Vec3::from_array(self.dye_sigma_a), dyed).to_array();
        let more = hash::pcg(strand_seed).to_le_bytes().map(|byte| f32::from(byte) / 255.0);
        let rougher = (self.roughness_variation * 2.45 * (more[0] + more[1] - 1.0)).exp();
        fibre.beta = self.beta.map(|beta| beta * rougher);
        let more_tilt = self.tilt_variation * 2.45 * (more[2] + more[3] - 1.0);
        let shift = TILT_VARIATION * self.colour_variation * scales * self.beta[0] + more_tilt;
        fibre.alpha = [self.alpha[0] + shift, self.alpha[1] - 0.5 * shift, self.alpha[2] - 1.5 * shift];
        fibre
    }
}

/// 0 before `from`, 1 from `to` on.
fn ramp(from: f32, to: f32, t: f32) -> f32 {
    if t >= to { 1.0 } else { ((t - from) / (to - from).max(1e-3)).clamp(0.0, 1.0) }
}

/// Spread of the scale tilt at colour variation 1, in units of beta. Looked at: 2 at the default variation of 0.15
/// breaks the band without making it noise.
pub const TILT_VARIATION: f32 = 2.0;

/// Concentrations (von Mises) of TT and TRT for an azimuthal roughness 0-1 as in Chiang et al. 2016.
///
/// The references' exp(-3.65 cos phi - 3.98) and exp(17 cos phi - 16.78) (Karis 2016) are von Mises lobes of one
/// roughness; the scale factor that 002, eq. 4.27 puts on TRT loses up to two thirds of its energy. Here the
/// concentration comes from the first circular moment of what it stands for: the smooth cylinder's Phi(p, h)
/// averaged over h, blurred by Chiang's logistic distribution, and the lobe stays normalised.
fn azimuthal_concentrations(beta_n: f32, eta: f32) -> (f32, f32) {
    let blur = logistic_moment(beta_n);
    let smooth = |p: f32| {
        let n = 64;
        let (mut moment, mut power) = (0.0, 0.0);
        for i in 0..n {
            let h = (i as f32 + 0.5) / n as f32;
            let (gamma_i, gamma_t) = (h.asin(), (h / eta).asin());
            let f = fresnel(eta, gamma_i.cos());
            let a = (1.0 - f).powi(2) * if p > 1.5 { f } else { 1.0 };
            // 002, eq. 4.4, turned so that the lobe's centre is at 0.
            moment += a * (2.0 * p * gamma_t - 2.0 * gamma_i).cos();
            power += a;
        }
        moment / power
    };
    (kappa_of_moment(blur * smooth(1.0)), kappa_of_moment(blur * smooth(2.0)))
}

/// Mean cosine of the logistic distribution on the circle with Chiang's scale for `beta_n` (pbrt-v4, HairBxDF).
fn logistic_moment(beta_n: f32) -> f32 {
    let b = beta_n.clamp(0.0, 1.0);
    let s = (std::f32::consts::PI / 8.0).sqrt() * (0.265 * b + 1.194 * b * b + 5.372 * b.powi(22));
    let s = s.max(1e-3);
    let n = 512;
    let (mut moment, mut mass) = (0.0, 0.0);
    for i in 0..n {
        // Samples in equal steps of the distribution's own quantile would be finer; equal angles do for s > 1e-3.
        let x = (i as f32 + 0.5) / n as f32 * std::f32::consts::PI;
        let e = (-x / s).exp();
        let density = e / (1.0 + e).powi(2);
        moment += density * x.cos();
        mass += density;
    }
    if mass > 0.0 { moment / mass } else { 1.0 }
}

/// Inverse of I1(kappa)/I0(kappa) (Best and Fisher 1981).
fn kappa_of_moment(m: f32) -> f32 {
    let m = m.clamp(0.0, 0.995);
    if m < 0.53 {
        2.0 * m + m.powi(3) + 5.0 / 6.0 * m.powi(5)
    } else if m < 0.85 {
        -0.4 + 1.39 * m + 0.43 / (1.0 - m)
    } else {
        1.0 / (m.powi(3) - 4.0 * m * m + 3.0 * m)
    }
}

/// 1 / (2 pi exp(-kappa) I0(kappa)), by quadrature.
fn von_mises_norm(kappa: f32) -> f32 {
    let n = 512;
    let step = std::f32::consts::PI / n as f32;
    let half: f32 = (0..n).map(|i| (kappa * (((i as f32 + 0.5) * step).cos() - 1.0)).exp() * step).sum();
    0.5 / half
}

/// Share of a von Mises lobe around "straight on" that leaves on the side that light comes from, light coming evenly from
/// half of all azimuths: an angle delta carries |delta| / pi of it over the edge.
fn share_behind(kappa: f32) -> f32 {
    let n = 256;
    let angle = |i: usize| (i as f32 + 0.5) / n as f32 * std::f32::consts::PI;
    let density = |i: usize| (kappa * (angle(i).cos() - 1.0)).exp();
    let carried: f32 = (0..n).map(|i| density(i) * angle(i)).sum();
    carried / (0..n).map(density).sum::<f32>() / std::f32::consts::PI
}

/// Schlick's approximation of [`fresnel`], as 002 has it: averaged over the fibre's width at eta = 1.55 it is a fifth too
/// bright (0.091 against 0.075), and all of R is this number.
pub fn fresnel_schlick(eta: f32, cos_i: f32) -> f32 {
    let f0 = (eta - 1.0) / (eta + 1.0);
    let f0 = f0 * f0;
    f0 + (1.0 - f0) * (1.0 - cos_i.clamp(0.0, 1.0)).powi(5)
}

/// Fresnel reflectance of a dielectric, unpolarised.
pub fn fresnel(eta: f32, cos_i: f32) -> f32 {
    let c = cos_i.clamp(0.0, 1.0);
    let cos_t = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
    let s = (c - eta * cos_t) / (c + eta * cos_t);
    let p = (eta * c - cos_t) / (eta * c + cos_t);
    0.5 * (s * s + p * p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn concentrations_are_those_of_karis_at_average_roughness_and_fall_with_roughness() {
        let (tt, trt) = azimuthal_concentrations(0.3, 1.55);
        // Karis 2016: 3.65 and 17, for a smoother TRT.
        assert!((tt - 3.65).abs() < 0.4, "{tt}");
        assert!((8.0..17.0).contains(&trt), "{trt}");
        let mut last = (f32::MAX, f32::MAX);
        for step in 1..=20 {
            let now = azimuthal_concentrations(step as f32 / 20.0, 1.55);
            assert!(now.0 <= last.0 && now.1 <= last.1, "{step}: {now:?} after {last:?}");
            last = now;
        }
    }

    #[test]
    fn dye_takes_the_place_of_the_own_colour_where_it_is() {
        let mut material = HairMaterial { colour_variation: 0.0, tip_lightening: 0.0, ..HairMaterial::default() };
        (material.dye, material.dye_from, material.dye_to) = (1.0, 0.2, 0.6);
        let fibre = Fibre::new(&material, &Look::default());
        assert_eq!(fibre.vary(7, 0.1, 1.0).sigma_a, fibre.sigma_a);
        assert_eq!(fibre.vary(7, 0.6, 1.0).sigma_a, fibre.dye_sigma_a);
        let between = fibre.vary(7, 0.4, 1.0).sigma_a[0];
        assert!((between - 0.5 * (fibre.sigma_a[0] + fibre.dye_sigma_a[0])).abs() < 1e-5);
        // Without a ramp the whole strand is dyed.
        let whole = Fibre { dye_from: 0.0, dye_to: 0.0, ..fibre };
        assert_eq!(whole.vary(7, 0.0, 1.0).sigma_a, whole.dye_sigma_a);
        // Painted out it is the own colour again, and half of it lies in the middle.
        assert_eq!(whole.vary(7, 0.0, 0.0).sigma_a, fibre.vary(7, 0.0, 1.0).sigma_a);
        let half = whole.vary(7, 0.0, 0.5).sigma_a[0];
        assert!((half - 0.5 * (fibre.sigma_a[0] + whole.dye_sigma_a[0])).abs() < 1e-6, "{half}");
    }

    #[test]
    fn strands_differ_by_as_much_as_is_asked() {
        let material = HairMaterial {
            roughness_variation: 0.2,
            tilt_variation_deg: 4.0,
            colour_variation: 0.0,
            ..HairMaterial::default()
        };
        let fibre = Fibre::new(&material, &Look::default());
        let n = 4000u32;
        let strands: Vec<Fibre> = (0..n).map(|i| fibre.vary(hash::pcg(i), 0.0, 1.0)).collect();
        let deviation = |of: &dyn Fn(&Fibre) -> f32| {
            let mean = strands.iter().map(of).sum::<f32>() / n as f32;
            (strands.iter().map(|strand| (of(strand) - mean).powi(2)).sum::<f32>() / n as f32).sqrt()
        };
        assert!((deviation(&|strand| (strand.beta[0] / fibre.beta[0]).ln()) - 0.2).abs() < 0.02);
        assert!((deviation(&|strand| strand.alpha[0].to_degrees()) - 4.0).abs() < 0.4);
        assert!(strands.iter().all(|strand| strand.sigma_a == fibre.sigma_a));
    }

    #[test]
    fn von_mises_lobes_integrate_to_one() {
        for kappa in [0.0, 0.5, 3.65, 17.0, 80.0] {
            let norm = von_mises_norm(kappa);
            let n = 2000;
            let step = std::f32::consts::TAU / n as f32;
            let total: f32 = (0..n).map(|i| norm * (kappa * ((i as f32 * step).cos() - 1.0)).exp() * step).sum();
            assert!((total - 1.0).abs() < 1e-3, "{kappa}: {total}");
        }
    }

    #[test]
    fn fresnel_at_normal_incidence_and_at_grazing() {
        assert!((fresnel(1.55, 1.0) - (0.55f32 / 2.55).powi(2)).abs() < 1e-6);
        assert!((fresnel(1.55, 0.0) - 1.0).abs() < 1e-6);
    }
}
