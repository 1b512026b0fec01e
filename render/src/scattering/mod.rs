//! How one fibre scatters light, and what a whole head of such fibres makes of it.
//!
//! **Convention.** A fibre of diameter D under irradiance E (measured across the light's direction) shows, averaged
//! over its width, the radiance
//!
//! ```text
//! L(omega_r) = S(omega_i, omega_r) cos(theta_i) E
//! ```
//!
//! with theta the inclination from the plane across the fibre, positive towards the tip, and phi the azimuth between
//! light and eye (0: both on one side). So a smooth fibre that absorbs nothing has S = N(phi) delta(theta_i + theta_r) /
//! cos^2(theta), where N integrates to 1 over the circle, and under a constant environment it shows the
//! environment's own radiance.
//!
//! Every function has a twin of the same name in `shaders/wgsl/scatter_*.wgsl`; the parity test is at the end.
//! - [`fibre`]: the material as the formulas want it, made once a frame on the CPU;
//! - [`marschner`]: R, TT, TRT in closed form; [`marschner_2003`]: the smooth cylinder with its caustics;
//! - [`deon`], [`chiang`]: rough cylinders that keep energy; [`longitudinal`]: their M, [`azimuthal`]: their N;
//! - [`kajiya_kay`]: diffuse and two highlights; [`kajiya_kay_1989`]: as printed, and with the half vector;
//! - [`cylinder`]: what a ray does in a fibre; [`table`], [`tables`]: what is baked, on the CPU and on the GPU;
//! - [`volume`]: two-stream theory of many fibres: colour of thick hair and how light decays in it;
//! - [`multiple`]: the fake normal.

pub mod azimuthal;
pub mod chiang;
pub mod cylinder;
pub mod deon;
pub mod fibre;
pub mod kajiya_kay;
pub mod kajiya_kay_1989;
#[cfg(test)]
mod laws;
pub mod longitudinal;
pub mod marschner;
pub mod marschner_2003;
pub mod multiple;
#[cfg(test)]
mod parity;
pub mod table;
pub mod tables;
pub mod volume;

use glam::Vec3;

pub use fibre::Fibre;

/// Where light and eye are as a fibre sees them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Directions {
    pub sin_theta_i: f32,
    pub cos_theta_i: f32,
    pub sin_theta_r: f32,
    pub cos_theta_r: f32,
    /// Cosine of the azimuth between light and eye.
    pub cos_phi: f32,
    /// (theta_i + theta_r) / 2, radians.
    pub theta_h: f32,
    /// Cosine of (theta_r - theta_i) / 2.
    pub cos_theta_d: f32,
    /// Sine of the azimuth from the eye to the light, growing against `h`.
    pub sin_phi: f32,
    /// Place across the fibre as the eye sees it, -1 to 1 in radii, growing along cross(tangent, to_eye); [`NO_OFFSET`]:
    /// the average over the width.
    pub h: f32,
}

/// An offset across the fibre that means "averaged over its width": the far field.
pub const NO_OFFSET: f32 = 2.0;

impl Directions {
    /// The far field. `tangent` points to the tip; `to_light` and `to_eye` away from the fibre. All of unit length.
    pub fn new(tangent: Vec3, to_light: Vec3, to_eye: Vec3) -> Self {
        let sin_theta_i = to_light.dot(tangent).clamp(-1.0, 1.0);
        let sin_theta_r = to_eye.dot(tangent).clamp(-1.0, 1.0);
        // Nobody sees along a fibre: 1e-3 keeps what follows finite.
        let cos_theta_i = (1.0 - sin_theta_i * sin_theta_i).max(1e-6).sqrt();
        let cos_theta_r = (1.0 - sin_theta_r * sin_theta_r).max(1e-6).sqrt();
        let across_i = to_light - tangent * sin_theta_i;
        let across_r = to_eye - tangent * sin_theta_r;
        let cos_phi = (across_i.dot(across_r) / (cos_theta_i * cos_theta_r)).clamp(-1.0, 1.0);
        let theta_h = ((sin_theta_i + sin_theta_r) / (cos_theta_i + cos_theta_r)).atan();
        let sin_phi = (across_i.dot(across_r.cross(tangent)) / (cos_theta_i * cos_theta_r)).clamp(-1.0, 1.0);
        let cos_difference = cos_theta_i * cos_theta_r + sin_theta_i * sin_theta_r;
        let cos_theta_d = (0.5 + 0.5 * cos_difference).max(1e-6).sqrt();
        Self {
            sin_theta_i,
            cos_theta_i,
            sin_theta_r,
            cos_theta_r,
            cos_phi,
            theta_h,
            cos_theta_d,
            sin_phi,
            h: NO_OFFSET,
        }
    }
}
