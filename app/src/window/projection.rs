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

    /// Centimetres that one point of the window is at the depth of `world`.
    pub fn cm_per_point(&self, world: Vec3) -> f32 {
        let clip = self.clip_from_world * world.extend(1.0);
        let row = self.clip_from_world.row(1).truncate().length().max(1e-6);
        2.0 * clip.w.abs() / (row * self.rect.height().max(1.0))
    }

    /// Takes a place to points of the window once x and y are divided by w.
    pub fn screen_from_world(&self) -> Mat4 {
        let (centre, half) = (self.rect.center(), 0.5 * self.rect.size());
        let to_points = Mat4::from_translation(Vec3::new(centre.x, centre.y, 0.0))
            * Mat4::from_scale(Vec3::new(half.x, -half.y, 1.0));
        to_points * self.clip_from_world
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

#[cfg(test)]
mod tests {
    use egui::vec2;

    use super::*;

    #[test]
    fn a_point_of_the_window_is_as_large_as_it_is_said_to_be() {
        let camera = Camera { target: Vec3::new(0.0, 5.0, 0.0), ..Camera::default() };
        let projection = Projection::new(&camera, Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 600.0)));
        let world = Vec3::new(1.0, 4.0, 2.0);
        let up = camera.view_from_world().inverse().y_axis.truncate();
        let (a, b) = (projection.point(world).unwrap(), projection.point(world + up).unwrap());
        assert!((a.distance(b) * projection.cm_per_point(world) - 1.0).abs() < 0.02);
        let (origin, ray) = projection.ray(a);
        let t = (world - origin).dot(ray);
        assert!((origin + t * ray).distance(world) < 1e-2);
    }
}
