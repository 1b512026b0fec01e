//! Hair over head over background, through the tonemapper, into the picture.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::Mat3;
use lorelei_core::look::{Background, FalseColour, Look, Tonemapping};
use lorelei_shaders::{Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

use crate::environment::{EnvironmentPicture, turn_and_gain};
use crate::false_colour::FalseColourPass;
use crate::frame::Targets;
use crate::slot;
use crate::white_balance;

/// Twin of `ResolveLook`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct ResolveLook {
    /// Columns of [`picture_from_scene`].
    picture_from_scene: [[f32; 4]; 3],
    grey: f32,
    /// Of the environment's picture: radians about the vertical, and scale.
    turn: f32,
    gain: f32,
    pad: f32,
}

impl ResolveLook {
    fn new(look: &Look) -> Self {
        let matrix = picture_from_scene(look);
        let column = |axis: usize| matrix.col(axis).extend(0.0).to_array();
        let (turn, gain) = turn_and_gain(look);
        Self { picture_from_scene: [0, 1, 2].map(column), grey: look.background_grey, turn, gain, pad: 0.0 }
    }
}

/// Exposure and white balance: what scene light is multiplied with before the tonemapper, linear Rec. 709.
pub fn picture_from_scene(look: &Look) -> Mat3 {
    look.exposure.exp2() * white_balance::adaptation(look.white_balance)
}

/// What the last pass needs of the frame.
#[derive(Clone, Copy)]
pub(crate) struct ResolveInput<'a> {
    pub look: &'a Look,
    pub view: &'a wgpu::Buffer,
    pub targets: &'a Targets,
    pub false_colours: &'a FalseColourPass,
    pub environment: &'a EnvironmentPicture,
}

/// The last pass.
pub(crate) struct ResolvePass {
    kernels: HashMap<(Tonemapping, Background, FalseColour), Hot<Kernel>>,
    look: wgpu::Buffer,
}

impl ResolvePass {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            kernels: HashMap::new(),
            look: gpu.buffer("resolve.look", size_of::<ResolveLook>() as u64, BufferUsages::UNIFORM),
        }
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernels.values().find_map(Hot::error)
    }

    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &ResolveInput<'_>,
    ) -> Result<(), ShaderError> {
        let &ResolveInput { look, view, targets, false_colours, environment } = input;
        let choices = (look.tonemapping, look.background, look.view);
        let make = |library: &ShaderLibrary| {
            let links = [slot::tonemapping(choices.0), slot::background(choices.1), slot::view_picture(choices.2)];
            library.kernel(gpu, "resolve", "resolve", &[], &links)
        };
        Hot::have(&mut self.kernels, library, &choices, make)?;
        gpu.queue.write_buffer(&self.look, 0, bytemuck::bytes_of(&ResolveLook::new(look)));
        let kernel = &self.kernels[&choices];
        let mut resources = vec![
            ("view", view.as_entire_binding()),
            ("resolve_look", self.look.as_entire_binding()),
            ("hair", wgpu::BindingResource::TextureView(&targets.hair)),
            ("head_colour", wgpu::BindingResource::TextureView(&targets.head_colour)),
            ("head_normal", wgpu::BindingResource::TextureView(&targets.head_normal)),
            ("picture", wgpu::BindingResource::TextureView(&targets.output_view)),
        ];
        resources.extend(false_colours.resources());
        resources.extend(environment.resources());
        let bindings = kernel.bind_used(gpu, &resources)?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("resolve"), timestamp_writes: None });
        let [width, height] = targets.size;
        kernel.dispatch(&mut pass, &bindings, [width.div_ceil(8), height.div_ceil(8), 1]);
        Ok(())
    }
}

/// Supersampled hair into the picture's pixels.
pub(crate) struct Downsample {
    kernel: Hot<Kernel>,
}

impl Downsample {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let make = |library: &ShaderLibrary| library.kernel(gpu, "downsample", "downsample", &[], &[]);
        Ok(Self { kernel: Hot::new(library, make)? })
    }

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.kernel.error()
    }

    /// Nothing where hair was drawn into the picture's own pixels. `frame` is the rasteriser's.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        frame: (&'static str, wgpu::BindingResource<'_>),
        targets: &Targets,
    ) -> Result<(), ShaderError> {
        let Some(fine) = &targets.fine_hair else { return Ok(()) };
        self.kernel.refresh(library, |library| library.kernel(gpu, "downsample", "downsample", &[], &[]));
        let bindings = self.kernel.bind(
            gpu,
            &[
                frame,
                ("fine_hair", wgpu::BindingResource::TextureView(fine)),
                ("hair", wgpu::BindingResource::TextureView(&targets.hair)),
            ],
        )?;
        let descriptor = wgpu::ComputePassDescriptor { label: Some("downsample"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        let [width, height] = targets.size;
        self.kernel.dispatch(&mut pass, &bindings, [width.div_ceil(8), height.div_ceil(8), 1]);
        Ok(())
    }
}
