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

    pub fn shader_error(&self) -> Option<&ShaderError> {
        self.pipelines.error()
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
    use glam::{Vec3, Vec4};
    use lorelei_core::camera::Camera;

    use super::*;
    use crate::exact::{Backdrop, ExactStrands, composite};
    use crate::view::View;

    const SIZE: [u32; 2] = [128, 128];
    const PER_STRAND: usize = 8;

    /// Strands as wide as hair and strands wider than pixels, in a ball of 4 cm, each with its own colour.
    fn tangle(n_strands: usize) -> (Vec<Vec4>, Vec<[f32; 4]>) {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            f32::from(((state >> 16) & 0x7fff) as u16) / 32_768.0
        };
        let (mut vertices, mut radiance) = (Vec::new(), Vec::new());
        for strand_idx in 0..n_strands {
            let mut at = Vec3::new(random(), random(), random()) * 6.0 - 3.0;
            let step = (Vec3::new(random(), random(), random()) - 0.5).normalize_or(Vec3::X) * 0.5;
            let radius = if strand_idx % 20 == 0 { 0.06 } else { 0.008 };
            let colour = [random(), random(), random(), 1.0];
            for _ in 0..PER_STRAND {
                vertices.push(at.extend(radius));
                radiance.push(colour);
                at += step + (Vec3::new(random(), random(), random()) - 0.5) * 0.1;
            }
        }
        (vertices, radiance)
    }

    fn halves(colour: &[f32; 4]) -> [u32; 2] {
        let half = |value: f32| u32::from(half::f16::from_f32(value).to_bits());
        [half(colour[0]) | half(colour[1]) << 16, half(colour[2]) | half(colour[3]) << 16]
    }

    #[test]
    fn ribbons_cover_and_composite_like_the_exact_picture() {
        let Ok(gpu) = Gpu::headless() else {
            println!("skipped: no GPU driver here");
            return;
        };
        let library = ShaderLibrary::embedded();
        let (vertices, radiance) = tangle(2_000);
        let camera = Camera { distance: 30.0, ..Camera::default() };
        let view = View::new(&camera, SIZE);
        let usage = BufferUsages::STORAGE;
        let packed: Vec<[u32; 2]> = radiance.iter().map(halves).collect();
        let strands = StrandBuffers {
            vertices: gpu.buffer_of("test.vertices", &vertices, usage),
            seeds: gpu.buffer("test.seeds", 4, usage),
            layers: vec![DrawnLayer {
                n_strands: (vertices.len() / PER_STRAND) as u32,
                vertices_per_strand: PER_STRAND as u32,
                ..DrawnLayer::default()
            }],
            n_vertices: vertices.len() as u32,
            n_strands: (vertices.len() / PER_STRAND) as u32,
            widest: 0.01,
            generation: 0,
        };
        let texture = |label, format, usage| {
            let descriptor = wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            };
            gpu.device.create_texture(&descriptor)
        };
        // No head: depth 0 and coverage 0 are what fresh textures hold.
        let head_depth = texture("test.head_depth", TextureFormat::R32Float, wgpu::TextureUsages::TEXTURE_BINDING);
        let head_colour = texture("test.head_colour", FORMAT, wgpu::TextureUsages::TEXTURE_BINDING);
        let target_usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let target = texture("test.target", FORMAT, target_usage);
        let view_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut ribbons = Ribbons::new(&gpu, &library).expect("the ribbon shaders link");
        let input = RibbonInput {
            strands: &strands,
            radiance: &gpu.buffer_of("test.radiance", &packed, usage),
            view: &gpu.buffer_of("test.view", &[view], BufferUsages::UNIFORM),
            head_depth: &view_of(&head_depth),
            head_colour: &view_of(&head_colour),
            opaque: false,
        };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        ribbons.record(&gpu, &library, &mut encoder, &input, &view_of(&target)).expect("the ribbons bind");
        let staging = gpu.buffer("test.pixels", u64::from(SIZE[0] * SIZE[1] * 8), BufferUsages::STORAGE);
        encoder.copy_texture_to_buffer(
            target.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(SIZE[0] * 8),
                    rows_per_image: None,
                },
            },
            target.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let pixels: Vec<[u16; 4]> = gpu.read_buffer(&staging).expect("the picture comes back");
        let full = |bits: u16| half::f16::from_bits(bits).to_f64();
        let exact = composite(
            &[ExactStrands { vertices: &vertices, vertices_per_strand: PER_STRAND, radiance: &radiance }],
            camera.view_from_world(),
            camera.clip_from_view(1.0),
            SIZE,
            Backdrop::default(),
        );
        let (mut squares, mut covered, mut covered_exact) = (0.0, 0.0, 0.0);
        for (pixel, exact) in pixels.iter().zip(&exact) {
            for channel in 0..4 {
                squares += (full(pixel[channel]) - exact[channel]).powi(2);
            }
            covered += full(pixel[3]);
            covered_exact += exact[3];
        }
        let rmse = f64::sqrt(squares / (4 * exact.len()) as f64);
        println!("ribbons: rmse {rmse:.4}, coverage {:.4} of exact", covered / covered_exact);
        assert!((covered / covered_exact - 1.0).abs() < 0.03, "coverage {covered} against {covered_exact}");
        assert!(rmse < 0.03, "rmse {rmse}");
    }
}
