//! The air of the grid at any place: what strands and drawings ask. Twin of `wind_air.wgsl`.

use std::sync::Arc;

use glam::{Vec3, Vec4, Vec4Swizzles};

use super::free::FreeAir;

/// Layout of `AirGrid` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct AirGridParams {
    /// Lower corner, world, cm.
    pub min: Vec3,
    pub cell: f32,
    /// Cells along a side; 0 where there is no grid.
    pub n: u32,
    pub pad: [u32; 3],
}

/// The air of one frame; a clone is cheap.
#[derive(Debug, Clone, PartialEq)]
pub struct AirGrid {
    pub params: AirGridParams,
    /// Velocity in the middle of every cell, `n + 1` entries along each axis; w how open the cell is (0 in the head).
    pub air: Arc<Vec<Vec4>>,
    pub free: Arc<FreeAir>,
}

impl AirGrid {
    /// Air without a grid.
    pub fn of_free(free: FreeAir) -> Self {
        let params = AirGridParams { min: Vec3::ZERO, cell: 1.0, n: 0, pad: [0; 3] };
        Self { params, air: Arc::default(), free: Arc::new(free) }
    }

    /// World, cm/s; outside of the grid the air that nothing stands in the way of.
    pub fn air_velocity(&self, p: Vec3) -> Vec3 {
        match self.sample(p) {
            Some(air) => air.xyz(),
            None => self.free.free_air(p),
        }
    }

    /// The middle of every cell, its velocity and how open it is (w).
    pub fn cells(&self) -> impl Iterator<Item = (Vec3, Vec4)> + '_ {
        let (n, side) = (self.params.n, self.params.n as usize + 1);
        (0..n * n * n).map(move |i| {
            let c = glam::UVec3::new(i % n, i / n % n, i / (n * n));
            let at = c.x as usize + side * (c.y as usize + side * c.z as usize);
            (self.params.min + self.params.cell * (c.as_vec3() + 0.5), self.air[at])
        })
    }

    /// Velocity and how open the place is (w); `None` outside of the grid.
    pub fn sample(&self, p: Vec3) -> Option<Vec4> {
        let g = (p - self.params.min) / self.params.cell;
        let last = self.params.n as f32;
        let is_inside = self.params.n > 0 && g.cmpge(Vec3::ZERO).all() && g.cmple(Vec3::splat(last)).all();
        is_inside.then(|| trilinear(&self.air, self.params.n, g))
    }
}

/// The velocity in the cells around a place that is given in cells and is in the grid.
pub(super) fn trilinear(air: &[Vec4], n: u32, g: Vec3) -> Vec4 {
    let inside = (g - 0.5).clamp(Vec3::ZERO, Vec3::splat(n as f32 - 1.0));
    let corner = inside.as_uvec3().min(glam::UVec3::splat(n - 2));
    let t = inside - corner.as_vec3();
    let row = n as usize + 1;
    let at = corner.x as usize + row * (corner.y as usize + row * corner.z as usize);
    let z = at + row * row;
    let y0 = mix(mix(air[at], air[at + 1], t.x), mix(air[at + row], air[at + row + 1], t.x), t.y);
    let y1 = mix(mix(air[z], air[z + 1], t.x), mix(air[z + row], air[z + row + 1], t.x), t.y);
    mix(y0, y1, t.z)
}

fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a * (1.0 - t) + b * t
}
