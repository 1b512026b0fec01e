//! A vertex and a fragment entry point as a render pipeline that is bound by variable name.
//!
//! There are no vertex buffers: vertex shaders read storage buffers, by name like everything else.

use naga::ShaderStage;

use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::layout::reflect;
use crate::library::Link;
use crate::link::Linked;
use crate::pipeline::{Bindings, Pipeline};

/// What a render pipeline is, apart from its shaders.
#[derive(Debug, Clone, Default)]
pub struct DrawDescriptor<'a> {
    pub vertex: &'a str,
    /// `None` draws depth only.
    pub fragment: Option<&'a str>,
    pub overrides: &'a [(&'a str, f64)],
    pub links: &'a [Link<'a>],
    pub primitive: wgpu::PrimitiveState,
    pub targets: &'a [Option<wgpu::ColorTargetState>],
    pub depth: Option<wgpu::DepthStencilState>,
    pub multisample: wgpu::MultisampleState,
}

/// A render pipeline. Its layouts come from the shader.
pub type Draw = Pipeline<wgpu::RenderPipeline>;

impl Draw {
    pub(crate) fn new(gpu: &Gpu, linked: &Linked, descriptor: &DrawDescriptor<'_>) -> Result<Self, ShaderError> {
        let mut entries = vec![(ShaderStage::Vertex, descriptor.vertex)];
        entries.extend(descriptor.fragment.map(|entry| (ShaderStage::Fragment, entry)));
        let reflected = reflect(gpu, linked, &entries, descriptor.overrides)?;
        let pipeline = gpu
            .checked(|| {
                gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(&reflected.label),
                    layout: Some(&reflected.pipeline_layout),
                    vertex: wgpu::VertexState {
                        module: &reflected.shader,
                        entry_point: None,
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        buffers: &[],
                    },
                    primitive: descriptor.primitive,
                    depth_stencil: descriptor.depth.clone(),
                    multisample: descriptor.multisample,
                    fragment: descriptor.fragment.map(|_| wgpu::FragmentState {
                        module: &reflected.shader,
                        entry_point: None,
                        compilation_options: wgpu::PipelineCompilationOptions::default(),
                        targets: descriptor.targets,
                    }),
                    multiview_mask: None,
                    cache: None,
                })
            })
            .map_err(|error| ShaderError::Pipeline { label: reflected.label.clone(), message: error.to_string() })?;
        Ok(Self {
            label: reflected.label,
            inner: pipeline,
            groups: reflected.groups,
            workgroup_size: reflected.workgroup_size,
        })
    }

    /// Make pipeline and bindings the current ones of a render pass.
    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>, bindings: &Bindings) {
        pass.set_pipeline(&self.inner);
        for (group_idx, group) in bindings.groups.iter().enumerate() {
            pass.set_bind_group(group_idx as u32, group, &[]);
        }
    }

    /// Record a draw of vertices without instances.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, bindings: &Bindings, n_vertices: u32) {
        self.draw_range(pass, bindings, 0..n_vertices);
    }

    /// Record a draw of some of the vertices: `vertex_index` begins at the range's start.
    pub fn draw_range(&self, pass: &mut wgpu::RenderPass<'_>, bindings: &Bindings, vertices: std::ops::Range<u32>) {
        self.set(pass, bindings);
        pass.draw(vertices, 0..1);
    }

    /// Record a draw whose counts (vertices, instances, first vertex, first instance: four `u32`) are in a buffer.
    pub fn draw_indirect(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        bindings: &Bindings,
        counts: &wgpu::Buffer,
        offset: u64,
    ) {
        self.set(pass, bindings);
        pass.draw_indirect(counts, offset);
    }
}
