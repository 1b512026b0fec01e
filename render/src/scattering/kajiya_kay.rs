//! Kajiya and Kay 1989: a diffuse term from the angle to the tangent and a highlight on the mirror cone.
//!
//! Kept: sin(tangent, light) for the diffuse part (here cos(theta_i)) and cos^p of the angle to the mirror cone, which in
//! terms of inclinations is cos(theta_i + theta_r); with both vectors pointing away from the fibre the product of
//! the tangent's dot products enters with a minus, which many listings lose. Added: the highlight is normalised
//! so that the exponent changes its width and not its power, and there is a second one, shifted and in the
//! hair's colour, as Marschner et al. 2003 found.

use glam::Vec3;

use super::fibre::Fibre;
use super::{Directions, volume};

/// L / E of one fibre. Diffuse 1 shows a heap of white fibres as a white card.
pub fn scatter(fibre: &Fibre, d: &Directions) -> Vec3 {
    let colour = volume::volume(fibre).albedo;
    let diffuse = fibre.kk_diffuse * std::f32::consts::FRAC_1_PI * colour;
    let white = highlight(fibre.kk_exponent, 2.0 * (d.theta_h - fibre.alpha[0]));
    let coloured = highlight(0.5 * fibre.kk_exponent, 2.0 * (d.theta_h - fibre.alpha[2]));
    // Light does not get through: the highlights fade as the light goes behind the fibre.
    let facing = 0.5 + 0.5 * d.cos_phi;
    let specular =
        fibre.kk_specular * facing * (fibre.weight[0] * Vec3::splat(white) + fibre.weight[2] * coloured * colour);
    (diffuse + specular) * d.cos_theta_i
}

/// cos^p over its integral along and around the fibre.
fn highlight(exponent: f32, angle: f32) -> f32 {
    (exponent / std::f32::consts::TAU).sqrt() / std::f32::consts::TAU * angle.cos().max(0.0).powf(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::Look;

    #[test]
    fn diffuse_of_white_hair_is_a_white_card_and_falls_with_the_angle_to_the_tangent() {
        let mut look = Look::default();
        (look.kajiya_kay.diffuse, look.kajiya_kay.specular) = (1.0, 0.0);
        let material = HairMaterial { eumelanin: 0.0, pheomelanin: 0.0, ..HairMaterial::default() };
        let fibre = Fibre::new(&material, &look);
        let l = |to_light: Vec3| scatter(&fibre, &Directions::new(Vec3::X, to_light.normalize(), Vec3::Z)).x;
        assert!((l(Vec3::Z) * std::f32::consts::PI - 1.0).abs() < 1e-3);
        assert!((l(Vec3::new(1.0, 0.0, 1.0)) / l(Vec3::Z) - 0.5f32.sqrt()).abs() < 1e-3);
    }

    #[test]
    fn the_highlight_is_on_the_mirror_cone() {
        let material = HairMaterial { tilt_deg: 0.0, ..HairMaterial::default() };
        let fibre = Fibre::new(&material, &Look::default());
        let to_light = Vec3::new(0.5, 0.0, 1.0).normalize();
        let l = |x: f32| scatter(&fibre, &Directions::new(Vec3::X, to_light, Vec3::new(x, 0.0, 1.0).normalize())).x;
        assert!(l(-0.5) > l(-0.2) && l(-0.5) > l(-0.8) && l(-0.5) > 3.0 * l(0.5));
    }

    #[test]
    fn exponent_keeps_the_power_of_the_highlight() {
        for exponent in [10.0, 40.0, 200.0] {
            let step = 0.001;
            let total: f32 = (-1570..=1570).map(|i| highlight(exponent, step * i as f32) * step).sum();
            assert!((total * std::f32::consts::TAU - 1.0).abs() < 0.03, "{exponent}: {total}");
        }
    }
}
