//! The last frame's hair, and the exact picture of the very vertices and radiances that it was drawn from: what a drawing
//! technique is measured by. For tests and measurements: both read back from the GPU and wait for it.

use glam::Vec4;
use lorelei_core::camera::Camera;
use lorelei_shaders::GpuError;

use crate::exact::{Backdrop, ExactStrands, composite};
use crate::renderer::Renderer;

/// How far a picture is from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// Root mean square over the pixels in which either picture has hair, linear light and alpha alike.
    pub rmse: f64,
    /// That of 99 of 100 of those pixels is at most this.
    pub p99: f64,
    /// Sum of alpha over the other's.
    pub coverage: f64,
}

impl Apart {
    /// `exact` is the one to be like. Pixels are premultiplied.
    pub fn between(picture: &[[f64; 4]], exact: &[[f64; 4]]) -> Self {
        let error2 = |(a, b): (&[f64; 4], &[f64; 4])| (0..4).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>() / 4.0;
        let has_hair = |(a, b): &(&[f64; 4], &[f64; 4])| a[3] > 0.0 || b[3] > 0.0;
        let mut errors: Vec<f64> = picture.iter().zip(exact).filter(has_hair).map(error2).collect();
        errors.sort_by(f64::total_cmp);
        let n = errors.len().max(1);
        let covered = |picture: &[[f64; 4]]| picture.iter().map(|pixel| pixel[3]).sum::<f64>();
        Self {
            rmse: (errors.iter().sum::<f64>() / n as f64).sqrt(),
            p99: errors.get(errors.len() * 99 / 100).copied().unwrap_or(0.0).sqrt(),
            coverage: covered(picture) / covered(exact).max(1e-300),
        }
    }
}

fn halves(bytes: &[u8]) -> Vec<[f64; 4]> {
    let half = |b: &[u8]| half::f16::from_le_bytes([b[0], b[1]]).to_f64();
    bytes.chunks_exact(8).map(|p| [half(p), half(&p[2..]), half(&p[4..]), half(&p[6..])]).collect()
}

impl Renderer {
    /// Premultiplied linear radiance and alpha of the last submitted frame's hair alone, row by row from the top.
    pub fn read_hair(&self) -> Result<Vec<[f64; 4]>, GpuError> {
        Ok(halves(&self.read_texture(self.targets.hair.texture(), 8)?))
    }

    /// The same hair composited exactly, fragment by fragment, as the last frame's `camera` saw it. Seconds, for many strands.
    pub fn exact_hair(&self, camera: &Camera) -> Result<Vec<[f64; 4]>, GpuError> {
        let strands = self.generator.strands();
        let vertices: Vec<Vec4> = self.gpu.read_buffer(&strands.vertices)?;
        let packed: Vec<[u16; 4]> = self.gpu.read_buffer(self.shade.radiance())?;
        let radiance: Vec<[f32; 4]> =
            packed.iter().map(|vertex| vertex.map(|bits| half::f16::from_bits(bits).to_f32())).collect();
        let layers: Vec<ExactStrands<'_>> = (strands.layers.iter())
            .map(|layer| {
                let from = layer.first_vertex as usize;
                let range = from..from + (layer.n_strands * layer.vertices_per_strand) as usize;
                ExactStrands {
                    vertices: &vertices[range.clone()],
                    vertices_per_strand: layer.vertices_per_strand as usize,
                    radiance: &radiance[range],
                }
            })
            .collect();
        let head: Vec<[f32; 2]> =
            bytemuck::pod_collect_to_vec(&self.read_texture(self.targets.head_depth.texture(), 8)?);
        let (depth, coverage): (Vec<f32>, Vec<f32>) = head.iter().map(|&[depth, coverage]| (depth, coverage)).unzip();
        let size = self.targets.size;
        Ok(composite(
            &layers,
            camera.view_from_world(),
            camera.clip_from_view(size[0] as f32 / size[1] as f32),
            size,
            Backdrop { depth: &depth, coverage: &coverage },
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pixel_of_a_hundred_decides_the_percentile_and_empty_ones_count_nothing() {
        let mut exact = vec![[0.5, 0.5, 0.5, 1.0]; 100];
        exact.extend(vec![[0.0; 4]; 900]);
        let mut picture = exact.clone();
        picture[7] = [0.7, 0.7, 0.7, 1.2];
        let apart = Apart::between(&picture, &exact);
        assert!((apart.rmse - 0.02).abs() < 1e-9 && (apart.p99 - 0.2).abs() < 1e-9, "{apart:?}");
        assert!((apart.coverage - 1.002).abs() < 1e-9);
        assert_eq!(Apart::between(&exact, &exact).p99, 0.0);
    }
}
