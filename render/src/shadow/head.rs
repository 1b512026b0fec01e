//! The depth of the head as each light sees it, through the graphics pipeline.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4};
use lorelei_core::mesh::TriMesh;
use lorelei_shaders::{Bindings, Draw, DrawDescriptor, Gpu, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use super::params::MapSize;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Twin of `HeadCaster`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct HeadCaster {
    world_from_head: [f32; 16],
    light_idx: u32,
    pad: [u32; 3],
}

/// The mesh that stands in the lights' way, in head space.
pub(super) struct HeadMesh {
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    n_indices: u32,
}

impl HeadMesh {
    pub fn new(gpu: &Gpu, mesh: &TriMesh) -> Self {
        Self {
            positions: gpu.buffer_of("shadow.head.positions", &mesh.positions, BufferUsages::STORAGE),
            indices: gpu.buffer_of("shadow.head.indices", &mesh.triangles, BufferUsages::STORAGE),
            n_indices: 3 * mesh.triangles.len() as u32,
        }
    }
}

/// Depth maps of all lights.
pub(super) struct HeadMaps {
    /// All of them, for look-ups.
    pub view: wgpu::TextureView,
    of_light: Vec<(wgpu::TextureView, wgpu::Buffer)>,
}

impl HeadMaps {
    pub fn new(gpu: &Gpu, size: MapSize) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("shadow.head.depth"),
            size: wgpu::Extent3d {
                width: size.resolution,
                height: size.resolution,
                depth_or_array_layers: size.n_lights,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = |dimension, base_array_layer, array_layer_count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                label: Some("shadow.head.depth"),
                dimension: Some(dimension),
                base_array_layer,
                array_layer_count,
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        let caster = || gpu.buffer("shadow.head.caster", size_of::<HeadCaster>() as u64, BufferUsages::UNIFORM);
        Self {
            view: view(wgpu::TextureViewDimension::D2Array, 0, None),
            of_light: (0..size.n_lights)
                .map(|light_idx| (view(wgpu::TextureViewDimension::D2, light_idx, Some(1)), caster()))
                .collect(),
        }
    }

    pub fn place(&self, gpu: &Gpu, world_from_head: Affine3A) {
        for (light_idx, (_, caster)) in self.of_light.iter().enumerate() {
            let world_from_head = Mat4::from(world_from_head).to_cols_array();
            let uniform = HeadCaster { world_from_head, light_idx: light_idx as u32, pad: [0; 3] };
            gpu.queue.write_buffer(caster, 0, bytemuck::bytes_of(&uniform));
        }
    }

    /// Bindings of each light's draw; `resources`: what all passes of shadows share.
    pub fn bind(
        &self,
        gpu: &Gpu,
        draw: &Draw,
        mesh: &HeadMesh,
        resources: &[(&'static str, wgpu::BindingResource<'_>)],
    ) -> Result<Vec<Bindings>, ShaderError> {
        let of_light = self.of_light.iter().map(|(_, caster)| {
            let mut resources = resources.to_vec();
            resources.extend([
                ("head_caster", caster.as_entire_binding()),
                ("head_positions", mesh.positions.as_entire_binding()),
                ("head_indices", mesh.indices.as_entire_binding()),
            ]);
            draw.bind_used(gpu, &resources)
        });
        of_light.collect()
    }

    /// Clear all maps, and draw the head into those of the lights whose shadows it casts.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        draw: &Draw,
        mesh: Option<&HeadMesh>,
        bindings: &[Bindings],
        casts: impl Fn(usize) -> bool,
    ) {
        for (light_idx, (view, _)) in self.of_light.iter().enumerate() {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("shadow.head"),
                color_attachments: &[],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            if let (true, Some(mesh), Some(bindings)) = (casts(light_idx), mesh, bindings.get(light_idx)) {
                draw.draw(&mut pass, bindings, mesh.n_indices);
            }
        }
    }
}

pub(super) fn make_draw(gpu: &Gpu, library: &ShaderLibrary) -> Result<Draw, ShaderError> {
    library.draw(
        gpu,
        "shadow_head",
        &DrawDescriptor {
            vertex: "vertex",
            depth: Some(wgpu::DepthStencilState {
                format: FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            ..DrawDescriptor::default()
        },
    )
}
