//! From the world to points of the window and back: what every handle and tool needs to know where the pointer is.

use egui::{Pos2, Rect, pos2};
use glam::{Mat4, Vec3};
use lorelei_core::camera::Camera;

/// Maps the world to points of the window.
#[derive(Clone, Copy)]
pub struct Projection {
    clip_from_world: Mat4,
    rect: Rect,
}

impl Projection {
    pub fn new(camera: &Camera, rect: Rect) -> Self {
        Self { clip_from_world: camera.clip_from_world(rect.width() / rect.height().max(1.0)), rect }
    }

    /// The projection of points that `world_from_space` puts into the world.
    pub fn after(&self, world_from_space: Mat4) -> Self {
        Self { clip_from_world: self.clip_from_world * world_from_space, rect: self.rect }
    }

    /// Width of the window's part over its height.
    pub fn aspect(&self) -> f32 {
        self.rect.width() / self.rect.height().max(1.0)
    }

    /// `None` behind the eye.
    pub fn point(&self, world: Vec3) -> Option<Pos2> {
        let clip = self.clip_from_world * world.extend(1.0);
        (clip.w > 1e-4).then(|| {
            let ndc = clip.truncate() / clip.w;
            let centre = self.rect.center();
            pos2(centre.x + 0.5 * ndc.x * self.rect.width(), centre.y - 0.5 * ndc.y * self.rect.height())
        })
    }

    pub fn rect(&self) -> Rect {
        self.rect
    }

    /// Origin and unit direction of the ray through a point of the window.
    pub fn ray(&self, at: Pos2) -> (Vec3, Vec3) {
        let centre = self.rect.center();
        let x = 2.0 * (at.x - centre.x) / self.rect.width();
        let y = -2.0 * (at.y - centre.y) / self.rect.height();
        let world_from_clip = self.clip_from_world.inverse();
        let near = world_from_clip.project_point3(Vec3::new(x, y, 0.0));
        let far = world_from_clip.project_point3(Vec3::new(x, y, 0.5));
        (near, (far - near).normalize_or(Vec3::NEG_Z))
    }
}
