//! What a fibre in the hair shows of an environment. Twins of `shade_environment_*.wgsl`.
//!
//! **Where light gets in.** [`Open`]: the mean share, and towards where it is open. Four probes ask the chosen shadow
//! technique, in directions that balance, and their answers are fitted by a constant and a cosine. Shadows of every direction
//! were rejected: a map each; and so was one share for all directions: hair in front of the head would be lit through it.
//!
//! **Harmonics.** A constant environment in thick hair shows its radiance times the colour of thick hair ([`Volume`]). One
//! that is not constant shows in its place a mean of the radiance: of single scattering, weighted with what the fibre
//! scatters towards the eye from each direction,
//!
//! ```text
//! <L> = integral of S(omega, omega_r) L(omega) V(omega) d(omega) / integral of S d(omega)
//! ```
//!
//! for each of red, green and blue, so that a white highlight and a coloured one see each its own part of the environment;
//! of light that was scattered more than once, the irradiance. The integral runs over a fan of directions about the mirror
//! cone, where every model's lobes lie: nine inclinations so far apart that the widest lobe is in, two more in what is left
//! on either side, and twelve azimuths. The chosen model of scattering is asked for each, whatever it is.
//!
//! **Karis.** His one sample: irradiance where the fibre faces the eye, as if it all came from there, with TT left out and
//! the lobes widened.

use std::f32::consts::PI;

use glam::Vec3;

use super::harmonics::{N_COEFFICIENTS, irradiance, radiance};
use crate::scattering::volume::Volume;
use crate::scattering::{Directions, Fibre};

/// How much of the environment gets to a place, and from where: from a direction, `share` (1 + towards . direction).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Open {
    pub share: Vec3,
    /// No longer than 1.
    pub towards: Vec3,
}

impl Open {
    /// Nothing is in the way.
    pub const WIDE: Self = Self { share: Vec3::ONE, towards: Vec3::ZERO };
}

/// An environment as the shaders have it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lights {
    /// [`super::Harmonics::tapered`] and [`super::Harmonics::cosine_weighted`].
    pub radiance: [Vec3; N_COEFFICIENTS],
    pub irradiance: [Vec3; 9],
}

/// Inclinations on either side of the mirror cone where lobes are, and in what is left; azimuths from the eye's side to the
/// other.
const N_THETA: i32 = 4;
const N_REST: i32 = 2;
const N_PHI: i32 = 6;
/// Of a lobe's deviations of theta_i, how many are looked at.
const REACH: f32 = 1.3;
const MOST_STEP: f32 = 0.35;
/// Where a fibre scatters as little as this, it shows what is diffuse.
const LEAST: f32 = 1e-4;
/// Added to the longitudinal roughness, radians (Karis 2016).
const AREA: f32 = 0.2;

/// Across the fibre, towards the eye.
fn facing(tangent: Vec3, to_eye: Vec3) -> Vec3 {
    let across = to_eye - tangent * to_eye.dot(tangent);
    across / across.length().max(1e-3)
}

