//! What the tests of the drawing techniques share: a tangle of strands, drawn by a technique and exactly.

use glam::{Vec3, Vec4};
use lorelei_core::camera::Camera;
use lorelei_shaders::Gpu;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

use crate::exact::{Backdrop, ExactStrands, composite};
use crate::mirror::{DrawnLayer, StrandBuffers};
use crate::view::View;

/// Side of the test pictures in pixels.
pub(crate) const SIZE: u32 = 128;
const PER_STRAND: usize = 8;
/// Every technique draws into it.
const FORMAT: TextureFormat = TextureFormat::Rgba16Float;

/// Strands as wide as hair and strands wider than pixels in a ball of 6 cm, each with its own colour.
pub(crate) struct Tangle {
    pub(crate) gpu: Gpu,
    vertices: Vec<Vec4>,
    radiance: Vec<[f32; 4]>,
    camera: Camera,
}

/// The tangle on the GPU, with no head.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) strands: &'a StrandBuffers,
    pub(crate) radiance: &'a wgpu::Buffer,
    pub(crate) view: &'a wgpu::Buffer,
    pub(crate) head_depth: &'a wgpu::TextureView,
    pub(crate) head_colour: &'a wgpu::TextureView,
}

impl Tangle {
    /// `None`, said aloud, where there is no GPU driver.
    pub(crate) fn new(n_strands: usize) -> Option<Self> {
        let Ok(gpu) = Gpu::headless() else {
            println!("skipped: no GPU driver here");
            return None;
        };
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 16) as f32 / 65_536.0
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
        Some(Self { gpu, vertices, radiance, camera: Camera { distance: 30.0, ..Camera::default() } })
    }

    /// Record, submit and read back a drawing: premultiplied linear RGB and alpha.
    pub(crate) fn draw(
        &mut self,
        mut record: impl FnMut(&Gpu, &mut wgpu::CommandEncoder, Scene<'_>, &wgpu::TextureView),
    ) -> Vec<[f64; 4]> {
        let gpu = &self.gpu;
        let usage = BufferUsages::STORAGE;
        let n_strands = (self.vertices.len() / PER_STRAND) as u32;
        let strands = StrandBuffers {
            vertices: gpu.buffer_of("test.vertices", &self.vertices, usage),
            seeds: gpu.buffer("test.seeds", 4, usage),
            layers: vec![DrawnLayer { n_strands, vertices_per_strand: PER_STRAND as u32, ..DrawnLayer::default() }],
            n_vertices: self.vertices.len() as u32,
            n_strands,
            generation: 0,
        };
        let half = |value: f32| u32::from(half::f16::from_f32(value).to_bits());
        let pack = |c: &[f32; 4]| [half(c[0]) | half(c[1]) << 16, half(c[2]) | half(c[3]) << 16];
        let packed: Vec<[u32; 2]> = self.radiance.iter().map(pack).collect();
        let texture = |label, format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let view_of = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        // No head: a fresh texture holds zeros, so its coverage is none.
        let head_depth = view_of(&texture("test.head_depth", TextureFormat::R32Float, TextureUsages::TEXTURE_BINDING));
        let head_colour = view_of(&texture("test.head_colour", FORMAT, TextureUsages::TEXTURE_BINDING));
        let target_usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let target = texture("test.target", FORMAT, target_usage);
        let scene = Scene {
            strands: &strands,
            radiance: &gpu.buffer_of("test.radiance", &packed, usage),
            view: &gpu.buffer_of("test.view", &[View::new(&self.camera, [SIZE; 2])], BufferUsages::UNIFORM),
            head_depth: &head_depth,
            head_colour: &head_colour,
        };
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        record(gpu, &mut encoder, scene, &view_of(&target));
        let pixels = gpu.buffer("test.pixels", u64::from(SIZE * SIZE * 8), usage);
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(SIZE * 8), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(target.as_image_copy(), to, target.size());
        gpu.queue.submit([encoder.finish()]);
        let pixels: Vec<[u16; 4]> = gpu.read_buffer(&pixels).expect("the picture comes back");
        pixels.iter().map(|pixel| pixel.map(|bits| half::f16::from_bits(bits).to_f64())).collect()
    }

    /// Root mean square error over all channels against the exact picture, and total coverage as a share of its.
    pub(crate) fn against_exact(&self, picture: &[[f64; 4]]) -> (f64, f64) {
        let exact = composite(
            ExactStrands { vertices: &self.vertices, vertices_per_strand: PER_STRAND, radiance: &self.radiance },
            self.camera.view_from_world(),
            self.camera.clip_from_view(1.0),
            [SIZE; 2],
            Backdrop::default(),
        );
        let (mut squares, mut covered, mut covered_exact) = (0.0, 0.0, 0.0);
        for (pixel, exact) in picture.iter().zip(&exact) {
            squares += (0..4).map(|channel| (pixel[channel] - exact[channel]).powi(2)).sum::<f64>();
            covered += pixel[3];
            covered_exact += exact[3];
        }
        (f64::sqrt(squares / (4 * exact.len()) as f64), covered / covered_exact)
    }
}
