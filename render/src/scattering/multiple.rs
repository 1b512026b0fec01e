//! Light that has met several fibres: a wrapped diffuse term from a fake normal, its hue deepening with depth.
//!
//! Karis 2016 takes the part of the view vector across the fibre for a normal, wraps the cosine fully, and tints by
//! colour^(1 - shadow). Here the strength is what two-stream theory ([`super::volume`]) says a thick heap returns
//! beyond single scattering, and the tint is its decay per channel, exp(-K tau): the same deepening of the hue, but
//! from the depth in the hair instead of from a shadow that is almost binary.

use glam::Vec3;

use super::fibre::Fibre;
use super::volume::Volume;

/// Fibres after which the spread of forward scattered light no longer grows: nothing is left to be seen of it.
const MAX_SPREADING: f32 = 8.0;

/// Share of a light that arrives for single scattering at optical depth `tau`: what met no fibre, exp(-tau), and what
/// fibres sent on. The fibres on the way are Poisson distributed, so a_f^n averages to exp(-(1 - a_f) tau). Karis uses
/// the shadow as it is; with that, light hair is dark inside (Zinke et al. 2008, fig. 1).
pub fn through(fibre: &Fibre, volume: &Volume, tau: f32) -> Vec3 {
    let kept = (-tau).exp();
    let sent_on = ((volume.front - Vec3::ONE) * tau).exp() - Vec3::splat(kept);
    Vec3::splat(kept) + fibre.multiple_weight.min(1.0) * sent_on
}

/// The fibre as light sees it that was sent on by others: every crossing spreads it by TT's deviation (Zinke et al. 2008,
/// eq. 12).
#[must_use]
pub fn spread(fibre: &Fibre, tau: f32) -> Fibre {
    let added = tau.min(MAX_SPREADING) * fibre.beta[1] * fibre.beta[1];
    Fibre { beta: fibre.beta.map(|beta| (beta * beta + added).sqrt()), ..*fibre }
}

/// Least decay: a head of hair is finite, light leaks out sideways and the skin below absorbs, even where hair does not.
/// Fitted like `GAIN`.
pub const LEAK: f32 = 0.35;

/// What two streams leave out: fibres are not parallel, and light that goes along them meets brighter ones. Fitted to
/// path traced pictures of a full groom, brown and blond.
const GAIN: f32 = 2.2;

/// L / E of the hair around a fibre at optical depth `tau` from the light.
pub fn multiple(fibre: &Fibre, volume: &Volume, tangent: Vec3, to_light: Vec3, to_eye: Vec3, tau: f32) -> Vec3 {
    let across = to_eye - tangent * to_eye.dot(tangent);
    let normal = across / across.length().max(1e-3);
    // Fully wrapped: (n.l + 1) / (1 + 1)^2 keeps the integral over all directions.
    let wrapped = GAIN * 0.25 * (normal.dot(to_light) + 1.0);
    // Single scattering of what `through` lets in, seen through what is in front of it, returns a_b / (2 - a_f).
    let beyond_single = (volume.albedo - volume.back / (Vec3::splat(2.0) - volume.front)).max(Vec3::ZERO);
    let decay = (volume.decay * volume.decay + Vec3::splat(LEAK * LEAK)).map(f32::sqrt);
    fibre.multiple_weight * std::f32::consts::FRAC_1_PI * wrapped * beyond_single * (decay * -tau).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scattering::volume::volume;
    use lorelei_core::groom::HairMaterial;
    use lorelei_core::look::Look;

    #[test]
    fn light_hair_sends_on_what_black_hair_keeps() {
        let through_3 = |eumelanin: f32| {
            let material = HairMaterial { eumelanin, pheomelanin: 0.0, ..HairMaterial::default() };
            let fibre = Fibre::new(&material, &Look::default());
            through(&fibre, &volume(&fibre), 3.0).x
        };
        let unscattered = (-3.0f32).exp();
        assert!(through_3(0.1) > 6.0 * unscattered && through_3(0.1) < 1.0);
        assert!(through_3(10.0) < 1.3 * unscattered && through_3(10.0) > unscattered);
    }

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
