//! Hair as what slows the air: its mass and its momentum in every cell. Twin of `wind_hair.wgsl`.
//!
//! Sums are of whole numbers, so they do not depend on the order in which threads add.

use glam::{IVec3, Vec3, Vec4, Vec4Swizzles};

use super::grid::GridParams;

/// Vertices that are given to the grid in a frame: 32 additions each, which all other passes cost together.
const MAX_VERTICES: u32 = 8192;
/// Fastest hair that the grid knows, cm/s.
const FASTEST: f32 = 2000.0;

/// Layout of `Hair` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct HairParams {
    pub n_vertices: u32,
    /// Guides that are taken: every `stride`-th.
    pub n_taken: u32,
    pub stride: u32,
    /// Guides that a taken one stands for.
    pub each: f32,
    /// 1 over the seconds since the positions before; 0 where there are none.
    pub per_sec: f32,
    pub pad: [f32; 3],
}

impl HairParams {
    /// Every second, third .. guide where there are too many.
    pub fn new(n_guides: u32, n_vertices: u32, dt_secs: Option<f32>) -> Self {
        let stride = (n_guides * n_vertices).div_ceil(MAX_VERTICES).max(1);
        let n_taken = n_guides.div_ceil(stride);
        Self {
            n_vertices,
            n_taken,
            stride,
            each: n_guides as f32 / n_taken.max(1) as f32,
            per_sec: dt_secs.map_or(0.0, f32::recip),
            pad: [0.0; 3],
        }
    }
}

fn is_sane(p: Vec3) -> bool {
    p.x.abs() < 1e5 && p.y.abs() < 1e5 && p.z.abs() < 1e5
}

/// Give a vertex's hair to the cells around it.
pub fn splat(
    grid: &GridParams,
    hair: &HairParams,
    item: u32,
    positions: &[Vec4],
    windage: &[f32],
    positions_before: &mut [Vec4],
    hair_cells: &mut [i32],
) {
    let idx = (item / hair.n_vertices * hair.stride * hair.n_vertices + item % hair.n_vertices) as usize;
    let p = positions[idx].xyz();
    let before = std::mem::replace(&mut positions_before[idx], p.extend(0.0)).xyz();
    if !is_sane(p) {
        return;
    }
    let mut v = Vec3::ZERO;
    if is_sane(before) {
        v = ((p - before) * hair.per_sec).clamp(Vec3::splat(-FASTEST), Vec3::splat(FASTEST));
    }
    let mass_here = hair.each * windage[idx];
    let in_cells = (p - grid.min) / grid.cell - 0.5;
    let corner = in_cells.floor();
    let t = in_cells - corner;
    for i in 0..8_u32 {
        let offset = glam::UVec3::new(i & 1, i >> 1 & 1, i >> 2);
        let at = corner.as_ivec3() + offset.as_ivec3();
        if at.cmplt(IVec3::ZERO).any() || at.cmpge(IVec3::splat(grid.n as i32)).any() {
            continue;
        }
        let share = (1.0 - t) + offset.as_vec3() * (2.0 * t - 1.0);
        let here = mass_here * share.x * share.y * share.z;
        let cell = 4 * grid.entry(at.as_uvec3());
        hair_cells[cell] += (here * grid.mass_unit).round_ties_even() as i32;
        let momentum = here * v * grid.momentum_unit;
        for axis in 0..3 {
            hair_cells[cell + 1 + axis] += momentum[axis].round_ties_even() as i32;
        }
    }
}
