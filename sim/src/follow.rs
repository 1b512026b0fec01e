//! Guides that follow moved curves: a hair mesh's chains, or a rope. Twin of `sim_follow.wgsl`.

use std::sync::Arc;

use glam::{Quat, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::guides::GuideSet;
use lorelei_core::moved::Spline;
use lorelei_shaders::{Gpu, Kernel, ShaderError};
use rayon::prelude::*;

use crate::rest::{Hold, lengths_at};

/// How a layer's guides follow, and what that is at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Following {
    spline: Spline,
    /// Vertices of a curve.
    n_curve: u32,
    /// Per guide vertex: the curve's direction at its place, at rest in head space; empty where guides lie on their curve.
    tangents: Vec<Vec3>,
}

impl Following {
    /// `curves` are at rest.
    pub fn new(spline: &Spline, curves: &GuideSet) -> Self {
        let n_guide = spline.n_vertices as usize;
        let tangent = |idx: usize| {
            let row = &spline.rows[spline.first_rows[idx / n_guide] as usize + idx % n_guide];
            let curve = curves.guide(spline.curve_of[idx / n_guide] as usize);
            row.vertices.iter().zip(row.slopes).map(|(&v, w)| w * curve[v as usize]).sum()
        };
        let tangents = (0..spline.offsets.len()).map(tangent).collect();
        Self { spline: spline.clone(), n_curve: curves.n_vertices, tangents }
    }

    /// Vertices of all guides.
    pub fn n_shown(&self) -> usize {
        self.spline.first_rows.len() * self.spline.n_vertices as usize
    }

    /// Stiffness over mass by which pins hold each vertex of the curves, which are at rest, 1/s2: a curve is held as the
    /// guides that follow it are in the mean, at the vertices that they follow there.
    pub fn pinned(&self, hold: &Hold, curves: &[Vec4]) -> Vec<f32> {
        let (n_guide, n_curve) = (self.spline.n_vertices as usize, self.n_curve as usize);
        let guides: Vec<Vec3> = self.follow_curves(curves, Quat::IDENTITY).iter().map(|p| p.xyz()).collect();
        let mut sums = vec![0.0; curves.len()];
        let mut n_guides_of = vec![0.0_f32; curves.len() / n_curve.max(1)];
        for (guide_idx, guide) in guides.chunks(n_guide.max(1)).enumerate() {
            let curve_idx = self.spline.curve_of[guide_idx] as usize;
            n_guides_of[curve_idx] += 1.0;
            let lengths = lengths_at(guide);
            let rows = &self.spline.rows[self.spline.first_rows[guide_idx] as usize..][..n_guide];
            for ((row, pinned), length) in rows.iter().zip(hold.of_pins(guide)).zip(lengths) {
                for (&v, weight) in row.vertices.iter().zip(row.weights) {
                    sums[curve_idx * n_curve + v as usize] += weight.max(0.0) * pinned * length;
                }
            }
        }
        for ((curve, sums), n_guides) in
            curves.chunks(n_curve.max(1)).zip(sums.chunks_mut(n_curve.max(1))).zip(n_guides_of)
        {
            let curve: Vec<Vec3> = curve.iter().map(|p| p.xyz()).collect();
            // A vertex that others lie on has no length of its own.
            let of_vertex = |length: f32| if length > 1e-4 { 1.0 / (length * n_guides.max(1.0)) } else { 0.0 };
            sums.iter_mut().zip(lengths_at(&curve)).for_each(|(sum, length)| *sum *= of_vertex(length));
        }
        sums
    }

    /// All guides, where the picture shows the curves, on a head that is turned by `rotation`.
    pub fn follow_curves(&self, curves: &[Vec4], rotation: Quat) -> Vec<Vec4> {
        let n_guide = self.spline.n_vertices as usize;
        let follow = |item: usize| {
            let guide = item / n_guide;
            let row = &self.spline.rows[self.spline.first_rows[guide] as usize + item % n_guide];
            let first = self.spline.curve_of[guide] * self.n_curve;
            let offset = self.spline.offsets.get(item).map(|&offset| (offset, self.tangents[item]));
            Spline::place(row, |v| curves[(first + v) as usize].xyz(), offset, rotation).extend(0.0)
        };
        (0..self.n_shown()).into_par_iter().map(follow).collect()
    }
}

/// Layout of `FollowParams` in WGSL.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FollowParams {
    rotation: [f32; 4],
    n_guide: u32,
    n_curve: u32,
    n_items: u32,
    is_beside: u32,
}

/// A layer's guides on the GPU.
pub(crate) struct Followed {
    following: Arc<Following>,
    leads: wgpu::Buffer,
    rows: wgpu::Buffer,
    offsets: wgpu::Buffer,
    /// Where the picture shows the guides: `array<vec4<f32>>`.
    pub positions: wgpu::Buffer,
}

impl Followed {
    /// `curves` are shown now, on a head that is not turned.
    pub fn new(gpu: &Gpu, following: Arc<Following>, curves: &[Vec4]) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let spline = &following.spline;
        let leads: Vec<[u32; 2]> =
            spline.curve_of.iter().zip(&spline.first_rows).map(|(&curve, &first)| [curve, first]).collect();
        let offsets: Vec<[Vec4; 2]> = (spline.offsets.iter().zip(&following.tangents))
            .map(|(offset, tangent)| [offset.extend(0.0), tangent.extend(0.0)])
            .collect();
        let positions = following.follow_curves(curves, Quat::IDENTITY);
        Self {
            leads: gpu.buffer_of("sim.follow.leads", &leads, storage),
            rows: gpu.buffer_of("sim.follow.rows", &spline.rows, storage),
            offsets: gpu.buffer_of("sim.follow.offsets", &offsets, storage),
            positions: gpu.buffer_of("sim.followed", &positions, storage | wgpu::BufferUsages::COPY_SRC),
            following,
        }
    }

    /// Follow curves that are known on the CPU, from before what is submitted later.
    pub fn send(&self, gpu: &Gpu, curves: &[Vec4], rotation: Quat) {
        let positions = self.following.follow_curves(curves, rotation);
        if !positions.is_empty() {
            gpu.queue.write_buffer(&self.positions, 0, bytemuck::cast_slice(&positions));
        }
    }

    /// Follow curves that a dispatch before this one has moved, on a head that is turned by `rotation`.
    pub fn record(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        pass: &mut wgpu::ComputePass<'_>,
        curves: &wgpu::Buffer,
        rotation: Quat,
    ) -> Result<(), ShaderError> {
        let params = FollowParams {
            rotation: rotation.to_array(),
            n_guide: self.following.spline.n_vertices,
            n_curve: self.following.n_curve,
            n_items: self.n_shown() as u32,
            is_beside: u32::from(!self.following.spline.offsets.is_empty()),
        };
        let params = gpu.buffer_of("sim.follow", &[params], wgpu::BufferUsages::UNIFORM);
        let resources = [
            ("follow", params.as_entire_binding()),
            ("leads", self.leads.as_entire_binding()),
            ("rows", self.rows.as_entire_binding()),
            ("offsets", self.offsets.as_entire_binding()),
            ("curves", curves.as_entire_binding()),
            ("followed", self.positions.as_entire_binding()),
        ];
        let bindings = kernel.bind(gpu, &resources)?;
        kernel.dispatch_items(pass, &bindings, self.n_shown() as u32);
        Ok(())
    }

    /// Vertices of all guides.
    pub fn n_shown(&self) -> usize {
        self.following.n_shown()
    }
}
