//! The orbit camera of the viewport and of `lorelei render`. It is not part of the document.

use glam::camera::rh::{proj, view};
use glam::{Mat4, Vec3};
use serde::{Deserialize, Serialize};

/// A camera that looks at a target from an azimuth, an elevation and a distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Centimetres, world.
    pub target: Vec3,
    /// 0 looks at the front (from +Z), 90 at the model's left side (from +X), 180 at the back.
    pub azimuth_deg: f32,
    /// Above the horizon.
    pub elevation_deg: f32,
    /// From target to eye, centimetres.
    pub distance: f32,
    /// Vertical field of view. 24 degrees is an 85 mm portrait lens.
    pub fov_y_deg: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self { target: Vec3::ZERO, azimuth_deg: 35.0, elevation_deg: 5.0, distance: 100.0, fov_y_deg: 24.0 }
    }
}

impl Camera {
    /// Unit vector from the target to the eye.
    pub fn eye_direction(&self) -> Vec3 {
        direction_from_deg(self.azimuth_deg, self.elevation_deg)
    }

    pub fn eye(&self) -> Vec3 {
        self.target + self.distance * self.eye_direction()
    }

    /// Rotation and translation into view space: right-handed, looking along -Z.
    pub fn view_from_world(&self) -> Mat4 {
        // Straight up or down the world's Y is no up vector: take it a hair's breadth from the pole.
        let elevation_deg = self.elevation_deg.clamp(-89.9, 89.9);
        let eye = self.target + self.distance * direction_from_deg(self.azimuth_deg, elevation_deg);
        view::look_at_mat4(eye, self.target, Vec3::Y)
    }

    /// Near and far planes around the target, wide enough for any groom in view.
    pub fn near_far(&self) -> (f32, f32) {
        ((self.distance * 0.02).max(0.05), self.distance * 4.0 + 400.0)
    }

    /// Perspective projection with depth 0 at the near plane and 1 at the far plane.
    pub fn clip_from_view(&self, aspect: f32) -> Mat4 {
        let (near, far) = self.near_far();
        proj::directx::perspective(self.fov_y_deg.to_radians(), aspect, near, far)
    }

    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        self.clip_from_view(aspect) * self.view_from_world()
    }

    /// Move the target and the distance so that a box fills the picture.
    pub fn frame(&mut self, (min, max): (Vec3, Vec3), aspect: f32) {
        let half = 0.5 * (max - min);
        self.target = 0.5 * (min + max);
        // A box turns under an orbit: take the widest half width, so that no azimuth crops it.
        let half_width = half.x.hypot(half.z).max(1e-3);
        let tan_y = (0.5 * self.fov_y_deg.to_radians()).tan();
        // What stands out highest and lowest of a head is hardly nearer than its middle.
        self.distance =
            (1.02 * half.y / tan_y + 0.15 * half_width).max(1.05 * half_width / (tan_y * aspect.min(4.0)) + 1.0);
    }
}

/// Unit vector towards an azimuth (0 = +Z, 90 = +X) and elevation.
pub fn direction_from_deg(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let (sin_az, cos_az) = azimuth_deg.to_radians().sin_cos();
    let (sin_el, cos_el) = elevation_deg.to_radians().sin_cos();
    Vec3::new(sin_az * cos_el, sin_el, cos_az * cos_el)
}
