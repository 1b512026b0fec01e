//! How the pointer moves the camera: as in Blender (middle button) and as in Maya (Alt and any button).

use egui::{PointerButton, Response, Vec2};
use lorelei_core::camera::Camera;

/// Degrees an orbit turns over one viewport height; zoom a drag of that length does.
const DEG_PER_HEIGHT: f32 = 180.0;
const ZOOM_PER_HEIGHT: f32 = 3.0;
/// Distance lost by one point of wheel scroll (a notch is about 50).
const ZOOM_PER_SCROLL: f32 = 0.0025;

/// Move the camera by what the pointer did over the viewport in this frame; true where it moved.
pub fn navigate(camera: &mut Camera, response: &Response, ui: &egui::Ui) -> bool {
    let before = *camera;
    let height = response.rect.height().max(1.0);
    let modifiers = ui.input(|input| input.modifiers);
    let drag = response.drag_delta();
    if response.dragged_by(PointerButton::Middle) {
        if modifiers.shift || modifiers.alt {
            pan(camera, drag, height);
        } else if modifiers.command {
            zoom(camera, (ZOOM_PER_HEIGHT * drag.y / height).exp());
        } else {
            orbit(camera, drag, height);
        }
    } else if modifiers.alt && response.dragged_by(PointerButton::Primary) {
        orbit(camera, drag, height);
    } else if modifiers.alt && response.dragged_by(PointerButton::Secondary) {
        zoom(camera, (ZOOM_PER_HEIGHT * (drag.y - drag.x) / height).exp());
    }
    if response.contains_pointer() {
        let (scroll, pinch) = ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
        if scroll != 0.0 {
            zoom(camera, (-ZOOM_PER_SCROLL * scroll).exp());
        }
        if pinch != 1.0 && scroll == 0.0 {
            zoom(camera, 1.0 / pinch);
        }
    }
    *camera != before
}

fn orbit(camera: &mut Camera, drag: Vec2, height: f32) {
    camera.azimuth_deg = wrapped(camera.azimuth_deg - DEG_PER_HEIGHT * drag.x / height);
    camera.elevation_deg = (camera.elevation_deg + DEG_PER_HEIGHT * drag.y / height).clamp(-89.0, 89.0);
}

/// The point under the pointer stays under it, at the target's depth.
fn pan(camera: &mut Camera, drag: Vec2, height: f32) {
    let cm_per_point = 2.0 * camera.distance * (0.5 * camera.fov_y_deg.to_radians()).tan() / height;
    let world_from_view = camera.view_from_world().inverse();
    let right = world_from_view.x_axis.truncate();
    let up = world_from_view.y_axis.truncate();
    camera.target += cm_per_point * (drag.y * up - drag.x * right);
}

fn zoom(camera: &mut Camera, factor: f32) {
    camera.distance = (camera.distance * factor).clamp(2.0, 5000.0);
}

fn wrapped(deg: f32) -> f32 {
    (deg + 180.0).rem_euclid(360.0) - 180.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pan_carries_the_target_with_the_pointer() {
        let mut camera = Camera::default();
        let height = 600.0;
        let before = camera;
        pan(&mut camera, Vec2::new(30.0, 0.0), height);
        // The old target is now 30 of 600 points to the right of the middle: 0.1 of half the height.
        let clip = camera.clip_from_world(1.0).project_point3(before.target);
        assert!((clip.x - 0.1).abs() < 1e-3 && clip.y.abs() < 1e-3, "{clip}");
    }

    #[test]
    fn an_orbit_never_goes_over_the_pole() {
        let mut camera = Camera::default();
        orbit(&mut camera, Vec2::new(0.0, 5000.0), 600.0);
        assert!(camera.elevation_deg <= 89.0);
        assert!((-180.0..=180.0).contains(&camera.azimuth_deg));
    }
}
