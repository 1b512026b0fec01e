//! The numbers of a frame's shadows as shaders read them, and how large its maps can be.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use lorelei_core::look::{BeyondLast, ShadowParams, Shadowing};

use crate::scene::Ball;

/// Most layers of a deep opacity map.
pub const MAX_LAYERS: u32 = 15;

/// Twin of `ShadowParams` in `shadow_map.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct Params {
    resolution: u32,
    n_lights: u32,
    n_parts: u32,
    beyond_last: u32,
    density: f32,
    filter_radius: f32,
    n_taps: u32,
    tap_spacing: f32,
    jitter: f32,
    bias: f32,
    falloff: f32,
    tolerance: f32,
    voxel_corner: [f32; 3],
    voxels_per_cm: f32,
    n_voxels: u32,
    n_steps: u32,
    n_fragments: u32,
    pad: u32,
    layer_starts: [f32; 16],
    layer_rates: [f32; 16],
}

/// Side in texels and number of the maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MapSize {
    pub resolution: u32,
    pub n_lights: u32,
}

impl MapSize {
    pub fn n_texels(self) -> u64 {
        u64::from(self.resolution) * u64::from(self.resolution) * u64::from(self.n_lights)
    }
}

impl Params {
    pub fn new(
        shadowing: Shadowing,
        params: &ShadowParams,
        size: MapSize,
        n_fragments: u64,
        ball: Ball,
        world_from_head: Affine3A,
    ) -> Self {
        let (voxel_corner, voxels_per_cm) = grid(params.n_voxels, ball, world_from_head);
        let layer_starts = layer_starts(params);
        let of_front = [Shadowing::ShadowMap, Shadowing::Exponential].contains(&shadowing);
        Self {
            resolution: size.resolution,
            n_lights: size.n_lights,
            n_parts: n_parts(shadowing, params),
            beyond_last: match params.beyond_last {
                BeyondLast::LastLayer => 0,
                BeyondLast::Ignore => 1,
                BeyondLast::Grow => 2,
            },
            density: params.density,
            filter_radius: params.filter_radius.max(0.0),
            n_taps: if of_front { params.n_pcf_taps } else { params.n_taps }.max(1),
            tap_spacing: params.tap_spacing,
            jitter: if shadowing == Shadowing::Voxels { params.step_jitter } else { params.jitter },
            bias: params.bias,
            falloff: params.falloff,
            tolerance: params.tolerance,
            voxel_corner: voxel_corner.to_array(),
            voxels_per_cm,
            n_voxels: params.n_voxels,
            n_steps: params.n_steps.max(1),
            n_fragments: n_fragments as u32,
            pad: 0,
            layer_starts,
            layer_rates: std::array::from_fn(|k| {
                layer_starts.get(k + 1).map_or(0.0, |end| 1.0 / (end - layer_starts[k]))
            }),
        }
    }
}

/// Layers or slices of a texel.
pub(super) fn n_parts(shadowing: Shadowing, params: &ShadowParams) -> u32 {
    match shadowing {
        Shadowing::DeepOpacity => params.n_layers.clamp(1, MAX_LAYERS),
        // Two share a word.
        Shadowing::OpacityMaps => params.n_slices.clamp(2, 256).next_multiple_of(2),
        Shadowing::Off
        | Shadowing::ShadowMap
        | Shadowing::Exponential
        | Shadowing::Clusters
        | Shadowing::Occupancy
        | Shadowing::DeepShadow
        | Shadowing::Voxels => 1,
    }
}

/// Where each layer of a deep opacity map begins behind the front, centimetres; where the last one ends is the number
/// after it.
pub(super) fn layer_starts(params: &ShadowParams) -> [f32; 16] {
    let mut starts = [0.0; 16];
    for (k, thickness) in params.layer_spacing.thicknesses().take(15).enumerate() {
        starts[k + 1] = starts[k] + params.layer_size * thickness;
    }
    starts
}

/// Lower corner of a cube around the ball and cells a centimetre. It moves by whole cells: shadows do not swim.
fn grid(n_voxels: u32, ball: Ball, world_from_head: Affine3A) -> (Vec3, f32) {
    // A cell at each side for what moving by whole cells leaves over.
    let voxels_per_cm = (n_voxels.max(4) - 2) as f32 / (2.0 * ball.radius);
    let corner = world_from_head.transform_point3(ball.centre) - ball.radius;
    let cell = (corner * voxels_per_cm).floor() - 0.5;
    (cell / voxels_per_cm, voxels_per_cm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lorelei_core::look::LayerSpacing;

    #[test]
    fn layers_start_where_the_ones_before_end() {
        let params = |layer_spacing| ShadowParams { layer_size: 0.5, layer_spacing, ..ShadowParams::default() };
        assert_eq!(layer_starts(&params(LayerSpacing::Linear))[..5], [0.0, 0.5, 1.5, 3.0, 5.0]);
        assert_eq!(layer_starts(&params(LayerSpacing::PowerOfTwo))[..5], [0.0, 0.5, 1.5, 3.5, 7.5]);
        assert_eq!(layer_starts(&params(LayerSpacing::Fibonacci))[..5], [0.0, 0.5, 1.0, 2.0, 3.5]);
        assert_eq!(layer_starts(&params(LayerSpacing::Constant))[15], 7.5);
    }

    #[test]
    fn the_grid_holds_the_ball_and_moves_by_whole_cells() {
        let ball = Ball { centre: Vec3::new(1.0, 150.0, -2.0), radius: 20.0 };
        let (at_rest, per_cm) = grid(64, ball, Affine3A::IDENTITY);
        for step in [0.0, 0.13, 0.31, 0.77] {
            let moved = Affine3A::from_translation(Vec3::splat(step));
            let (corner, _) = grid(64, ball, moved);
            let cells = (corner - at_rest) * per_cm;
            assert!((cells - cells.round()).abs().max_element() < 1e-3, "{cells}");
            let (lo, hi) = (ball.centre + step - ball.radius, ball.centre + step + ball.radius);
            assert!(corner.cmple(lo).all() && (corner + 64.0 / per_cm).cmpge(hi).all(), "{corner}");
        }
    }
}
