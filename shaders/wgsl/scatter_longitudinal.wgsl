// The energy-conserving longitudinal function of d'Eon et al. 2011, eq. 7. Twin of render/src/scattering/longitudinal.rs,
// which derives this form.
#define_import_path lorelei::scatter_longitudinal
#import lorelei::scatter_fibre::{Directions}

// exp(-x) I0(x), x >= 0 (Abramowitz and Stegun 1964, 9.8.1 and 9.8.2).
fn i0e(x: f32) -> f32 {
    if x < 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        let i0 = 1.0 + t * (3.5156229 + t * (3.0899424 + t * (1.2067492 + t * (0.2659732 + t * (0.0360768 + t * 0.0045813)))));
        return i0 * exp(-x);
    }
    let t = 3.75 / x;
    let tail = t * (0.00916281 + t * (-0.02057706 + t * (0.02635537 + t * (-0.01647633 + t * 0.00392377))));
    return (0.39894228 + t * (0.01328592 + t * (0.00225319 + t * (-0.00157565 + tail)))) / sqrt(x);
}

// M of variance `v`, the eye's inclination moved by a lobe's shift of theta_i + theta_r.
fn longitudinal(v: f32, d: Directions, shift: f32) -> f32 {
    let s = sin(shift);
    let c = cos(shift);
    let sin_r = d.sin_theta_r * c - d.cos_theta_r * s;
    let cos_r = abs(d.cos_theta_r * c + d.sin_theta_r * s);
    let a = d.cos_theta_i * cos_r / v;
    let b = (d.cos_theta_i * cos_r - d.sin_theta_i * sin_r - 1.0) / v;
    return i0e(a) * exp(b) / (v * (1.0 - exp(-2.0 / v)));
}
