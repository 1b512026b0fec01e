//! Two pictures of one size as one: side by side with a line between, or how far they are apart.

use lorelei_shaders::{Gpu, Hot, Kernel, ShaderError, ShaderLibrary};
use wgpu::BufferUsages;

/// How two pictures are seen together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Comparison {
    /// The first left of this share of the width, the second right of it.
    Wipe(f32),
    /// The absolute difference of their display values, times this.
    Difference(f32),
}

/// What one pixel shows of two, as display values 0-1, premultiplied. `x`: the pixel's column of `width`. Twin of
/// `versus.wgsl`.
pub fn compared(a: [f32; 4], b: [f32; 4], x: u32, width: u32, comparison: Comparison) -> [f32; 4] {
    match comparison {
        Comparison::Wipe(share) if (x as f32 + 0.5) < share * width as f32 => a,
        Comparison::Wipe(_) => b,
        Comparison::Difference(gain) => {
            let apart = |channel: usize| ((a[channel] - b[channel]).abs() * gain).min(1.0);
            [apart(0), apart(1), apart(2), 1.0]
        }
    }
}

/// Twin of `Versus` in `versus.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct VersusUniform {
    size: [u32; 2],
    wipe: f32,
    gain: f32,
}

struct Pictures {
    first: wgpu::Texture,
    output: wgpu::Texture,
}

/// Keeps the first picture while the second one is drawn, and puts both together.
pub struct Versus {
    kernel: Hot<Kernel>,
    uniform: wgpu::Buffer,
    pictures: Option<Pictures>,
}

impl Versus {
    pub fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        Ok(Self {
            kernel: Hot::new(library, |library| library.kernel(gpu, "versus", "compare", &[], &[]))?,
            uniform: gpu.buffer("versus.look", size_of::<VersusUniform>() as u64, BufferUsages::UNIFORM),
            pictures: None,
        })
    }

    /// Record a copy of the first picture, before the second one is drawn over it.
    pub fn keep(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, picture: &wgpu::Texture) {
        let kept = self.pictures.take().filter(|pictures| pictures.first.size() == picture.size());
        let pictures = kept.unwrap_or_else(|| {
            let make = |label| {
                gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size: picture.size(),
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: picture.format(),
                    usage: wgpu::TextureUsages::COPY_DST
                        | wgpu::TextureUsages::COPY_SRC
                        | wgpu::TextureUsages::TEXTURE_BINDING
                        | wgpu::TextureUsages::STORAGE_BINDING,
                    view_formats: &[],
                })
            };
            Pictures { first: make("versus.first"), output: make("versus.output") }
        });
        encoder.copy_texture_to_texture(picture.as_image_copy(), pictures.first.as_image_copy(), picture.size());
        self.pictures = Some(pictures);
    }

    /// Record both as one, into [`Versus::output`].
    pub fn record(
        &mut self,
        gpu: &Gpu,
        library: &ShaderLibrary,
        encoder: &mut wgpu::CommandEncoder,
        second: &wgpu::Texture,
        comparison: Comparison,
    ) -> Result<(), ShaderError> {
        self.kernel.refresh(library, |library| library.kernel(gpu, "versus", "compare", &[], &[]));
        let Some(pictures) = &self.pictures else { return Ok(()) };
        let size = [second.width(), second.height()];
        let (wipe, gain) = match comparison {
            Comparison::Wipe(share) => (share * size[0] as f32, -1.0),
            Comparison::Difference(gain) => (0.0, gain.max(0.0)),
        };
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&VersusUniform { size, wipe, gain }));
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (first, second, output) = (view(&pictures.first), view(second), view(&pictures.output));
        let bindings = self.kernel.bind(
            gpu,
            &[
                ("versus", self.uniform.as_entire_binding()),
                ("first", wgpu::BindingResource::TextureView(&first)),
                ("second", wgpu::BindingResource::TextureView(&second)),
                ("picture", wgpu::BindingResource::TextureView(&output)),
            ],
        )?;
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("versus"), timestamp_writes: None });
        self.kernel.dispatch(&mut pass, &bindings, [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
        Ok(())
    }

    /// Both pictures as one; `None` before the first [`Versus::keep`].
    pub fn output(&self) -> Option<&wgpu::Texture> {
        self.pictures.as_ref().map(|pictures| &pictures.output)
    }

    /// Free the pictures: nothing is compared any more.
    pub fn clear(&mut self) {
        self.pictures = None;
    }

    /// GPU memory held, bytes.
    pub fn n_bytes(&self) -> u64 {
        self.pictures.as_ref().map_or(0, |pictures| {
            let size = pictures.first.size();
            2 * 4 * u64::from(size.width) * u64::from(size.height)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [64, 8];

    #[test]
    fn the_gpu_compares_as_the_cpu_does() {
        let gpu = Gpu::headless().unwrap();
        let library = ShaderLibrary::embedded();
        let mut versus = Versus::new(&gpu, &library).unwrap();
        let bytes = |seed: u32| -> Vec<u8> {
            (0..SIZE[0] * SIZE[1] * 4).map(|i| (lorelei_core::hash::random(seed, i) * 256.0) as u8).collect()
        };
        let texture = |bytes: &[u8]| {
            let extent = wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 };
            let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("test"),
                size: extent,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::COPY_SRC
                    | wgpu::TextureUsages::COPY_DST
                    | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            });
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * SIZE[0]), rows_per_image: None };
            gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, extent);
            texture
        };
        let (a, b) = (bytes(1), bytes(2));
        let (first, second) = (texture(&a), texture(&b));
        for comparison in [Comparison::Wipe(0.3), Comparison::Wipe(1.0), Comparison::Difference(3.0)] {
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            versus.keep(&gpu, &mut encoder, &first);
            versus.record(&gpu, &library, &mut encoder, &second, comparison).unwrap();
            let staging = gpu.buffer("test.pixels", u64::from(4 * SIZE[0] * SIZE[1]), BufferUsages::STORAGE);
            encoder.copy_texture_to_buffer(
                versus.output().unwrap().as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &staging,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(4 * SIZE[0]),
                        rows_per_image: None,
                    },
                },
                second.size(),
            );
            gpu.queue.submit([encoder.finish()]);
            let got: Vec<[u8; 4]> = gpu.read_buffer(&staging).unwrap();
            for (i, got) in got.iter().enumerate() {
                let value = |bytes: &[u8]| [0, 1, 2, 3].map(|c| f32::from(bytes[4 * i + c]) / 255.0);
                let expected = compared(value(&a), value(&b), i as u32 % SIZE[0], SIZE[0], comparison);
                for (got, expected) in got.iter().zip(expected) {
                    assert!((f32::from(*got) / 255.0 - expected).abs() < 0.6 / 255.0, "{comparison:?} at {i}");
                }
            }
        }
    }

    #[test]
    fn a_wipe_shows_one_on_each_side_and_the_difference_of_equals_is_black() {
        let (a, b) = ([0.2, 0.4, 0.6, 1.0], [0.3, 0.3, 0.3, 1.0]);
        assert_eq!(compared(a, b, 24, 100, Comparison::Wipe(0.25)), a);
        assert_eq!(compared(a, b, 25, 100, Comparison::Wipe(0.25)), b);
        assert_eq!(compared(a, b, 0, 100, Comparison::Wipe(0.0)), b);
        assert_eq!(compared(a, b, 99, 100, Comparison::Wipe(1.0)), a);
        assert_eq!(compared(a, a, 0, 100, Comparison::Difference(8.0)), [0.0, 0.0, 0.0, 1.0]);
    }
}
