//! Where the window finds the stage's picture: a texture on the window's device that stays while the next
//! picture is drawn.
//!
//! On a GPU the stage draws on the window's own device, and the picture is copied there. A software driver
//! works through one queue in order, so a window that shared it would stand still for the seconds that a
//! frame takes: there the stage has a device of its own and its pixels are carried over.

use lorelei_shaders::{Gpu, GpuError};

/// The window's end of the stage.
pub struct Display {
    window: Gpu,
    /// The stage draws on another device. Devices of two instances cannot be compared: their numbers are alike.
    is_apart: bool,
    shown: Option<wgpu::Texture>,
    /// Pixels on their way, where the devices differ.
    staging: Option<wgpu::Buffer>,
}

impl Display {
    /// `is_apart`: the stage's device is not the window's.
    pub fn new(window: Gpu, is_apart: bool) -> Self {
        Self { window, is_apart, shown: None, staging: None }
    }

    /// The picture to show; another texture whenever its size changes.
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        self.shown.as_ref()
    }

    /// Record what brings a picture drawn on `gpu` over; [`Display::finish`] follows after the submission.
    pub fn record(&mut self, gpu: &Gpu, output: &wgpu::Texture, encoder: &mut wgpu::CommandEncoder) {
        if self.shown.as_ref().is_none_or(|shown| shown.size() != output.size()) {
            self.shown = Some(self.window.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("stage.shown"),
                size: output.size(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: output.format(),
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            }));
        }
        let Some(shown) = &self.shown else { return };
        if !self.is_apart {
            encoder.copy_texture_to_texture(output.as_image_copy(), shown.as_image_copy(), output.size());
            return;
        }
        let size = u64::from(row_bytes(output)) * u64::from(output.height());
        let staging = match self.staging.take().filter(|staging| staging.size() == size) {
            Some(staging) => staging,
            None => gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage.pixels"),
                size,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        };
        let layout = row_layout(output);
        encoder.copy_texture_to_buffer(
            output.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &staging, layout },
            output.size(),
        );
        self.staging = Some(staging);
    }

    /// Wait for the picture and hand it to the window's device.
    pub fn finish(&mut self, gpu: &Gpu, output: &wgpu::Texture) -> Result<(), GpuError> {
        let (Some(shown), Some(staging)) = (&self.shown, &self.staging) else { return gpu.wait() };
        gpu.read_mapped(staging, |bytes| {
            self.window.queue.write_texture(shown.as_image_copy(), bytes, row_layout(output), output.size());
        })?;
        // Nothing else may be submitted soon: the window draws when it wants to.
        self.window.queue.submit([]);
        Ok(())
    }
}

/// Bytes of a row in a buffer, of a picture with four bytes a pixel.
fn row_bytes(texture: &wgpu::Texture) -> u32 {
    (4 * texture.width()).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

fn row_layout(texture: &wgpu::Texture) -> wgpu::TexelCopyBufferLayout {
    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes(texture)), rows_per_image: None }
}
