//! What many fibres do to light: two streams, forward and back, as in Kubelka and Munk 1931.
//!
//! One fibre in the way sends a share a_f of the light on and a share a_b back (Zinke et al. 2008 call them the average
//! forward and backward attenuation). A thick heap of fibres then returns R_inf of what it gets, and light dies in it
//! as exp(-K tau), tau being the optical depth if fibres were black. Without absorption a_f + a_b = 1, so K = 0
//! and R_inf = 1: a white furnace stays white. Chiang's fit of colour to absorption (2016, eq. 9) was rejected here: it
//! leaves out R, and there is no decay that belongs to it.

use glam::Vec3;

use super::fibre::{Fibre, fresnel};
use super::marschner::{H_CHORD_TRT, H_CHORD_TT, H_FRESNEL_TRT, H_FRESNEL_TT};

/// (1 - F)^2 T: what TT carries at a difference angle. 002, eq. 4.22, see the departures in [`super::marschner`].
pub fn attenuation_tt(fibre: &Fibre, cos_theta_d: f32) -> Vec3 {
    let f = fresnel(fibre.eta, cos_theta_d * (1.0 - H_FRESNEL_TT * H_FRESNEL_TT).sqrt());
    let chords = 2.0 * chord(fibre.eta, cos_theta_d, H_CHORD_TT);
    (1.0 - f) * (1.0 - f) * (Vec3::from_array(fibre.sigma_a) * -chords).exp()
}

/// (1 - F)^2 F T^2: what TRT carries. 002, eq. 4.28.
pub fn attenuation_trt(fibre: &Fibre, cos_theta_d: f32) -> Vec3 {
    let f = fresnel(fibre.eta, cos_theta_d * (1.0 - H_FRESNEL_TRT * H_FRESNEL_TRT).sqrt());
    let chords = 4.0 * chord(fibre.eta, cos_theta_d, H_CHORD_TRT);
    (1.0 - f) * (1.0 - f) * f * (Vec3::from_array(fibre.sigma_a) * -chords).exp()
}

/// Half of one crossing in fibre radii: cos(gamma_t) / cos(theta_t), with the virtual index of refraction eta' of
/// Marschner et al. 2003 across the fibre and Snell's law along it.
pub(super) fn chord(eta: f32, cos_theta_d: f32, h: f32) -> f32 {
    let sin2_theta_d = 1.0 - cos_theta_d * cos_theta_d;
    let cos_theta_t = (1.0 - sin2_theta_d / (eta * eta)).sqrt();
    let eta_prime = (eta * eta - sin2_theta_d).sqrt() / cos_theta_d;
    let sin_gamma_t = h / eta_prime;
    (1.0 - sin_gamma_t * sin_gamma_t).sqrt() / cos_theta_t
}

/// What a thick heap of one kind of fibre does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Volume {
    /// Share of the light that it returns (R_inf).
    pub albedo: Vec3,
    /// K: light dies as exp(-K tau).
    pub decay: Vec3,
    /// a_b: share that one fibre returns.
    pub back: Vec3,
    /// a_f: share that one fibre sends on.
    pub front: Vec3,
}

/// R's share of the power at theta_d = 0: the Fresnel reflectance averaged over the width at eta = 1.55.
const A_R: f32 = 0.075;

/// Shares of R and TRT that leave on the side that light comes from, light coming evenly from half of all azimuths:
/// for R's cos(phi / 2) / 4 it is 2 / pi; for TRT that of a concentration of 10.
const R_BACK: f32 = 0.637;
const TRT_BACK: f32 = 0.92;

pub fn volume(fibre: &Fibre) -> Volume {
    let a_tt = attenuation_tt(fibre, 1.0);
    let a_trt = attenuation_trt(fibre, 1.0);
    // What the three lobes leave out counts as TRT.
    let white_tt = (1.0 - fresnel(fibre.eta, (1.0 - H_FRESNEL_TT * H_FRESNEL_TT).sqrt())).powi(2);
    let f_trt = fresnel(fibre.eta, (1.0 - H_FRESNEL_TRT * H_FRESNEL_TRT).sqrt());
    let white_trt = (1.0 - f_trt).powi(2) * f_trt;
    let rest = (1.0 - A_R - white_tt) / white_trt;
    let a_trt = rest.max(1.0) * a_trt;
    let front = Vec3::splat((1.0 - R_BACK) * A_R) + (1.0 - fibre.tt_back) * a_tt + (1.0 - TRT_BACK) * a_trt;
    let back = Vec3::splat(R_BACK * A_R) + fibre.tt_back * a_tt + TRT_BACK * a_trt;
    let lost = (Vec3::ONE - front).max(back);
    let decay = (lost * lost - back * back).max(Vec3::ZERO).map(f32::sqrt);
    Volume { albedo: back / (lost + decay), decay, back, front }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::Look;

    fn of(eumelanin: f32) -> Volume {
        let material = HairMaterial { eumelanin, pheomelanin: 0.0, ..HairMaterial::default() };
        volume(&Fibre::new(&material, &Look::default()))
    }

    #[test]
    fn white_hair_returns_everything_and_light_does_not_die_in_it() {
        let white = of(0.0);
        assert!(white.albedo.x > 0.999 && white.albedo.x <= 1.0 + 1e-5, "{white:?}");
        assert!(white.decay.x < 1e-3, "{white:?}");
    }

    #[test]
    fn one_fibre_s_shares_agree_with_an_independent_table() {
        // Mitsuba 3.9.1's hair BSDF at beta 0.3/0.3, eta 1.55, theta 0: (sigma_a, average forward attenuation, backward).
        for (sigma, forward, backward) in [(0.03, 0.742, 0.215), (0.07, 0.690, 0.198), (0.15, 0.597, 0.169)] {
            let now = of(sigma / 0.419);
            assert!((now.front.x - forward).abs() < 0.05, "{sigma}: {}", now.front.x);
            assert!((now.back.x - backward).abs() < 0.02, "{sigma}: {}", now.back.x);
        }
    }

    #[test]
    fn pigment_darkens_and_reddens() {
        let mut last = of(0.0);
        for eumelanin in [0.1, 0.3, 1.3, 8.0] {
            let now = of(eumelanin);
            assert!(now.albedo.cmple(last.albedo).all() && now.decay.cmpge(last.decay).all(), "{eumelanin}");
            assert!(now.albedo.x >= now.albedo.z, "{now:?}");
            last = now;
        }
        // Black hair returns little more than its surface does.
        assert!(last.albedo.x < 0.06, "{last:?}");
    }

    #[test]
    fn the_colour_agrees_with_the_fit_of_chiang_for_light_hair() {
        // Chiang et al. 2016, eq. 9 at beta_n = 0.3: sigma_a = (ln c / 5.888)^2. It is a fit of path traced spheres of
        // hair without their highlight, so two streams are brighter, by no more than half.
        for c in [0.3f32, 0.5, 0.7] {
            let sigma = (c.ln() / 5.888).powi(2);
            let now = of(sigma / 0.419);
            assert!((0.9..1.55).contains(&(now.albedo.x / c)), "{c}: {}", now.albedo.x);
        }
    }
}
