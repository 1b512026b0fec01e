//! The ribbon path: camera-facing strips through the graphics pipeline, sorted and blended.
//!
//! What the references describe and what the compute rasteriser is measured against. Segments are sorted on the GPU
//! from back to front, so that blending composites them as exactly as the compute path does. Blending unsorted strips
//! with weights was rejected: it would be faster, and a comparison of two different pictures.

use lorelei_shaders::{Draw, DrawDescriptor, Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::{BufferUsages, TextureFormat};

use crate::mirror::{DrawnLayer, StrandBuffers};

/// Of the texture that strips are blended into: premultiplied linear RGB and alpha.
pub const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// Twin of `N_BUCKETS` in `ribbons_sort.wgsl`.
const N_BUCKETS: u64 = 1 << 18;

/// Sorts segments and draws them as strips.
pub struct Ribbons {
    pipelines: Hot<Pipelines>,
    buckets: wgpu::Buffer,
    order: wgpu::Buffer,
    layers: Vec<wgpu::Buffer>,
}

struct Pipelines {
    count: Kernel,
    place: Kernel,
    scatter: Kernel,
    blended: Draw,
    opaque: Draw,
}

/// What the strips are drawn from.
#[derive(Clone, Copy)]
pub struct RibbonInput<'a> {
    pub strands: &'a StrandBuffers,
    /// Shaded radiance of every vertex, `array<vec2<u32>>` of packed halves.
    pub radiance: &'a wgpu::Buffer,
    /// `View` of camera.wgsl.
    pub view: &'a wgpu::Buffer,
    /// View depth of the head in centimetres, red channel.
    pub head_depth: &'a wgpu::TextureView,
    /// The head's colour with its coverage as alpha.
    pub head_colour: &'a wgpu::TextureView,
    /// Every fragment opaque instead of weighted by its coverage.
    pub opaque: bool,
}

impl Ribbons {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            pipelines: Hot::new(library, |library| Pipelines::new(gpu, library))?,
            buckets: gpu.buffer("ribbons.buckets", 4 * N_BUCKETS, BufferUsages::STORAGE),
            order: gpu.buffer("ribbons.order", 16, BufferUsages::STORAGE),
            layers: Vec::new(),
        })
    }

    /// Record sorting and drawing into a texture of [`FORMAT`], cleared first.
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        input: &RibbonInput<'_>,
        target: &wgpu::TextureView,
    ) -> Result<(), ShaderError> {
        self.pipelines.refresh(library, |library| Pipelines::new(gpu, library));
        let n_segments: u32 = input.strands.layers.iter().map(DrawnLayer::n_segments).sum();
        self.make_room(gpu, input.strands, n_segments);
        self.record_sort(gpu, encoder, input)?;
        let draw = if input.opaque { &self.pipelines.opaque } else { &self.pipelines.blended };
        let bindings = draw.bind(
            gpu,
            &[
                ("view", input.view.as_entire_binding()),
                ("vertices", input.strands.vertices.as_entire_binding()),
                ("radiance", input.radiance.as_entire_binding()),
                ("order", self.order.as_entire_binding()),
                ("head_depth", wgpu::BindingResource::TextureView(input.head_depth)),
                ("head_colour", wgpu::BindingResource::TextureView(input.head_colour)),
            ],
        )?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("ribbons.draw"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        draw.draw(&mut pass, &bindings, 6 * n_segments);
        Ok(())
    }

    fn make_room(&mut self, gpu: &Gpu, strands: &StrandBuffers, n_segments: u32) {
        if self.order.size() < 4 * u64::from(n_segments) {
            self.order = gpu.buffer("ribbons.order", 4 * u64::from(n_segments), BufferUsages::STORAGE);
        }
        while self.layers.len() < strands.layers.len() {
            self.layers.push(gpu.buffer("ribbons.layer", 16, BufferUsages::UNIFORM));
        }
        for (layer, buffer) in strands.layers.iter().zip(&self.layers) {
            let numbers = [layer.first_vertex, layer.n_strands, layer.vertices_per_strand, layer.n_segments()];
            gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&numbers));
        }
    }

    fn record_sort(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        input: &RibbonInput<'_>,
    ) -> Result<(), ShaderError> {
        encoder.clear_buffer(&self.buckets, 0, None);
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("ribbons.sort"), timestamp_writes: None });
        let each_layer = |kernel: &Kernel, pass: &mut wgpu::ComputePass<'_>| -> Result<(), ShaderError> {
            for (layer, buffer) in input.strands.layers.iter().zip(&self.layers) {
                let bindings = kernel.bind_used(
                    gpu,
                    &[
                        ("view", input.view.as_entire_binding()),
                        ("layer", buffer.as_entire_binding()),
                        ("vertices", input.strands.vertices.as_entire_binding()),
                        ("buckets", self.buckets.as_entire_binding()),
                        ("order", self.order.as_entire_binding()),
                    ],
                )?;
                kernel.dispatch_items(pass, &bindings, layer.n_segments());
            }
            Ok(())
        };
        each_layer(&self.pipelines.count, &mut pass)?;
        let bindings = self.pipelines.place.bind(gpu, &[("buckets", self.buckets.as_entire_binding())])?;
        self.pipelines.place.dispatch(&mut pass, &bindings, [1, 1, 1]);
        each_layer(&self.pipelines.scatter, &mut pass)
    }

    /// Bytes of the lists.
    pub fn n_bytes(&self) -> u64 {
        self.buckets.size() + self.order.size()
    }
}

impl Pipelines {
    fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let kernel = |entry| library.kernel(gpu, "ribbons_sort", entry, &[], &[]);
        let draw = |overrides: &[(&str, f64)]| {
            let target = wgpu::ColorTargetState {
                format: FORMAT,
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            };
            let descriptor = DrawDescriptor {
                vertex: "strip",
                fragment: Some("shade"),
                overrides,
                targets: &[Some(target)],
                ..DrawDescriptor::default()
            };
            library.draw(gpu, "ribbons", &descriptor)
        };
        Ok(Self {
            count: kernel("count")?,
            place: kernel("place")?,
            scatter: kernel("scatter")?,
            blended: draw(&[])?,
            opaque: draw(&[("OPAQUE", 1.0)])?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Tangle;

    #[test]
    fn ribbons_cover_and_composite_like_the_exact_picture() {
        let Some(mut tangle) = Tangle::new(2_000) else { return };
        let library = ShaderLibrary::embedded();
        let mut ribbons = Ribbons::new(&tangle.gpu, &library).expect("the ribbon shaders link");
        let picture = tangle.draw(|gpu, encoder, scene, target| {
            let input = RibbonInput {
                strands: scene.strands,
                radiance: scene.radiance,
                view: scene.view,
                head_depth: scene.head_depth,
                head_colour: scene.head_colour,
                opaque: false,
            };
            ribbons.record(gpu, &library, encoder, &input, target).expect("the ribbons bind");
        });
        let (rmse, coverage) = tangle.against_exact(&picture);
        println!("ribbons: rmse {rmse:.4}, coverage {coverage:.4} of exact");
        assert!((coverage - 1.0).abs() < 0.03, "coverage {coverage} of exact");
        assert!(rmse < 0.03, "rmse {rmse}");
    }
}
