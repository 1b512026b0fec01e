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

    /// Move the target and the distance so that points just fill the picture, from where it looks now. Points that are not
    /// finite are left out; without any it stays.
    pub fn fit(&mut self, points: impl IntoIterator<Item = Vec3>, aspect: f32) {
        let axes = self.view_from_world();
        let tan_y = MARGIN * (0.5 * self.fov_y_deg.to_radians()).tan();
        let tan_x = tan_y * aspect;
        // Compute how far out the pyramid's four sides must be, and how near and far the points are.
        let mut sides = [f32::NEG_INFINITY; 4];
        let (mut nearest, mut farthest) = (f32::NEG_INFINITY, f32::INFINITY);
        for p in points.into_iter().filter(|p| p.is_finite()) {
            let p = axes.transform_vector3(p);
            for (side, out) in
                sides.iter_mut().zip([p.x, -p.x, p.y, -p.y].into_iter().zip([tan_x, tan_x, tan_y, tan_y]))
            {
                *side = side.max(out.0 + out.1 * p.z);
            }
            (nearest, farthest) = (nearest.max(p.z), farthest.min(p.z));
        }
        if nearest < farthest {
            return;
        }
        let [right, left, up, down] = sides;
        let eye_z = (0.5 * (right + left) / tan_x).max(0.5 * (up + down) / tan_y).max(nearest + 1.0);
        let middle = Vec3::new(0.5 * (right - left), 0.5 * (up - down), 0.5 * (nearest + farthest));
        self.target = axes.inverse().transform_vector3(middle);
        self.distance = eye_z - middle.z;
    }
}

/// Share of the picture that [`Camera::fit`] fills.
const MARGIN: f32 = 0.96;

/// Unit vector towards an azimuth (0 = +Z, 90 = +X) and elevation.
pub fn direction_from_deg(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let (sin_az, cos_az) = azimuth_deg.to_radians().sin_cos();
    let (sin_el, cos_el) = elevation_deg.to_radians().sin_cos();
    Vec3::new(sin_az * cos_el, sin_el, cos_az * cos_el)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_that_fits_points_fills_the_picture_with_them_and_cuts_none_off() {
        for (azimuth_deg, elevation_deg, aspect) in
            [(0.0, 0.0, 1.0), (40.0, 5.0, 0.8), (140.0, -30.0, 2.0), (90.0, 90.0, 1.0)]
        {
            let mut camera = Camera { azimuth_deg, elevation_deg, ..Camera::default() };
            // A head and a jump of 40 cm.
            let points: Vec<Vec3> = (0..200)
                .map(|i| (Vec3::new((i as f32).sin(), (1.7 * i as f32).sin(), (2.3 * i as f32).sin()), i))
                .map(|(p, i)| 12.0 * p + if i % 2 == 0 { Vec3::new(3.0, 40.0, 7.0) } else { Vec3::ZERO })
                .collect();
            camera.fit(points.iter().copied().chain([Vec3::NAN]), aspect);
            let seen = points.iter().map(|p| camera.clip_from_world(aspect).project_point3(*p));
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            seen.for_each(|p| (low, high) = (low.min(p), high.max(p)));
            assert!(low.min_element() > -0.97 && high.max_element() < 1.0, "{low} {high}");
            let fills = (high - low) * 0.5;
            assert!((fills.x.max(fills.y) - MARGIN).abs() < 0.02, "{azimuth_deg}: {low} {high}");
        }
        let before = Camera::default();
        let mut camera = before;
        camera.fit([Vec3::NAN], 1.0);
        assert_eq!(camera, before);
    }
}
