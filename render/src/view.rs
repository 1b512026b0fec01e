//! The camera as shaders see it: twin of `View` in `camera.wgsl`.

use glam::Mat4;
use lorelei_core::camera::Camera;

/// Uniform of every pass that projects.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct View {
    pub clip_from_world: Mat4,
    pub view_from_world: Mat4,
    /// World, centimetres.
    pub eye: [f32; 3],
    /// Pixels of one centimetre at one centimetre from the eye.
    pub pixels_per_tangent: f32,
    /// Pixels.
    pub size: [u32; 2],
    pub near: f32,
    pub far: f32,
}

impl View {
    /// `size` in pixels, both at least 1.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let aspect = size[0] as f32 / size[1] as f32;
        let (near, far) = camera.near_far();
        Self {
            clip_from_world: camera.clip_from_world(aspect),
            view_from_world: camera.view_from_world(),
            eye: camera.eye().to_array(),
            pixels_per_tangent: 0.5 * size[1] as f32 / (0.5 * camera.fov_y_deg.to_radians()).tan(),
            size,
            near,
            far,
        }
    }
}
