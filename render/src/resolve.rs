//! Hair over head over background, through the tonemapper, into the picture.

use std::collections::HashMap;

use lorelei_core::look::{Background, Look, Tonemapping};
use lorelei_shaders::{Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::frame::Targets;
use crate::slot;

/// The last pass.
pub(crate) struct ResolvePass {
    kernels: HashMap<(Tonemapping, Background), Hot<Kernel>>,
    look: wgpu::Buffer,
}

impl ResolvePass {
    pub fn new(gpu: &Gpu) -> Self {
        Self { kernels: HashMap::new(), look: gpu.buffer("resolve.look", 16, BufferUsages::UNIFORM) }
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.values().find_map(Hot::error)
    }

    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        look: &Look,
        view: &wgpu::Buffer,
        targets: &Targets,
    ) -> Result<(), ShaderError> {
        let choices = (look.tonemapping, look.background);
        let make = |library: &ShaderLibrary| {
            library.kernel(gpu, "resolve", "resolve", &[], &[slot::tonemapping(choices.0), slot::background(choices.1)])
        };
        if let Some(kernel) = self.kernels.get_mut(&choices) {
            kernel.refresh(library, make);
        } else {
            self.kernels.insert(choices, Hot::new(library, make)?);
        }
        let numbers = [look.exposure.exp2(), look.background_grey, 0.0, 0.0];
        gpu.queue.write_buffer(&self.look, 0, bytemuck::cast_slice(&numbers));
        let kernel = &self.kernels[&choices];
        let bindings = kernel.bind(
            gpu,
            &[
                ("view", view.as_entire_binding()),
                ("resolve_look", self.look.as_entire_binding()),
                ("hair", wgpu::BindingResource::TextureView(&targets.hair)),
                ("head_colour", wgpu::BindingResource::TextureView(&targets.head_colour)),
                ("picture", wgpu::BindingResource::TextureView(&targets.output_view)),
            ],
        )?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("resolve"), timestamp_writes: None });
        let [width, height] = targets.size;
        kernel.dispatch(&mut pass, &bindings, [width.div_ceil(8), height.div_ceil(8), 1]);
        Ok(())
    }
}
