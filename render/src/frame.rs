//! What a frame is rendered from and into: the input, and the textures of one picture size.

use glam::Affine3A;
use lorelei_core::camera::Camera;
use lorelei_shaders::{Gpu, GpuError};

use crate::generate::MovedLayer;

/// Colour of scene light: half floats, premultiplied.
pub(crate) const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy)]
pub struct FrameInput<'a> {
    pub camera: &'a Camera,
    /// Pixels.
    pub size: [u32; 2],
    /// Where the head is.
    pub world_from_head: Affine3A,
    /// Per layer; a list that ends earlier: at rest.
    pub moved: &'a [MovedLayer<'a>],
    /// Changes when hair has moved since the last frame: what did not move is not made again.
    pub moved_stamp: u64,
    /// Multiplies the look's level of detail: below 1 while the camera moves on a slow device.
    pub lod_scale: f32,
}

/// Textures of one picture size.
#[derive(Debug)]
pub(crate) struct Targets {
    pub size: [u32; 2],
    /// World normals of the head, and how much of it is scalp; weighted with the share of the pixel that it covers.
    pub head_normal: wgpu::TextureView,
    /// Premultiplied; alpha is the share of the pixel that the head covers.
    pub head_colour: wgpu::TextureView,
    /// View depth, centimetres; the share of the pixel that the head covers.
    pub head_depth: wgpu::TextureView,
    /// Premultiplied hair that is seen past the head.
    pub hair: wgpu::TextureView,
    /// The same before it is averaged, where it is supersampled.
    pub fine_hair: Option<wgpu::TextureView>,
    pub supersampling: u32,
    pub output: wgpu::Texture,
    pub output_view: wgpu::TextureView,
}

impl Targets {
    /// Where strands are drawn: a larger picture where they are supersampled.
    pub fn drawn_hair(&self) -> &wgpu::TextureView {
        self.fine_hair.as_ref().unwrap_or(&self.hair)
    }

    /// Make what strands are drawn into empty.
    pub fn clear_hair(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("hair.clear"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: self.drawn_hair(),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
    }

    /// `supersampling`: pixels of hair that are drawn for one, along a side.
    pub fn new(gpu: &Gpu, size: [u32; 2], supersampling: u32) -> Result<Self, GpuError> {
        use wgpu::TextureUsages as Usage;
        let sized = |label, format, usage, [width, height]: [u32; 2]| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let texture = |label, format, usage| sized(label, format, usage, size);
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        gpu.checked(|| {
            let attached = Usage::RENDER_ATTACHMENT;
            let read = Usage::TEXTURE_BINDING;
            let output = texture(
                "frame.output",
                wgpu::TextureFormat::Rgba8Unorm,
                read | Usage::STORAGE_BINDING | Usage::COPY_SRC,
            );
            Self {
                size,
                head_normal: view(&texture("head.normal", COLOUR, read | Usage::STORAGE_BINDING)),
                head_colour: view(&texture("head.colour", COLOUR, read | Usage::STORAGE_BINDING | Usage::COPY_SRC)),
                head_depth: view(&texture(
                    "head.depth",
                    wgpu::TextureFormat::Rg32Float,
                    read | Usage::STORAGE_BINDING | Usage::COPY_SRC,
                )),
                hair: view(&texture("hair", COLOUR, attached | read | Usage::STORAGE_BINDING | Usage::COPY_SRC)),
                fine_hair: (supersampling > 1).then(|| {
                    let usage = attached | read | Usage::STORAGE_BINDING;
                    view(&sized("hair.fine", COLOUR, usage, size.map(|side| side * supersampling)))
                }),
                supersampling,
                output_view: view(&output),
                output,
            }
        })
    }
}
