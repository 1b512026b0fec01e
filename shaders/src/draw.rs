//! A vertex and a fragment entry point as a render pipeline that is bound by variable name.
//!
//! There are no vertex buffers: vertex shaders read storage buffers, by name like everything else.

use naga::ShaderStage;

use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::kernel::Bindings;
use crate::layout::{Groups, reflect};
use crate::library::Link;
use crate::link::Linked;

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
#[derive(Debug, Clone)]
pub struct Draw {
    label: String,
    pipeline: wgpu::RenderPipeline,
    groups: Groups,
}

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
        Ok(Self { label: reflected.label, pipeline, groups: reflected.groups })
    }

    /// `file.vertex+fragment`.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Bind resources by the names of the shader's variables: all of them, and no others.
    pub fn bind(&self, gpu: &Gpu, resources: &[(&str, wgpu::BindingResource<'_>)]) -> Result<Bindings, ShaderError> {
        self.groups.bind(gpu, resources, true)
    }

    /// Bind what the pipeline uses and leave the rest: for shaders with slots, whose modules need different things.
    pub fn bind_used(
        &self,
        gpu: &Gpu,
        resources: &[(&str, wgpu::BindingResource<'_>)],
    ) -> Result<Bindings, ShaderError> {
        self.groups.bind(gpu, resources, false)
    }

    /// Make pipeline and bindings the current ones of a render pass.
    pub fn set(&self, pass: &mut wgpu::RenderPass<'_>, bindings: &Bindings) {
        pass.set_pipeline(&self.pipeline);
        for (group_idx, group) in bindings.groups.iter().enumerate() {
            pass.set_bind_group(group_idx as u32, group, &[]);
        }
    }

    /// Record a draw of vertices without instances.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, bindings: &Bindings, n_vertices: u32) {
        self.set(pass, bindings);
        pass.draw(0..n_vertices, 0..1);
    }
}