/// Call `visit` with each direction of the fan on one side, its mirror image on the other, and its weight: cos(theta_i), halved
/// where both are one.
fn each_of_fan(fibre: &Fibre, tangent: Vec3, to_eye: Vec3, mut visit: impl FnMut(Vec3, Vec3, f32)) {
    let sin_theta_r = to_eye.dot(tangent).clamp(-1.0, 1.0);
    let normal = facing(tangent, to_eye);
    let side = tangent.cross(normal);
    let tilt = fibre.alpha.iter().fold(0.0f32, |most, alpha| most.max(alpha.abs()));
    let beta = fibre.beta.iter().fold(0.0f32, |most, beta| most.max(*beta));
    let step = ((2.0 * tilt + REACH * 2.0 * beta) / N_THETA as f32).min(MOST_STEP);
    let theta_r = sin_theta_r.asin();
    for k in -N_THETA - N_REST..=N_THETA + N_REST {
        let (mut theta_i, mut share) = (k as f32 * step - theta_r, 1.0);
        if k.abs() > N_THETA {
            let outwards = k.signum() as f32;
            let edge = outwards * (N_THETA as f32 + 0.5) * step - theta_r;
            let cell = (0.5 * PI - outwards * edge).max(0.0) / N_REST as f32;
            theta_i = edge + outwards * cell * ((k.abs() - N_THETA) as f32 - 0.5);
            share = cell / step;
        }
        let cos_theta_i = theta_i.cos();
        if cos_theta_i <= 0.0 || theta_i.abs() > 0.5 * PI {
            continue;
        }
        for j in 0..=N_PHI {
            let phi = PI * j as f32 / N_PHI as f32;
            let before = tangent * theta_i.sin() + normal * (cos_theta_i * phi.cos());
            let aside = side * (cos_theta_i * phi.sin());
            let weight = share * cos_theta_i * if j == 0 || j == N_PHI { 0.5 } else { 1.0 };
            visit(before + aside, before - aside, weight);
        }
    }
}

/// Mean radiance of single scattering; `diffuse` where there is next to none. `scatter` is the model's L / E.
pub fn single(
    fibre: &Fibre,
    tangent: Vec3,
    to_eye: Vec3,
    scatter: impl Fn(&Directions) -> Vec3,
    seen: impl Fn(Vec3) -> Vec3,
    diffuse: Vec3,
) -> Vec3 {
    let (mut scattered, mut lit) = (Vec3::ZERO, Vec3::ZERO);
    each_of_fan(fibre, tangent, to_eye, |a, b, weight| {
        let f = weight * scatter(&Directions::new(tangent, a, to_eye));
        scattered += f;
        lit += f * 0.5 * (seen(a) + seen(b));
    });
    (lit + LEAST * diffuse) / (scattered + LEAST)
}

/// The slot's `harmonics`.
pub fn harmonics(
    fibre: &Fibre,
    heap: &Volume,
    (tangent, to_eye): (Vec3, Vec3),
    open: &Open,
    lights: &Lights,
    scatter: impl Fn(&Directions) -> Vec3,
) -> Vec3 {
    let normal = facing(tangent, to_eye);
    let diffuse = irradiance(&lights.irradiance, normal) * (1.0 + 2.0 / 3.0 * open.towards.dot(normal));
    let seen = |d: Vec3| radiance(&lights.radiance, d) * (1.0 + open.towards.dot(d));
    let single = single(fibre, tangent, to_eye, scatter, seen, diffuse);
    let single_share = heap.back / (2.0 - heap.front) / heap.albedo.max(Vec3::splat(1e-4));
    let single_share = single_share.clamp(Vec3::ZERO, Vec3::ONE);
    heap.albedo * open.share * (diffuse + single_share * (single - diffuse))
}

/// The slot's `karis`. `scatter` and `multiple` are of the fibre that they are given.
pub fn karis(
    fibre: &Fibre,
    (tangent, to_eye): (Vec3, Vec3),
    open: &Open,
    lights: &Lights,
    scatter: impl Fn(&Fibre, &Directions) -> Vec3,
    multiple: impl Fn(Vec3) -> Vec3,
) -> Vec3 {
    let normal = facing(tangent, to_eye);
    let mut soft = *fibre;
    soft.beta = soft.beta.map(|beta| beta + AREA);
    soft.weight[0] *= (normal.dot(to_eye) + 1.0).min(1.0);
    soft.weight[1] = 0.0;
    let sent = scatter(&soft, &Directions::new(tangent, normal, to_eye)) + multiple(normal);
    let share = open.share * (1.0 + 2.0 / 3.0 * open.towards.dot(normal));
    sent * PI * irradiance(&lights.irradiance, normal) * share
}

#[cfg(test)]
#[path = "lit_tests.rs"]
mod tests;
