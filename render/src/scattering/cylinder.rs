//! A fibre as a smooth dielectric cylinder: which way a ray leaves that came in at the offset h, how long it was inside,
//! and what share of it goes which way. Every model of R, TT, TRT, TRRT, .. starts from this.
//!
//! Lengths are in fibre radii, h = sin(gamma_i) is the place across the fibre, theta the ray's inclination outside. p is
//! the number of crossings: 0 R, 1 TT, 2 TRT. Twin of `shaders/wgsl/scatter_cylinder.wgsl`.

use std::f32::consts::PI;

use super::fibre::fresnel;

/// The cross-section that a ray of inclination theta sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    pub eta: f32,
    pub cos_theta: f32,
    /// Index of refraction across the fibre: sqrt(eta^2 - sin^2(theta)) / cos(theta), Bravais' eta' (Marschner et al.
    /// 2003, appendix B).
    pub eta_prime: f32,
    /// Of the refracted ray: sin(theta_t) = sin(theta) / eta.
    pub cos_theta_t: f32,
}

impl Section {
    pub fn new(eta: f32, cos_theta: f32) -> Self {
        let cos_theta = cos_theta.max(1e-3);
        let sin2_theta = 1.0 - cos_theta * cos_theta;
        Self {
            eta,
            cos_theta,
            eta_prime: (eta * eta - sin2_theta).max(1e-6).sqrt() / cos_theta,
            cos_theta_t: (1.0 - sin2_theta / (eta * eta)).max(1e-6).sqrt(),
        }
    }

    /// Angle of the refracted ray across the fibre.
    pub fn gamma_t(&self, h: f32) -> f32 {
        (h / self.eta_prime).clamp(-1.0, 1.0).asin()
    }

    /// Azimuth at which light leaves that came in at azimuth 0: Phi(p, h) = 2 p gamma_t - 2 gamma_i + p pi (Marschner et
    /// al. 2003, eq. 9; 002, eq. 4.4), not wrapped.
    pub fn exit_azimuth(&self, p: f32, h: f32) -> f32 {
        2.0 * p * self.gamma_t(h) - 2.0 * h.clamp(-1.0, 1.0).asin() + p * PI
    }

    /// Fresnel reflectance at the offset. The angle of incidence in space has the cosine cos(theta) cos(gamma_i); Bravais'
    /// two indices give the same number (a test shows it).
    pub fn fresnel(&self, h: f32) -> f32 {
        fresnel(self.eta, self.cos_theta * (1.0 - h * h).max(0.0).sqrt())
    }

    /// Length of one crossing: 2 cos(gamma_t) / cos(theta_t).
    pub fn chord(&self, h: f32) -> f32 {
        let sin_gamma_t = h / self.eta_prime;
        2.0 * (1.0 - sin_gamma_t * sin_gamma_t).max(0.0).sqrt() / self.cos_theta_t
    }
}

/// A(p, h) without absorption, f being the Fresnel reflectance (Marschner et al. 2003, eq. 8).
pub fn attenuation(p: u32, f: f32) -> f32 {
    if p == 0 { f } else { (1.0 - f) * (1.0 - f) * f.powi(p as i32 - 1) }
}

/// What all paths of `p` crossings or more carry without absorption: the geometric series of [`attenuation`].
pub fn attenuation_from(p: u32, f: f32) -> f32 {
    if p == 0 { 1.0 } else { (1.0 - f) * f.powi(p as i32 - 1) }
}

/// Scale of Chiang's logistic distribution for an azimuthal roughness 0-1 (Chiang et al. 2016, eq. 8; pbrt-v4 HairBxDF).
pub fn logistic_scale(beta_n: f32) -> f32 {
    let b = beta_n.clamp(0.0, 1.0);
    (PI / 8.0).sqrt() * (0.265 * b + 1.194 * b * b + 5.372 * b.powi(22)).max(1e-3)
}

/// The logistic distribution on the circle, trimmed to -pi..pi (pbrt-v4, `TrimmedLogistic`); `x` within it.
pub fn trimmed_logistic(x: f32, s: f32) -> f32 {
    let e = (-x.abs() / s).exp();
    let density = e / (s * (1.0 + e) * (1.0 + e));
    // Of -pi..pi: 1 - 2 / (1 + exp(pi / s)).
    density / (PI / (2.0 * s)).tanh()
}

/// An angle brought to -pi..pi.
pub fn wrapped(angle: f32) -> f32 {
    angle - (angle / (2.0 * PI)).round() * 2.0 * PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bravais_indices_give_the_fresnel_reflectance_of_the_angle_in_space() {
        for theta in [0.0f32, 20.0, 45.0, 70.0, 85.0] {
            let section = Section::new(1.55, theta.to_radians().cos());
            // Marschner et al. 2003, appendix B: eta'' = eta^2 cos(theta) / sqrt(eta^2 - sin^2(theta)).
            let eta_second = 1.55 * 1.55 / section.eta_prime;
            for h in [0.0f32, 0.3, 0.7, 0.95] {
                let (cos_i, cos_t) = ((1.0 - h * h).sqrt(), section.gamma_t(h).cos());
                let s = (cos_i - section.eta_prime * cos_t) / (cos_i + section.eta_prime * cos_t);
                let p = (eta_second * cos_i - cos_t) / (eta_second * cos_i + cos_t);
                let bravais = 0.5 * (s * s + p * p);
                assert!((bravais - section.fresnel(h)).abs() < 2e-5, "{theta} {h}: {bravais} {}", section.fresnel(h));
            }
        }
    }

    #[test]
    fn paths_carry_everything() {
        for f in [0.0, 0.04, 0.5, 0.99, 1.0] {
            let first: f32 = (0..4).map(|p| attenuation(p, f)).sum();
            assert!((first + attenuation_from(4, f) - 1.0).abs() < 1e-6, "{f}");
        }
    }

    #[test]
    fn the_trimmed_logistic_has_mass_one() {
        for beta_n in [0.05, 0.3, 0.6, 1.0] {
            let s = logistic_scale(beta_n);
            let n = 20_000;
            let step = 2.0 * PI / n as f32;
            let mass: f32 = (0..n).map(|i| trimmed_logistic((i as f32 + 0.5) * step - PI, s) * step).sum();
            assert!((mass - 1.0).abs() < 1e-3, "{beta_n}: {mass}");
        }
    }
}
