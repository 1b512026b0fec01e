//! An environment's broad features: its radiance as real spherical harmonics of four bands.
//!
//! The pole is up (+Y) and azimuth 0 is +Z, so that turning the environment mixes only pairs of coefficients, exactly. Four
//! bands hold features of about 45 degrees, which is what hair can show: its longitudinal lobes are 15 to 60 degrees wide and
//! its azimuthal ones wider. Radiance is tapered by Lanczos' window against ringing around a sun; irradiance is not, since
//! the cosine takes the high bands out by itself (Ramamoorthi and Hanrahan 2001).

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use lorelei_core::panorama::Panorama;

/// Coefficients: bands 0 to 3, in each from m = -l (sines) to m = l (cosines).
pub const N_COEFFICIENTS: usize = 16;

/// Of four bands, and of the three that irradiance has.
const N_BANDS: usize = 4;
const N_OF_IRRADIANCE: usize = 9;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonics([Vec3; N_COEFFICIENTS]);

/// The functions at a unit direction, orthonormal over the sphere. Twin of the sums in `environment_harmonics.wgsl`.
pub fn basis(direction: Vec3) -> [f32; N_COEFFICIENTS] {
    let [y, z, x] = direction.to_array();
    [
        0.28209478,
        0.48860252 * y,
        0.48860252 * z,
        0.48860252 * x,
        1.0925485 * x * y,
        1.0925485 * y * z,
        0.31539157 * (3.0 * z * z - 1.0),
        1.0925485 * x * z,
        0.54627424 * (x * x - y * y),
        0.5900436 * y * (3.0 * x * x - y * y),
        2.8906114 * x * y * z,
        0.4570458 * y * (5.0 * z * z - 1.0),
        0.37317634 * z * (5.0 * z * z - 3.0),
        0.4570458 * x * (5.0 * z * z - 1.0),
        1.4453057 * z * (x * x - y * y),
        0.5900436 * x * (x * x - 3.0 * y * y),
    ]
}

fn band_of(idx: usize) -> usize {
    idx.isqrt()
}

impl Harmonics {
    /// The picture's.
    pub fn of(picture: &Panorama) -> Self {
        let mut sums = [DVec3::ZERO; N_COEFFICIENTS];
        picture.each_texel(|direction, solid_angle, radiance| {
            let light = radiance.as_dvec3() * f64::from(solid_angle);
            for (sum, value) in sums.iter_mut().zip(basis(direction)) {
                *sum += light * f64::from(value);
            }
        });
        Self(sums.map(DVec3::as_vec3))
    }

    /// Of the environment turned about the vertical so that what came from azimuth 0 comes from `radians`, and scaled.
    pub fn turned(&self, radians: f32, gain: f32) -> Self {
        let mut turned = self.0;
        for band in 0..N_BANDS {
            let middle = band * band + band;
            for m in 1..=band {
                let (s, c) = (m as f32 * radians).sin_cos();
                let (cosine, sine) = (self.0[middle + m], self.0[middle - m]);
                turned[middle + m] = cosine * c - sine * s;
                turned[middle - m] = cosine * s + sine * c;
            }
        }
        Self(turned.map(|coefficient| gain * coefficient))
    }

    /// For [`radiance`]: each band tapered.
    pub fn tapered(&self) -> [Vec3; N_COEFFICIENTS] {
        std::array::from_fn(|idx| {
            let x = PI * band_of(idx) as f64 / (N_BANDS + 1) as f64;
            let taper = if x == 0.0 { 1.0 } else { x.sin() / x };
            self.0[idx] * taper as f32
        })
    }

    /// For [`irradiance`]: each band times the cosine's coefficient over pi.
    pub fn cosine_weighted(&self) -> [Vec3; N_OF_IRRADIANCE] {
        std::array::from_fn(|idx| self.0[idx] * [1.0, 2.0 / 3.0, 0.25][band_of(idx)])
    }
}

