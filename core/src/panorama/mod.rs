//! Light from all around as a picture: an equirectangular panorama of linear Rec. 709 radiance.
//!
//! Its middle is what the nose points at (+Z), its upper edge is above (+Y), and it is as one sees it who stands inside: +X,
//! the model's left, lies left of the middle. [`embedded`] makes the studio's own; [`read`] reads `.hdr` and `.exr`.
//!
//! A document keeps a panorama that was loaded at no more than [`Panorama::MOST_WIDTH`] texels across, and the path of the
//! file: light on hair and the blurred background ask for no more, and the file itself stays where it is.

pub mod embedded;
pub mod read;

use std::f32::consts::{PI, TAU};
use std::path::PathBuf;

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// A picture of radiance over all directions.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Panorama {
    /// The file that it was read from; empty for one that the studio made.
    pub path: PathBuf,
    /// Texels across and down of that file.
    pub file_size: [u32; 2],
    pub width: u32,
    pub height: u32,
    /// Three numbers a texel, row by row from the top: linear Rec. 709 radiance, finite, 0 or more.
    pub texels: Vec<f32>,
}

impl Panorama {
    /// The widest that is kept, in texels.
    pub const MOST_WIDTH: u32 = 1024;

    /// Evaluate `radiance` over all directions.
    pub fn from_fn(width: u32, height: u32, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let n_fine = 3;
        let mut texels = Vec::with_capacity(3 * (width * height) as usize);
        for row in 0..height {
            for column in 0..width {
                // Small sources fall between the middles of texels: each is the mean of some places.
                let mut sum = Vec3::ZERO;
                for k in 0..n_fine * n_fine {
                    let at = |cell: u32, k: u32, n: u32| (cell as f32 + (k as f32 + 0.5) / n_fine as f32) / n as f32;
                    sum += radiance(direction_of([at(column, k % n_fine, width), at(row, k / n_fine, height)]));
                }
                texels.extend((sum / (n_fine * n_fine) as f32).to_array());
            }
        }
        Self { path: PathBuf::new(), file_size: [0; 2], width, height, texels }
    }

    /// Whether there are as many texels as the size says, of light; the problem in words.
    pub fn check(&self) -> Result<(), String> {
        let Self { width, height, texels, .. } = self;
        if *width == 0 || *height == 0 || texels.len() as u128 != 3 * u128::from(*width) * u128::from(*height) {
            return Err(format!("{} numbers are no picture of {width} x {height}", texels.len()));
        }
        match texels.iter().find(|value| !(value.is_finite() && **value >= 0.0)) {
            Some(value) => Err(format!("{value} is no amount of light")),
            None => Ok(()),
        }
    }

    pub fn texel(&self, column: u32, row: u32) -> Vec3 {
        let at = 3 * (row as usize * self.width as usize + column as usize);
        Vec3::from_slice(&self.texels[at..at + 3])
    }

    /// Radiance of the texel that a direction falls into.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [u, v] = place_of(direction);
        let cell = |x: f32, n: u32| ((x * n as f32) as u32).min(n - 1);
        self.texel(cell(u, self.width), cell(v, self.height))
    }

    /// Call `visit` with each texel's direction, its solid angle (steradian) and its radiance.
    pub fn each_texel(&self, mut visit: impl FnMut(Vec3, f32, Vec3)) {
        for row in 0..self.height {
            let edge = |row: u32| (PI * (0.5 - row as f32 / self.height as f32)).sin();
            let solid_angle = TAU / self.width as f32 * (edge(row) - edge(row + 1));
            for column in 0..self.width {
                let place = [(column as f32 + 0.5) / self.width as f32, (row as f32 + 0.5) / self.height as f32];
                visit(direction_of(place), solid_angle, self.texel(column, row));
            }
        }
    }

    /// Mean luminance over the sphere (Rec. 709 weights).
    pub fn mean_luminance(&self) -> f32 {
        let mut sum = 0.0;
        self.each_texel(|_, solid_angle, l| sum += f64::from(solid_angle * l.dot(LUMINANCE)));
        (sum / (4.0 * std::f64::consts::PI)) as f32
    }

    /// The same light in at most `most_width` texels across, each the mean of those that it covers.
    pub fn reduced(self, most_width: u32) -> Self {
        if self.width <= most_width {
            return self;
        }
        let (width, height) = (most_width, (most_width / 2).min(self.height));
        let across = averaged(&self.texels, self.width as usize, self.height as usize, width as usize, 3);
        // Rows as columns: the second pass averages down.
        let row_len = 3 * width as usize;
        let texels = averaged(&across, self.height as usize, 1, height as usize, row_len);
        Self { width, height, texels, ..self }
    }
}

/// Rec. 709.
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Means over equal parts of `n` cells of `size` numbers each, in each of `n_rows`: `n_parts` cells a row.
fn averaged(cells: &[f32], n: usize, n_rows: usize, n_parts: usize, size: usize) -> Vec<f32> {
    let mut means = vec![0.0; n_rows * n_parts * size];
    let per_part = n as f64 / n_parts as f64;
    for row in 0..n_rows {
        for part in 0..n_parts {
            let (from, to) = (part as f64 * per_part, (part + 1) as f64 * per_part);
            let mean = &mut means[(row * n_parts + part) * size..][..size];
            for cell in from as usize..(to.ceil() as usize).min(n) {
                let covered = (to.min(cell as f64 + 1.0) - from.max(cell as f64)) / per_part;
                let cell = &cells[(row * n + cell) * size..][..size];
                for (mean, value) in mean.iter_mut().zip(cell) {
                    *mean += covered as f32 * value;
                }
            }
        }
    }
    means
}

/// The direction of a place of the picture, 0-1 from its upper left.
pub fn direction_of([u, v]: [f32; 2]) -> Vec3 {
    let (azimuth, elevation) = (TAU * (0.5 - u), PI * (0.5 - v));
    Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos())
}

/// The place of a unit direction in the picture. Twin of `panorama_place` in `background_environment.wgsl`.
pub fn place_of(direction: Vec3) -> [f32; 2] {
    let azimuth = direction.x.atan2(direction.z);
    [(0.5 - azimuth / TAU).clamp(0.0, 1.0), 0.5 - direction.y.clamp(-1.0, 1.0).asin() / PI]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_directions_are_each_other_s_inverse_and_left_is_left() {
        for place in [[0.1, 0.2], [0.5, 0.5], [0.9, 0.7], [0.51, 0.03]] {
            let back = place_of(direction_of(place));
            assert!((back[0] - place[0]).abs() < 1e-5 && (back[1] - place[1]).abs() < 1e-5, "{place:?} {back:?}");
        }
        assert!(direction_of([0.5, 0.5]).distance(Vec3::Z) < 1e-6);
        // Who stands inside and looks along +Z with +Y up has +X on the left.
        assert!(direction_of([0.25, 0.5]).distance(Vec3::X) < 1e-6);
    }

    #[test]
    fn a_smaller_picture_holds_the_same_light() {
        let fine = Panorama::from_fn(300, 150, |d| Vec3::new(d.x * d.x, 1.0 + d.y, 0.3));
        let mean = fine.mean_luminance();
        let small = fine.clone().reduced(64);
        assert_eq!((small.width, small.height, small.texels.len()), (64, 32, 3 * 64 * 32));
        assert!((small.mean_luminance() / mean - 1.0).abs() < 2e-3, "{} {mean}", small.mean_luminance());
        let at = Vec3::new(0.6, 0.64, -0.48);
        assert!(small.radiance(at).distance(fine.radiance(at)) < 0.08);
        assert_eq!(fine.clone().reduced(1024), fine);
    }
}
