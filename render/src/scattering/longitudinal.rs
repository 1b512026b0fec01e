//! The energy-conserving longitudinal scattering function of d'Eon et al. 2011, eq. 7, which Chiang et al. 2016 use too:
//!
//! ```text
//! M(v, theta_i, theta_r) = exp(-sin(theta_i) sin(theta_r) / v) I0(cos(theta_i) cos(theta_r) / v) / (2 v sinh(1 / v))
//! ```
//!
//! For small v both factors overflow. d'Eon 2013 and pbrt take logarithms below v = 0.1; here the exponentials are put
//! together once and for all. With I0e(a) = exp(-a) I0(a), which needs no large number, and cos(theta_i) cos(theta_r) -
//! sin(theta_i) sin(theta_r) = cos(theta_i + theta_r):
//!
//! ```text
//! M = I0e(cos(theta_i) cos(theta_r) / v) exp((cos(theta_i + theta_r) - 1) / v) / (v (1 - exp(-2 / v)))
//! ```
//!
//! Twin of `shaders/wgsl/scatter_longitudinal.wgsl`.

/// Sine and cosine of the eye's inclination, moved by a lobe's shift of theta_i + theta_r (radians). The cosine is taken
/// positive: an inclination beyond 90 degrees folds back (pbrt-v4).
pub fn tilted(sin_theta: f32, cos_theta: f32, shift: f32) -> (f32, f32) {
    let (s, c) = shift.sin_cos();
    (sin_theta * c - cos_theta * s, (cos_theta * c + sin_theta * s).abs())
}

/// M: integrates to 1 over sin(theta_i), whatever theta_r. `v` is the variance.
pub fn longitudinal(v: f32, (sin_i, cos_i): (f32, f32), (sin_r, cos_r): (f32, f32)) -> f32 {
    let a = cos_i * cos_r / v;
    let b = (cos_i * cos_r - sin_i * sin_r - 1.0) / v;
    i0e(a) * b.exp() / (v * (1.0 - (-2.0 / v).exp()))
}

/// exp(-x) I0(x) for x >= 0 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2: relative error below 2e-7).
pub fn i0e(x: f32) -> f32 {
    if x < 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        let i0 = 1.0
            + t * (3.515_622_9
                + t * (3.089_942_4 + t * (1.206_749_2 + t * (0.265_973_2 + t * (0.036_076_8 + t * 0.004_581_3)))));
        return i0 * (-x).exp();
    }
    let t = 3.75 / x;
    let tail = t * (0.009_162_81 + t * (-0.020_577_06 + t * (0.026_355_37 + t * (-0.016_476_33 + t * 0.003_923_77))));
    (0.398_942_3 + t * (0.013_285_92 + t * (0.002_253_19 + t * (-0.001_575_65 + tail)))) / x.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I0 from its integral, in f64: 1/pi int exp(x (cos t - 1)) dt.
    fn i0e_exact(x: f64) -> f64 {
        let n = 20_000;
        (0..n)
            .map(|i| (x * (((f64::from(i) + 0.5) / f64::from(n) * std::f64::consts::PI).cos() - 1.0)).exp())
            .sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn i0e_is_the_bessel_function() {
        for x in [0.0, 0.1, 1.0, 3.7, 3.8, 10.0, 100.0, 1e4] {
            let error = f64::from(i0e(x as f32)) / i0e_exact(x) - 1.0;
            assert!(error.abs() < 2e-6, "{x}: {error:e}");
        }
    }

    #[test]
    fn m_keeps_energy_for_every_roughness_and_angle() {
        for v in [1e-4f32, 1e-3, 0.01, 0.09, 0.11, 0.5, 2.0] {
            for theta_r in [-80.0f32, -45.0, 0.0, 20.0, 60.0, 85.0, 89.0] {
                let (sin_r, cos_r) = theta_r.to_radians().sin_cos();
                // Steps of a 20th of the deviation, midpoints in theta.
                let n = (20.0 * std::f32::consts::PI / v.sqrt()).max(2000.0) as u32;
                let step = std::f64::consts::PI / f64::from(n);
                let total: f64 = (0..n)
                    .map(|i| {
                        let theta_i = -std::f64::consts::FRAC_PI_2 + (f64::from(i) + 0.5) * step;
                        let (sin_i, cos_i) = (theta_i.sin() as f32, theta_i.cos() as f32);
                        f64::from(longitudinal(v, (sin_i, cos_i), (sin_r, cos_r))) * theta_i.cos() * step
                    })
                    .sum();
                // Rounding of the cosine's difference, divided by v.
                let tolerance = f64::from(2e-4f32.max(2e-7 / v));
                assert!((total - 1.0).abs() < tolerance, "v {v}, theta {theta_r}: {total}");
            }
        }
    }

    #[test]
    fn m_is_symmetric_and_finite() {
        let at = |theta: f32| theta.to_radians().sin_cos();
        for v in [1e-4f32, 0.01, 1.0] {
            for (a, b) in [(0.0, 0.0), (30.0, -31.0), (89.9, -89.9), (-70.0, 20.0)] {
                let (ab, ba) = (longitudinal(v, at(a), at(b)), longitudinal(v, at(b), at(a)));
                assert!(ab.is_finite() && ab >= 0.0 && (ab - ba).abs() <= 1e-5 * ab, "{v} {a} {b}: {ab} {ba}");
            }
        }
    }
}
