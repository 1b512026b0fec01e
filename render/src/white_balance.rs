//! White balance: the matrix that makes a light of a colour temperature look white.
//!
//! Colours are adapted from the white that the temperature and the tint name to the white of 6500 K, both on the curve
//! of black bodies, so that the neutral setting is no change at all. Scaling R, G and B was rejected: saturated colours
//! would change in hue.

use glam::{Mat3, Vec3};
use lorelei_core::look::WhiteBalance;

/// XYZ from linear Rec. 709 (IEC 61966-2-1).
const XYZ_FROM_RGB: Mat3 = Mat3::from_cols(
    Vec3::new(0.412_456_4, 0.212_672_9, 0.019_333_9),
    Vec3::new(0.357_576_1, 0.715_152_2, 0.119_192),
    Vec3::new(0.180_437_5, 0.072_175, 0.950_304_1),
);
/// Cone responses from XYZ (Lam 1985, "Bradford").
const CONES_FROM_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(0.8951, -0.7502, 0.0389),
    Vec3::new(0.2664, 1.7135, -0.0685),
    Vec3::new(-0.1614, 0.0367, 1.0296),
);
/// Distance from the black bodies at full tint, in CIE 1960 u, v: a fluorescent lamp's.
const MOST_TINT: f32 = 0.02;

/// Black body of a temperature in kelvin as CIE 1960 u, v, within 9e-5 from 1000 to 15 000 K (Krystek 1985).
fn black_body_uv(kelvin: f32) -> [f32; 2] {
    let t = f64::from(kelvin);
    let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
        / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
    let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
        / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
    [u as f32, v as f32]
}

/// XYZ with Y 1 of the light that a setting names.
pub fn white_xyz(white: WhiteBalance) -> Vec3 {
    let at = black_body_uv(white.temperature_k);
    // Compute the way off the curve: across it, towards green.
    let [before, after] = [0.99, 1.01].map(|scale| black_body_uv(scale * white.temperature_k));
    let (du, dv) = (after[0] - before[0], after[1] - before[1]);
    let off = MOST_TINT * white.tint / du.hypot(dv).max(1e-9);
    let (u, v) = (at[0] + off * dv, at[1] - off * du);
    // CIE 1960 u, v to x, y.
    let sum = 2.0 * u - 8.0 * v + 4.0;
    let (x, y) = (3.0 * u / sum, 2.0 * v / sum);
    Vec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Linear Rec. 709 to linear Rec. 709: the light that the setting names becomes white of the same luminance.
pub fn adaptation(white: WhiteBalance) -> Mat3 {
    if white == WhiteBalance::NEUTRAL {
        return Mat3::IDENTITY;
    }
    let cones = |white| CONES_FROM_XYZ * white_xyz(white);
    let gain = cones(WhiteBalance::NEUTRAL) / cones(white).max(Vec3::splat(1e-4));
    let cones_from_rgb = CONES_FROM_XYZ * XYZ_FROM_RGB;
    cones_from_rgb.inverse() * Mat3::from_diagonal(gain) * cones_from_rgb
}

#[cfg(test)]
mod tests {
    use super::*;

    fn balanced(light_xy: [f32; 2], temperature_k: f32, tint: f32) -> Vec3 {
        let [x, y] = light_xy;
        let rgb = XYZ_FROM_RGB.inverse() * Vec3::new(x / y, 1.0, (1.0 - x - y) / y);
        adaptation(WhiteBalance { temperature_k, tint }) * rgb
    }

    /// Largest difference of two channels of a colour, of the largest one.
    fn cast(rgb: Vec3) -> f32 {
        (rgb.max_element() - rgb.min_element()) / rgb.max_element()
    }

    #[test]
    fn known_lamps_become_white_at_their_own_temperature() {
        // CIE illuminants A (tungsten, 2856 K), and black bodies of 4000 and 10 000 K (Wyszecki and Stiles 1982).
        let a = balanced([0.447_57, 0.407_45], 2856.0, 0.0);
        let warm = balanced([0.3804, 0.3767], 4000.0, 0.0);
        let cold = balanced([0.2806, 0.2883], 10_000.0, 0.0);
        // What is left: 6500 K on the curve of black bodies is a little more magenta than D65, 3 % here.
        for (name, rgb) in [("A", a), ("4000 K", warm), ("10 000 K", cold)] {
            assert!(cast(rgb) < 0.07, "{name}: {rgb}");
        }
        assert!(cast(balanced([0.447_57, 0.407_45], 6500.0, 0.0)) > 0.5, "tungsten is orange where nothing is done");
    }

    #[test]
    fn neutral_changes_nothing_and_each_way_is_as_its_label_says() {
        assert_eq!(adaptation(WhiteBalance::NEUTRAL), Mat3::IDENTITY);
        let grey = |temperature_k, tint| adaptation(WhiteBalance { temperature_k, tint }) * Vec3::splat(0.5);
        let (warm, cold) = (grey(9000.0, 0.0), grey(4000.0, 0.0));
        assert!(warm.x > 1.05 * warm.z, "a higher temperature is warmer: {warm}");
        assert!(cold.z > 1.05 * cold.x, "a lower one is colder: {cold}");
        let (magenta, green) = (grey(6500.0, 1.0), grey(6500.0, -1.0));
        assert!(magenta.y < 0.97 * magenta.x.min(magenta.z), "{magenta}");
        assert!(green.y > 1.03 * green.x.max(green.z), "{green}");
        // Smooth through the neutral setting.
        let near = grey(6500.5, 0.0001);
        assert!((near - Vec3::splat(0.5)).abs().max_element() < 1e-3, "{near}");
    }
}
