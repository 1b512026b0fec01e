//! A painted map shown on the scalp: its texels on the GPU, and the colours of its values.
//!
//! Only tiles that changed are sent. The head's pass draws it (head_surface.wgsl, head_shade.wgsl), so that hair, light
//! and the head's outline are the picture's own.

use std::sync::Arc;

use lorelei_core::maps::{ScalpMap, TILE_SIDE};
use lorelei_shaders::Gpu;

/// How much of the hair is drawn over an overlay.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Veil {
    #[default]
    Full,
    /// One strand in twelve, no wider: the scalp is seen through it.
    Thin,
    Hidden,
}

impl Veil {
    pub const ALL: [Self; 3] = [Self::Full, Self::Thin, Self::Hidden];
    /// Share of the strands that [`Veil::Thin`] leaves.
    pub const THIN: f32 = 1.0 / 12.0;
}

/// What is shown on the scalp instead of skin.
#[derive(Debug, Clone)]
pub struct Overlay {
    pub map: Arc<ScalpMap>,
    /// Texel value that is shown as [`RAMP`]'s end: 255, or less for maps that are mostly low.
    pub full_texel: u8,
    pub veil: Veil,
}

impl PartialEq for Overlay {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.map, &other.map) && (self.full_texel, self.veil) == (other.full_texel, other.veil)
    }
}

/// Colours of values from none to most, evenly spaced, sRGB: told apart by those who see no red or no green, and as
/// greys in the same order. Twin of RAMP in head_shade.wgsl.
pub const RAMP: [[f32; 3]; 5] =
    [[0.16, 0.12, 0.33], [0.20, 0.36, 0.55], [0.13, 0.57, 0.55], [0.48, 0.78, 0.35], [0.99, 0.90, 0.20]];

/// The ramp's colour of a share, 0-1, sRGB.
pub fn ramp(share: f32) -> [f32; 3] {
    let x = share.clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let i = (x as usize).min(RAMP.len() - 2);
    std::array::from_fn(|c| RAMP[i][c] + (x - i as f32) * (RAMP[i + 1][c] - RAMP[i][c]))
}

/// The map's texels on the GPU.
pub(crate) struct OverlayTexture {
    shown: Option<Overlay>,
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

impl OverlayTexture {
    pub fn new(gpu: &Gpu) -> Self {
        let (texture, view) = make_texture(gpu, [1, 1]);
        Self { shown: None, texture, view }
    }

    /// Show a map, or none. Returns how many tiles were sent.
    pub fn set(&mut self, gpu: &Gpu, overlay: Option<&Overlay>) -> usize {
        let mut n_sent = 0;
        if let Some(overlay) = overlay.filter(|overlay| overlay.map.has_texels()) {
            let size = [overlay.map.width(), overlay.map.height()];
            let same_size = [self.texture.width(), self.texture.height()] == size;
            let known = self.shown.take().filter(|_| same_size);
            if !same_size {
                (self.texture, self.view) = make_texture(gpu, size);
            }
            let send_all = known.is_none();
            for (tile_idx, tile) in overlay.map.tiles().iter().enumerate() {
                let is_known = known.as_ref().is_some_and(|known| Arc::ptr_eq(&known.map.tiles()[tile_idx], tile));
                if !send_all && is_known {
                    continue;
                }
                let [x, y, width, height] = overlay.map.tile_rect(tile_idx as u32);
                gpu.queue.write_texture(
                    wgpu::TexelCopyTextureInfo {
                        texture: &self.texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d { x, y, z: 0 },
                        aspect: wgpu::TextureAspect::All,
                    },
                    &tile.0,
                    wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(TILE_SIDE), rows_per_image: None },
                    wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                );
                n_sent += 1;
            }
        }
        self.shown = overlay.filter(|overlay| overlay.map.has_texels()).cloned();
        n_sent
    }

    pub fn shown(&self) -> Option<&Overlay> {
        self.shown.as_ref()
    }
}

fn make_texture(gpu: &Gpu, [width, height]: [u32; 2]) -> (wgpu::Texture, wgpu::TextureView) {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("head.overlay"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R8Unorm,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    (texture, view)
}
