//! Kajiya and Kay 1989 as printed, and the half-vector form of Chen 2014 (003, section 3.4): diffuse by the sine of the angle
//! between tangent and light, one white highlight, nothing normalised, nothing shifted, light on every side.
//!
//! - 1989: cos^p of the angle between the eye and the mirror cone. With theta from the plane across the fibre it is
//!   cos(theta_i + theta_r); in the paper's vectors, which both point away from the fibre, sin(t, l) sin(t, e) - (t.l)(t.e),
//!   often misprinted with a plus: that lights the eye on the light's own side of the fibre.
//! - Half vector: sin^s(T, H) = (1 - (T.H)^2)^(s / 2), H halfway between light and eye. For light and eye in a plane with the
//!   tangent it is cos^s of half the angle above, so that four times the exponent looks alike; beside that plane it is not.
//!
//! Twins of `shaders/wgsl/scatter_kajiya_kay_1989.wgsl` and `scatter_kajiya_kay_half.wgsl`.

use glam::Vec3;

use super::fibre::Fibre;
use super::{Directions, volume};

/// L / E of one fibre, mirror cone.
pub fn scatter(fibre: &Fibre, d: &Directions) -> Vec3 {
    let cos_to_cone = d.cos_theta_i * d.cos_theta_r - d.sin_theta_i * d.sin_theta_r;
    sum(fibre, d, cos_to_cone.max(0.0).powf(fibre.kk_exponent))
}

/// L / E of one fibre, half vector.
pub fn scatter_half(fibre: &Fibre, d: &Directions) -> Vec3 {
    let light_dot_eye = d.cos_theta_i * d.cos_theta_r * d.cos_phi + d.sin_theta_i * d.sin_theta_r;
    let t_dot_h = (d.sin_theta_i + d.sin_theta_r) / (2.0 + 2.0 * light_dot_eye).max(1e-6).sqrt();
    sum(fibre, d, (1.0 - t_dot_h * t_dot_h).max(0.0).powf(0.5 * fibre.kk_exponent))
}

/// Diffuse in the hair's colour, as bright as a card of it; the highlight is at its peak a white card.
fn sum(fibre: &Fibre, d: &Directions, highlight: f32) -> Vec3 {
    let diffuse = fibre.kk_diffuse * volume::volume(fibre).albedo * d.cos_theta_i;
    (diffuse + fibre.weight[0] * fibre.kk_specular * highlight) * std::f32::consts::FRAC_1_PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::Look;

    #[test]
    fn the_highlight_is_on_the_mirror_cone_in_both_forms() {
        let mut look = Look::default();
        look.kajiya_kay.diffuse = 0.0;
        let fibre = Fibre::new(&HairMaterial::default(), &look);
        let to_light = Vec3::new(0.5, 0.0, 1.0).normalize();
        for form in [scatter, scatter_half] {
            let l = |x: f32| form(&fibre, &Directions::new(Vec3::X, to_light, Vec3::new(x, 0.0, 1.0).normalize())).x;
            let peak = look.kajiya_kay.specular * std::f32::consts::FRAC_1_PI;
            assert!((l(-0.5) - peak).abs() < 1e-5, "{}", l(-0.5));
            assert!(l(-0.2) < l(-0.5) && l(-0.8) < l(-0.5) && l(0.5) < 0.1 * peak);
        }
    }

    #[test]
    fn four_times_the_exponent_makes_the_half_vector_look_alike_in_the_plane_of_the_tangent() {
        let with = |exponent: f32| {
            let mut look = Look::default();
            (look.kajiya_kay.diffuse, look.kajiya_kay.exponent) = (0.0, exponent);
            Fibre::new(&HairMaterial::default(), &look)
        };
        for x in [-0.7f32, -0.5, -0.4, -0.3] {
            let d = Directions::new(Vec3::X, Vec3::new(0.5, 0.0, 1.0).normalize(), Vec3::new(x, 0.0, 1.0).normalize());
            let (cone, half) = (scatter(&with(40.0), &d).x, scatter_half(&with(160.0), &d).x);
            assert!((cone / half - 1.0).abs() < 0.03, "{x}: {cone} {half}");
        }
    }
}
