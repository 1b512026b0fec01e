//! The depth of the head as each light sees it.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Bindings, Gpu, Kernel, ShaderError, ShaderLibrary, grid_1d};
use wgpu::BufferUsages;

use super::params::MapSize;

/// Twin of `HeadCaster`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct HeadCaster {
    world_from_head: [f32; 16],
    n_triangles: u32,
    pad: [u32; 3],
}

/// The mesh that stands in the lights' way, in head space.
pub(super) struct HeadMesh {
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    n_triangles: u32,
}

impl HeadMesh {
    pub fn new(gpu: &Gpu, mesh: &TriMesh) -> Self {
        Self {
            positions: gpu.buffer_of("shadow.head.positions", &mesh.positions, BufferUsages::STORAGE),
            indices: gpu.buffer_of("shadow.head.indices", &mesh.triangles, BufferUsages::STORAGE),
            n_triangles: mesh.triangles.len() as u32,
        }
    }
}

/// Depth maps of all lights.
pub(super) struct HeadMaps {
    /// `array<u32>`: see shadow_head.wgsl.
    pub fronts: wgpu::Buffer,
    caster: wgpu::Buffer,
    n_lights: u32,
}

impl HeadMaps {
    pub fn new(gpu: &Gpu, size: MapSize) -> Self {
        Self {
            fronts: gpu.buffer("shadow.head", 4 * size.n_texels(), BufferUsages::STORAGE),
            caster: gpu.buffer("shadow.head.caster", size_of::<HeadCaster>() as u64, BufferUsages::UNIFORM),
            n_lights: size.n_lights,
        }
    }

    /// Send where the head is.
    pub fn place(&self, gpu: &Gpu, mesh: Option<&HeadMesh>, world_from_head: Affine3A) {
        let caster = HeadCaster {
            world_from_head: Mat4::from(world_from_head).to_cols_array(),
            n_triangles: mesh.map_or(0, |mesh| mesh.n_triangles),
            pad: [0; 3],
        };
        gpu.queue.write_buffer(&self.caster, 0, bytemuck::bytes_of(&caster));
    }

    /// `resources`: what all passes of shadows share.
    pub fn bind(
        &self,
        gpu: &Gpu,
        kernel: &Kernel,
        mesh: &HeadMesh,
        resources: &[(&'static str, wgpu::BindingResource<'_>)],
    ) -> Result<Bindings, ShaderError> {
        let mut resources = resources.to_vec();
        resources.extend([
            ("head_caster", self.caster.as_entire_binding()),
            ("head_positions", mesh.positions.as_entire_binding()),
            ("head_indices", mesh.indices.as_entire_binding()),
        ]);
        kernel.bind_used(gpu, &resources)
    }

    /// Clear all maps, and draw the head into those of the lights whose shadows it casts; `drawn`: the head where it does.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, kernel: &Kernel, drawn: Option<(&HeadMesh, &Bindings)>) {
        encoder.clear_buffer(&self.fronts, 0, None);
        let Some((mesh, bindings)) = drawn else { return };
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("shadow.head"), timestamp_writes: None });
        let [n_groups, n_rows, _] = grid_1d(mesh.n_triangles, kernel.workgroup_size()[0]);
        kernel.dispatch(&mut pass, bindings, [n_groups, n_rows, self.n_lights]);
    }
}

pub(super) fn make_kernel(gpu: &Gpu, library: &ShaderLibrary) -> Result<Kernel, ShaderError> {
    library.kernel(gpu, "shadow_head", "draw_head", &[], &[])
}
