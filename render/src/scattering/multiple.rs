//! Light that has met several fibres: a wrapped diffuse term from a fake normal, its hue deepening with depth.
//!
//! Karis 2016 takes the part of the view vector across the fibre for a normal, wraps the cosine fully, and tints by
//! colour^(1 - shadow). Here the strength is what two-stream theory ([`super::volume`]) says a thick heap returns
//! beyond single scattering, and the tint is its decay per channel, exp(-K tau): the same deepening of the hue, but
//! from the depth in the hair instead of from a shadow that is almost binary.

use glam::Vec3;

use super::fibre::Fibre;
use super::volume::Volume;

/// Least decay: a head of hair is finite and light leaks out sideways even where nothing is absorbed. Looked at.
pub const LEAK: f32 = 0.15;

/// L / E of the hair around a fibre at optical depth `tau` from the light.
pub fn multiple(fibre: &Fibre, volume: &Volume, tangent: Vec3, to_light: Vec3, to_eye: Vec3, tau: f32) -> Vec3 {
    let across = to_eye - tangent * to_eye.dot(tangent);
    let normal = across / across.length().max(1e-3);
    // Fully wrapped: (n.l + 1) / (1 + 1)^2 keeps the integral over all directions.
    let wrapped = 0.25 * (normal.dot(to_light) + 1.0);
    let beyond_single = (volume.albedo - 0.5 * volume.back).max(Vec3::ZERO);
    let decay = (volume.decay * volume.decay + Vec3::splat(LEAK * LEAK)).map(f32::sqrt);
    let through = (decay * -tau).exp();
    fibre.multiple_weight * std::f32::consts::FRAC_1_PI * wrapped * beyond_single * through
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::volume::volume;
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::Look;

    #[test]
    fn depth_darkens_without_black_and_deepens_the_hue() {
        let material = HairMaterial { eumelanin: 0.3, pheomelanin: 0.0, ..HairMaterial::default() };
        let fibre = Fibre::new(&material, &Look::default());
        let volume = volume(&fibre);
        let at = |tau| multiple(&fibre, &volume, Vec3::X, Vec3::Z, Vec3::Z, tau);
        let (outside, inside) = (at(0.0), at(3.0));
        assert!(inside.x < outside.x && inside.x > 0.1 * outside.x, "{outside} {inside}");
        // exp(-3) is what single scattering keeps.
        assert!(inside.x > 2.0 * (-3.0f32).exp() * outside.x);
        assert!(inside.x / inside.z > 1.1 * outside.x / outside.z, "{outside} {inside}");
    }
}
