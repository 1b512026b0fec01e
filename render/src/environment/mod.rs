//! Light from all around, from a picture: its harmonics for hair and skin, its texels for the background, and the probes that
//! ask what is in its way.
//!
//! The picture is projected once, when it is another one; turning and exposing it are a few multiplications a frame.

pub mod harmonics;
pub mod lit;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use lorelei_core::camera::direction_from_deg;
use lorelei_core::look::{Background, Look};
use lorelei_core::panorama::Panorama;
use lorelei_shaders::Gpu;

pub use harmonics::Harmonics;
pub use lit::Lights;

/// Directions that probes look in: corners of a tetrahedron, one of them in front and above, and one below.
pub fn probe_directions() -> [Vec3; 4] {
    // asin(1/3): what balances the one below.
    const UP_DEG: f32 = 19.471_22;
    [
        direction_from_deg(0.0, UP_DEG),
        direction_from_deg(120.0, UP_DEG),
        direction_from_deg(-120.0, UP_DEG),
        Vec3::NEG_Y,
    ]
}

/// Twin of the last fields of `Scene` in `shade_lights.wgsl`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct EnvironmentUniform {
    radiance: [[f32; 4]; harmonics::N_COEFFICIENTS],
    irradiance: [[f32; 4]; 9],
}

impl EnvironmentUniform {
    /// No light.
    pub fn dark() -> Self {
        Self::zeroed()
    }

    pub fn new(lights: &Lights) -> Self {
        let padded = |v: Vec3| v.extend(0.0).to_array();
        Self { radiance: lights.radiance.map(padded), irradiance: lights.irradiance.map(padded) }
    }
}

/// Turn (radians) and scale of the look's picture.
pub fn turn_and_gain(look: &Look) -> (f32, f32) {
    let picture = &look.environment_picture;
    (picture.rotation_deg.to_radians(), picture.exposure.exp2())
}

/// Harmonics of a picture as the look turns and exposes it.
pub fn lights_of(harmonics: &Harmonics, look: &Look) -> Lights {
    let (turn, gain) = turn_and_gain(look);
    let turned = harmonics.turned(turn, gain);
    Lights { radiance: turned.tapered(), irradiance: turned.cosine_weighted() }
}

/// The picture that is in use, on the GPU.
#[derive(Debug)]
pub struct EnvironmentPicture {
    /// What was projected, and what is in the texture.
    projected: Option<(Arc<Panorama>, Harmonics)>,
    sent: Option<Arc<Panorama>>,
    texture: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

impl EnvironmentPicture {
    pub fn new(gpu: &Gpu) -> Self {
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("environment"),
            address_mode_u: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        Self { projected: None, sent: None, texture: texture(gpu, [1, 1], &[0; 4]), sampler }
    }

    /// Take over the picture as far as the look asks for it. Returns what the scene is lit by.
    pub fn update(&mut self, gpu: &Gpu, look: &Look, picture: impl FnOnce() -> Arc<Panorama>) -> EnvironmentUniform {
        let is_behind = match look.background {
            Background::Environment => true,
            Background::Gradient | Background::Plain | Background::Transparent => false,
        };
        if !is_behind && !look.environment.is_pictured() {
            return EnvironmentUniform::dark();
        }
        let picture = picture();
        if is_behind && self.sent.as_ref().is_none_or(|sent| !Arc::ptr_eq(sent, &picture)) {
            let texels = picture.texels.chunks_exact(3).flat_map(|texel| [texel[0], texel[1], texel[2], 1.0]);
            let halves: Vec<u16> = texels.map(crate::scattering::tables::half).collect();
            self.texture = texture(gpu, [picture.width, picture.height], &halves);
            self.sent = Some(Arc::clone(&picture));
        }
        if !look.environment.is_pictured() {
            return EnvironmentUniform::dark();
        }
        let harmonics = match &self.projected {
            Some((known, harmonics)) if Arc::ptr_eq(known, &picture) => *harmonics,
            _ => {
                let harmonics = Harmonics::of(&picture);
                self.projected = Some((picture, harmonics));
                harmonics
            }
        };
        EnvironmentUniform::new(&lights_of(&harmonics, look))
    }

    /// By the names of `background_environment.wgsl`.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 2] {
        [
            ("panorama", wgpu::BindingResource::TextureView(&self.texture)),
            ("panorama_sampler", wgpu::BindingResource::Sampler(&self.sampler)),
        ]
    }
}

fn texture(gpu: &Gpu, [width, height]: [u32; 2], halves: &[u16]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("environment.panorama"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(8 * width), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(halves), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
