//! Guides that follow moved curves of fewer vertices: a hair mesh's chains. Twin of `sim_follow.wgsl`.

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::moved::{Spline, SplineRow};
use lorelei_shaders::{Gpu, Kernel, ShaderError};
use rayon::prelude::*;

/// A guide's vertex from the vertices of its curve.
fn row_sum(row: &SplineRow, curve: &[Vec4]) -> Vec3 {
    row.vertices.iter().zip(row.weights).map(|(&v, w)| w * curve[v as usize].xyz()).sum()
}

/// All guides, from curves of `n_curve` vertices each.
pub fn follow_curves(spline: &Spline, n_curve: u32, curves: &[Vec4]) -> Vec<Vec4> {
    let n_guide = spline.n_vertices as usize;
    let of_guide = |(&first, curve): (&u32, &[Vec4])| {
        let rows = &spline.rows[first as usize..first as usize + n_guide];
        rows.iter().map(|row| row_sum(row, curve).extend(0.0)).collect::<Vec<_>>()
    };
    spline.first_rows.par_iter().zip(curves.par_chunks(n_curve.max(1) as usize)).flat_map_iter(of_guide).collect()
}

/// Layout of `FollowParams` in WGSL.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FollowParams {
    n_guide: u32,
    n_curve: u32,
    n_items: u32,
    pad: u32,
}

/// A layer's guides on the GPU, and how they follow.
pub(crate) struct Followed {
    spline: Spline,
    n_curve: u32,
    params: wgpu::Buffer,
    first_rows: wgpu::Buffer,
    rows: wgpu::Buffer,
    /// Where the picture shows the guides: `array<vec4<f32>>`.
    pub positions: wgpu::Buffer,
}

impl Followed {
    /// `curves` are shown now, with `n_curve` vertices each.
    pub fn new(gpu: &Gpu, spline: &Spline, n_curve: u32, curves: &[Vec4]) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let positions = follow_curves(spline, n_curve, curves);
        let params = FollowParams { n_guide: spline.n_vertices, n_curve, n_items: positions.len() as u32, pad: 0 };
        Self {
            params: gpu.buffer_of("sim.follow", &[params], wgpu::BufferUsages::UNIFORM),
            first_rows: gpu.buffer_of("sim.follow.first_rows", &spline.first_rows, storage),
            rows: gpu.buffer_of("sim.follow.rows", &spline.rows, storage),
            positions: gpu.buffer_of("sim.followed", &positions, storage | wgpu::BufferUsages::COPY_SRC),
            spline: spline.clone(),
            n_curve,
        }
    }

    /// Follow curves that are known on the CPU, from before what is submitted later.
    pub fn send(&self, gpu: &Gpu, curves: &[Vec4]) {
        let positions = follow_curves(&self.spline, self.n_curve, curves);
        if !positions.is_empty() {
            gpu.queue.write_buffer(&self.positions, 0, bytemuck::cast_slice(&positions));
        }
    }

    /// Follow curves that a dispatch before this one has moved.
    pub fn record(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        pass: &mut wgpu::ComputePass<'_>,
        curves: &wgpu::Buffer,
    ) -> Result<(), ShaderError> {
        let resources = [
            ("follow", self.params.as_entire_binding()),
            ("first_rows", self.first_rows.as_entire_binding()),
            ("rows", self.rows.as_entire_binding()),
            ("curves", curves.as_entire_binding()),
            ("followed", self.positions.as_entire_binding()),
        ];
        let bindings = kernel.bind(gpu, &resources)?;
        kernel.dispatch_items(pass, &bindings, self.n_shown() as u32);
        Ok(())
    }

    /// Vertices of all guides.
    pub fn n_shown(&self) -> usize {
        self.spline.first_rows.len() * self.spline.n_vertices as usize
    }
}
