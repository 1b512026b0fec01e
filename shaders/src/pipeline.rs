//! What compute and render pipelines have in common: a label, layouts read from the shader, binding by name.

use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::layout::Groups;

/// A pipeline of wgpu's with its layouts: a [`crate::Kernel`] or a [`crate::Draw`].
#[derive(Debug, Clone)]
pub struct Pipeline<P> {
    pub(crate) label: String,
    pub(crate) inner: P,
    pub(crate) groups: Groups,
    /// Of a compute entry point, overrides applied; zeros for others.
    pub(crate) workgroup_size: [u32; 3],
}

/// Resources bound to one pipeline, made by its `bind`.
#[derive(Debug, Clone)]
pub struct Bindings {
    pub(crate) groups: Vec<wgpu::BindGroup>,
}

impl<P> Pipeline<P> {
    /// `file.entry`, or `file.vertex+fragment`.
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Names of everything that [`Pipeline::bind`] needs.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.groups.names()
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
}