/// Radiance from a unit direction, of tapered coefficients. Twin of `radiance_from`.
pub fn radiance(tapered: &[Vec3; N_COEFFICIENTS], direction: Vec3) -> Vec3 {
    let sum: Vec3 = tapered.iter().zip(basis(direction)).map(|(c, value)| *c * value).sum();
    sum.max(Vec3::ZERO)
}

/// Irradiance over pi of a surface with a unit normal. Twin of `irradiance_at`.
pub fn irradiance(weighted: &[Vec3; N_OF_IRRADIANCE], normal: Vec3) -> Vec3 {
    let sum: Vec3 = weighted.iter().zip(basis(normal)).map(|(c, value)| *c * value).sum();
    sum.max(Vec3::ZERO)
}

#[cfg(test)]
mod tests {
    use lorelei_core::camera::direction_from_deg;
    use lorelei_core::look::{Choice, Surroundings};
    use lorelei_core::panorama::embedded::embedded;

    use super::*;

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..60).map(|k| direction_from_deg(67.0 * k as f32, -85.0 + 2.9 * k as f32))
    }

    #[test]
    fn the_functions_are_orthonormal() {
        let unit = Panorama::from_fn(128, 64, |_| Vec3::ONE);
        let mut products = [[0.0f64; N_COEFFICIENTS]; N_COEFFICIENTS];
        unit.each_texel(|direction, solid_angle, _| {
            let values = basis(direction);
            for (i, row) in products.iter_mut().enumerate() {
                for (j, product) in row.iter_mut().enumerate() {
                    *product += f64::from(solid_angle * values[i] * values[j]);
                }
            }
        });
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product - expected).abs() < 3e-3, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn light_that_is_the_same_all_around_stays_so() {
        let colour = Vec3::new(0.9, 0.5, 2.0);
        let harmonics = Harmonics::of(&Panorama::from_fn(256, 128, |_| colour)).turned(1.1, 0.5);
        for d in directions() {
            for shown in [radiance(&harmonics.tapered(), d), irradiance(&harmonics.cosine_weighted(), d)] {
                assert!((shown / (0.5 * colour) - 1.0).abs().max_element() < 1e-3, "{d}: {shown}");
            }
        }
    }

    #[test]
    fn turning_is_looking_from_elsewhere() {
        for &choice in Surroundings::ALL {
            let Some(picture) = embedded(choice) else { continue };
            let harmonics = Harmonics::of(&picture);
            let turned = harmonics.turned(40f32.to_radians(), 1.0);
            for (azimuth, elevation) in [(0.0, 0.0), (75.0, 30.0), (-160.0, -50.0)] {
                let here = radiance(&turned.tapered(), direction_from_deg(azimuth + 40.0, elevation));
                let there = radiance(&harmonics.tapered(), direction_from_deg(azimuth, elevation));
                assert!((here - there).abs().max_element() < 1e-4 * (1.0 + there.max_element()), "{choice:?}");
            }
        }
    }

    /// Irradiance by every texel, in f64: three bands are within 9 % of any light's (Ramamoorthi and Hanrahan 2001, 3 % on average).
    #[test]
    fn irradiance_is_that_of_the_picture() {
        for &choice in Surroundings::ALL {
            let Some(picture) = embedded(choice) else { continue };
            let weighted = Harmonics::of(&picture).cosine_weighted();
            let (mut worst, mut mean): (f64, f64) = (0.0, 0.0);
            let mut most: f64 = 0.0;
            for normal in directions() {
                let mut exact = DVec3::ZERO;
                picture.each_texel(|d, solid_angle, l| {
                    exact += l.as_dvec3() * f64::from(solid_angle * d.dot(normal).max(0.0)) / PI;
                });
                let error = (irradiance(&weighted, normal).as_dvec3() - exact).abs().max_element();
                most = most.max(exact.max_element());
                (worst, mean) = (worst.max(error), mean + error / 60.0);
            }
            println!("{choice:?}: worst {:.3}, mean {:.3} of the most", worst / most, mean / most);
            assert!(worst < 0.09 * most && mean < 0.03 * most, "{choice:?}: {worst} {mean} of {most}");
        }
    }
}
