//! How a stroke was looked at: where the hair's points lie on the window, and where the pointer lies in space.
//!
//! All in head space at rest: a head that is turned turns the eye the other way.

use glam::{Affine3A, Mat4, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::camera::Camera;

/// The camera and the window of a stroke, as data.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StrokeView {
    pub camera: Camera,
    /// Width and height of the viewport, in points of the window.
    pub size: [f32; 2],
    pub world_from_head: Affine3A,
}

impl Default for StrokeView {
    fn default() -> Self {
        Self { camera: Camera::default(), size: [1280.0, 720.0], world_from_head: Affine3A::IDENTITY }
    }
}

/// The same, made ready.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    clip_from_head: Mat4,
    head_from_clip: Mat4,
    size: Vec2,
    /// Head space.
    pub eye: Vec3,
    /// Unit vector from the eye into the picture.
    pub forward: Vec3,
}

impl View {
    pub fn new(view: &StrokeView) -> Self {
        let size = Vec2::from_array(view.size).max(Vec2::ONE);
        let world_from_head = Mat4::from(view.world_from_head);
        let clip_from_head = view.camera.clip_from_world(size.x / size.y) * world_from_head;
        let head_from_world = view.world_from_head.inverse();
        let forward = head_from_world.transform_vector3(-view.camera.eye_direction());
        Self {
            clip_from_head,
            head_from_clip: clip_from_head.inverse(),
            size,
            eye: head_from_world.transform_point3(view.camera.eye()),
            forward: forward.normalize_or(Vec3::NEG_Z),
        }
    }

    /// Where a place is on the window, in points from the viewport's upper left corner; `None` behind the eye.
    pub fn project(&self, p: Vec3) -> Option<Vec2> {
        let clip = self.clip_from_head * p.extend(1.0);
        (clip.w > 1e-4).then(|| self.points(clip))
    }

    fn points(&self, clip: Vec4) -> Vec2 {
        let ndc = Vec2::new(clip.x, clip.y) / clip.w;
        0.5 * self.size * Vec2::new(1.0 + ndc.x, 1.0 - ndc.y)
    }

    /// Distance in front of the eye, centimetres.
    pub fn depth(&self, p: Vec3) -> f32 {
        (p - self.eye).dot(self.forward)
    }

    /// The movement of a place that moves it by `points` on the window and not towards the eye.
    pub fn move_at(&self, p: Vec3, points: Vec2) -> Vec3 {
        let clip = self.clip_from_head * p.extend(1.0);
        let ndc = 2.0 * points / self.size * Vec2::new(1.0, -1.0);
        let moved = self.head_from_clip * (clip + Vec4::new(ndc.x * clip.w, ndc.y * clip.w, 0.0, 0.0));
        moved.truncate() / moved.w - p
    }

    /// Centimetres that a point of the window is wide at a place.
    pub fn cm_per_point(&self, p: Vec3) -> f32 {
        self.move_at(p, Vec2::X).length()
    }

    /// Origin and unit direction of the ray through a point of the window.
    pub fn ray(&self, at: Vec2) -> (Vec3, Vec3) {
        let ndc = 2.0 * at / self.size - 1.0;
        let through = self.head_from_clip.project_point3(Vec3::new(ndc.x, -ndc.y, 0.5));
        (self.eye, (through - self.eye).normalize_or(self.forward))
    }

    /// The place under a point of the window at a depth.
    pub fn at_depth(&self, at: Vec2, depth: f32) -> Vec3 {
        let (eye, ray) = self.ray(at);
        eye + depth / ray.dot(self.forward).max(1e-3) * ray
    }
}

/// The nearest hair to the eye in every patch of the window: what the pointer touches.
#[derive(Debug, Clone, Default)]
pub struct DepthMap {
    n: [usize; 2],
    depths: Vec<f32>,
}

/// Side of a patch, points of the window.
const PATCH: f32 = 8.0;
/// Patches around the pointer in which hair counts as touched.
const NEAR: i32 = 2;

impl DepthMap {
    /// Enter places of hair.
    pub fn new(view: &View, places: impl Iterator<Item = Vec3>) -> Self {
        let n = view.size.to_array().map(|side| (side / PATCH) as usize + 1);
        let mut map = Self { n, depths: vec![f32::INFINITY; n[0] * n[1]] };
        for p in places {
            let Some(at) = view.project(p) else { continue };
            let patch = (at / PATCH).floor();
            if patch.x >= 0.0 && patch.y >= 0.0 && (patch.x as usize) < n[0] && (patch.y as usize) < n[1] {
                let depth = &mut map.depths[patch.x as usize + n[0] * patch.y as usize];
                *depth = depth.min(view.depth(p));
            }
        }
        map
    }

    /// Depth of the hair under a point of the window; `None` where there is none.
    pub fn depth(&self, at: Vec2) -> Option<f32> {
        let patch = (at / PATCH).floor();
        let (x, y) = (patch.x as i32, patch.y as i32);
        let mut nearest = f32::INFINITY;
        for j in (y - NEAR).max(0)..=(y + NEAR).min(self.n[1] as i32 - 1) {
            for i in (x - NEAR).max(0)..=(x + NEAR).min(self.n[0] as i32 - 1) {
                nearest = nearest.min(self.depths[i as usize + self.n[0] * j as usize]);
            }
        }
        nearest.is_finite().then_some(nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_a_place_by_points_moves_its_picture_by_as_many() {
        let world_from_head = Affine3A::from_rotation_y(0.3) * Affine3A::from_translation(Vec3::new(1.0, 2.0, 0.0));
        let view = View::new(&StrokeView { world_from_head, ..StrokeView::default() });
        let p = Vec3::new(3.0, -2.0, 4.0);
        let at = view.project(p).unwrap();
        let by = Vec2::new(30.0, -12.0);
        let moved = p + view.move_at(p, by);
        assert!(view.project(moved).unwrap().distance(at + by) < 0.05);
        assert!((view.depth(moved) - view.depth(p)).abs() < 1e-2);
        assert!(view.at_depth(at, view.depth(p)).distance(p) < 1e-2);
        let (eye, ray) = view.ray(at);
        assert!((p - eye).normalize().dot(ray) > 0.99999);
    }

    #[test]
    fn the_nearest_hair_under_the_pointer_is_touched() {
        let view = View::new(&StrokeView::default());
        let (near, far) = (view.at_depth(Vec2::new(640.0, 360.0), 80.0), view.at_depth(Vec2::new(640.0, 360.0), 110.0));
        let map = DepthMap::new(&view, [far, near].into_iter());
        assert!((map.depth(Vec2::new(645.0, 356.0)).unwrap() - 80.0).abs() < 0.01);
        assert_eq!(map.depth(Vec2::new(300.0, 356.0)), None);
        assert_eq!(map.depth(Vec2::new(-1e6, 1e6)), None);
    }
}
