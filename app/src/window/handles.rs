//! What can be grabbed in the viewport: a disc for each light on a sphere around the head, a handle at the neck, and grips
//! of whatever else stands in the scene.

use egui::{Align2, Color32, CursorIcon, Rect, Sense, Stroke, Ui, vec2};
use glam::Vec3;
use lorelei_core::camera::Camera;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;

use super::desk::{Desk, Selection};
use super::projection::Projection;
use super::theme;

/// What is being dragged; kept by the viewport between frames.
#[derive(Debug, Clone, Copy, Default)]
pub struct HandleDrag {
    /// The light's disc is on the far side of the sphere.
    is_behind: bool,
    /// The pointer left the sphere's outline, where the disc changes sides.
    was_outside: bool,
}

/// The disc of every light; a drag moves the light over the sphere.
pub fn lights(ui: &mut Ui, desk: &mut Desk, projection: Projection, drag: &mut HandleDrag) {
    let (centre, radius) = (desk.centre(), desk.light_radius(projection.aspect()));
    let eye = desk.camera.eye();
    let selected = desk.selection;
    if let Selection::Light(_) = selected {
        outline(ui, desk, projection);
    }
    for light_idx in 0..desk.document.groom.lights.len() {
        let light = desk.document.groom.lights[light_idx].clone();
        let direction = light.direction_to(centre);
        let at_world = centre + radius * direction;
        let Some(at) = projection.point(at_world) else { continue };
        let is_behind = (at_world - centre).dot(eye - centre) < 0.0;
        let is_selected = selected == Selection::Light(light_idx);
        let id = ui.scope_id().with(("light", light_idx));
        let response = ui.interact(Rect::from_center_size(at, vec2(24.0, 24.0)), id, Sense::click_and_drag());
        super::state_report::mark(ui.ctx(), || format!("light {}", light.name), response.rect);
        let is_active = response.hovered() || response.dragged();
        disc(ui, at, projection.point(centre), &light, is_behind, is_selected, is_active);
        if response.clicked() || response.drag_started() {
            desk.selection = Selection::Light(light_idx);
        }
        if response.drag_started() {
            *drag = HandleDrag { is_behind, was_outside: false };
        }
        if response.dragged_by(egui::PointerButton::Primary)
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let (direction, is_outside) = on_sphere(projection, pointer, centre, radius, drag.is_behind);
            // Going out over the edge and in again reaches the other side.
            if drag.was_outside && !is_outside {
                drag.is_behind = !drag.is_behind;
            }
            drag.was_outside = is_outside;
            let mut lights = desk.document.groom.lights.clone();
            lights[light_idx].aim_from(centre, direction);
            let label = format!("Aim {}", light.name);
            desk.document.edit(&label, Edit::SetLights(lights), Merge::Drag(u64::MAX - light_idx as u64));
        }
        if is_active {
            ui.ctx().set_cursor_icon(if response.dragged() { CursorIcon::Grabbing } else { CursorIcon::Grab });
        }
    }
}

/// Direction from the centre to where the pointer's ray meets the sphere; outside its outline, to the
/// outline's nearest point.
fn on_sphere(projection: Projection, pointer: egui::Pos2, centre: Vec3, radius: f32, is_behind: bool) -> (Vec3, bool) {
    let (origin, ray) = projection.ray(pointer);
    let b = (origin - centre).dot(ray);
    let c = (origin - centre).length_squared() - radius * radius;
    let discriminant = b * b - c;
    if discriminant < 0.0 {
        let nearest = origin - b * ray;
        return ((nearest - centre).normalize_or(Vec3::Y), true);
    }
    let t = if is_behind { -b + discriminant.sqrt() } else { -b - discriminant.sqrt() };
    ((origin + t * ray - centre).normalize_or(Vec3::Y), false)
}

fn disc(
    ui: &Ui,
    at: egui::Pos2,
    centre: Option<egui::Pos2>,
    light: &lorelei_core::light::Light,
    is_behind: bool,
    is_selected: bool,
    is_active: bool,
) {
    let peak = light.colour.iter().copied().fold(1e-6_f32, f32::max);
    let [r, g, b] = light.colour.map(|c| c / peak);
    let lamp: Color32 = egui::Rgba::from_rgb(r, g, b).into();
    let strength = if is_behind { 0.35 } else { 1.0 };
    let radius = if is_active || is_selected { 9.0 } else { 7.0 };
    let painter = ui.painter();
    if (is_selected || is_active)
        && let Some(centre) = centre
    {
        let to_centre = (centre - at).normalized();
        let line = Stroke::new(1.2, theme::ACCENT.gamma_multiply(0.8 * strength));
        painter.line_segment([at + radius * to_centre, at + 46.0 * to_centre], line);
        let tip = at + 46.0 * to_centre;
        let side = to_centre.rot90() * 4.0;
        painter.add(egui::Shape::convex_polygon(
            vec![tip, tip - 9.0 * to_centre + side, tip - 9.0 * to_centre - side],
            theme::ACCENT.gamma_multiply(strength),
            Stroke::NONE,
        ));
    }
    painter.circle_filled(at, radius + 1.5, Color32::from_black_alpha(110));
    if light.on {
        painter.circle_filled(at, radius - 1.0, lamp.gamma_multiply(strength));
    }
    let ring = if is_selected { theme::ACCENT } else { Color32::from_gray(200) };
    painter.circle_stroke(at, radius, Stroke::new(if is_selected { 2.0 } else { 1.2 }, ring.gamma_multiply(strength)));
    if is_active || is_selected {
        text_above(ui, at, radius + 9.0, &format!("{}  {:.1}", light.name, light.intensity));
    }
}

/// The sphere's outline and equator, faint, while a light is selected.
fn outline(ui: &Ui, desk: &Desk, projection: Projection) {
    let (centre, radius) = (desk.centre(), desk.light_radius(projection.aspect()));
    let stroke = Stroke::new(1.0, Color32::from_white_alpha(26));
    let view = desk.camera.view_from_world().inverse();
    let rings = [(Vec3::X, Vec3::Z), (view.x_axis.truncate(), view.y_axis.truncate())];
    for (a, b) in rings {
        let points: Vec<_> = (0..=72)
            .filter_map(|i| {
                let (sin, cos) = (i as f32 / 72.0 * std::f32::consts::TAU).sin_cos();
                projection.point(centre + radius * (cos * a + sin * b))
            })
            .collect();
        ui.painter().add(egui::Shape::line(points, stroke));
    }
}

/// How a grip looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GripShape {
    Dot,
    Ring,
    Square,
}

/// The colour of what stands in the scene and has none of its own.
pub const GRIP: Color32 = Color32::from_gray(215);

/// A small handle of something that stands in the scene, which a drag moves in the plane of the picture.
pub struct Grip {
    /// World.
    pub place: Vec3,
    pub id: egui::Id,
    pub shape: GripShape,
    /// While nobody points at it and it is not selected.
    pub colour: Color32,
    /// What it is of is selected; is switched on.
    pub is_selected: bool,
    pub is_on: bool,
    /// Written above it while the pointer is on it.
    pub label: Option<String>,
}

/// What the pointer does with a grip.
pub struct Gripped {
    /// It was clicked, or a drag begins.
    pub is_taken: bool,
    pub is_dragged: bool,
    /// Where to it is dragged, world.
    pub by: Option<Vec3>,
}

impl Grip {
    /// Draw it and say what the pointer does with it; `None` behind the eye. `name` is what tests find it by.
    pub fn ui(self, ui: &Ui, camera: &Camera, projection: Projection, name: impl Fn() -> String) -> Option<Gripped> {
        let at = projection.point(self.place)?;
        let response = ui.interact(Rect::from_center_size(at, vec2(22.0, 22.0)), self.id, Sense::click_and_drag());
        super::state_report::mark(ui.ctx(), name, response.rect);
        let is_active = response.hovered() || response.dragged();
        self.draw(ui, at, is_active);
        if is_active {
            ui.ctx().set_cursor_icon(if response.dragged() { CursorIcon::Grabbing } else { CursorIcon::Grab });
            if let Some(label) = &self.label {
                text_above(ui, at, 16.0, label);
            }
        }
        let drag = response.drag_delta();
        let is_by_it = response.dragged_by(egui::PointerButton::Primary) && drag != egui::Vec2::ZERO;
        let (right, up) = picture_plane(camera);
        let by = is_by_it.then(|| projection.cm_per_point(self.place) * (drag.x * right - drag.y * up));
        let is_taken = response.clicked() || response.drag_started();
        Some(Gripped { is_taken, is_dragged: response.dragged(), by })
    }

    fn draw(&self, ui: &Ui, at: egui::Pos2, is_active: bool) {
        let painter = ui.painter();
        let colour = if is_active || self.is_selected { theme::ACCENT } else { self.colour };
        let colour = colour.gamma_multiply(if self.is_on { 1.0 } else { 0.5 });
        let radius = if is_active { 6.5 } else { 5.0 };
        let shade = Color32::from_black_alpha(110);
        match self.shape {
            GripShape::Dot | GripShape::Ring => {
                painter.circle_filled(at, radius + 1.5, shade);
                let fill = if self.shape == GripShape::Dot { colour } else { Color32::from_black_alpha(60) };
                painter.circle(at, radius - 1.0, fill, Stroke::new(1.4, colour));
            }
            GripShape::Square => {
                let square = Rect::from_center_size(at, vec2(1.7 * radius, 1.7 * radius));
                painter.rect_filled(square.expand(1.5), 2.0, shade);
                painter.rect_filled(square, 1.0, colour);
            }
        }
    }
}

/// What is right and up in the picture, world.
pub fn picture_plane(camera: &Camera) -> (Vec3, Vec3) {
    let world_from_view = camera.view_from_world().inverse();
    (world_from_view.x_axis.truncate().normalize_or(Vec3::X), world_from_view.y_axis.truncate().normalize_or(Vec3::Y))
}

/// A line of text so far above a place, with a shadow.
fn text_above(ui: &Ui, at: egui::Pos2, above: f32, text: &str) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    for (offset, colour) in [(1.0, Color32::from_black_alpha(180)), (0.0, theme::TEXT_STRONG)] {
        let place = at + vec2(offset, offset - above);
        ui.painter().text(place, Align2::CENTER_CENTER, text, font.clone(), colour);
    }
}

/// The handle at the neck: a drag moves the head, with Shift it turns it; true while it is dragged.
pub fn head(ui: &mut Ui, desk: &mut Desk, projection: Projection) -> bool {
    let at_world = desk.neck + desk.playback.head_pose.shift;
    let Some(at) = projection.point(at_world) else { return false };
    let id = ui.scope_id().with("head handle");
    let response = ui.interact(Rect::from_center_size(at, vec2(26.0, 26.0)), id, Sense::click_and_drag());
    let is_active = response.hovered() || response.dragged();
    let painter = ui.painter();
    let colour = if is_active { theme::ACCENT } else { Color32::from_gray(210) };
    painter.circle_filled(at, 11.0, Color32::from_black_alpha(90));
    painter.circle_stroke(at, 10.0, Stroke::new(if is_active { 2.0 } else { 1.2 }, colour));
    for arm in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
        painter.line_segment([at + 3.0 * arm, at + 7.0 * arm], Stroke::new(1.4, colour));
    }
    if is_active {
        ui.ctx().set_cursor_icon(if response.dragged() { CursorIcon::Grabbing } else { CursorIcon::Grab });
    }
    if response.clicked() {
        desk.selection = Selection::Head;
    }
    let is_turning = ui.input(|input| input.modifiers.shift);
    if response.dragged_by(egui::PointerButton::Primary) {
        let viewport_height = projection.rect().height();
        drag_head(desk, response.drag_delta(), viewport_height, is_turning);
    }
    response.on_hover_text("Drag to move the head, with Shift to turn it");
    ui.ctx().is_being_dragged(id)
}

/// Move or turn the head by a drag of the pointer; the hair follows, so movement starts to play.
pub fn drag_head(desk: &mut Desk, drag: egui::Vec2, viewport_height: f32, is_turning: bool) {
    if drag == egui::Vec2::ZERO {
        return;
    }
    let camera = desk.camera;
    let pose = &mut desk.playback.head_pose;
    if is_turning {
        let rad_per_point = std::f32::consts::PI / viewport_height.max(1.0);
        pose.yaw = (pose.yaw + rad_per_point * drag.x).clamp(-1.4, 1.4);
        pose.pitch = (pose.pitch + rad_per_point * drag.y).clamp(-0.9, 0.9);
    } else {
        let cm_per_point = 2.0 * camera.distance * (0.5 * camera.fov_y_deg.to_radians()).tan() / viewport_height;
        let world_from_view = camera.view_from_world().inverse();
        let (right, up) = (world_from_view.x_axis.truncate(), world_from_view.y_axis.truncate());
        pose.shift += cm_per_point * (drag.x * right - drag.y * up);
    }
    desk.playback.is_playing = true;
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn a_point_is_found_again_on_the_sphere_from_where_it_is_seen() {
        let camera = Camera { target: Vec3::new(0.0, 5.0, 0.0), ..Camera::default() };
        let projection = Projection::new(&camera, Rect::from_min_size(pos2(100.0, 50.0), vec2(800.0, 600.0)));
        let (centre, radius) = (Vec3::new(0.0, 4.0, 1.0), 12.0);
        for direction in [Vec3::new(0.3, 0.5, 0.8), Vec3::new(-0.2, 0.4, -0.9), Vec3::new(0.5, -0.3, 0.6)] {
            let direction = direction.normalize();
            let seen = projection.point(centre + radius * direction).unwrap();
            // Seen against the outline, the near side ends before the plane through the centre.
            let normal_to_eye = (camera.eye() - (centre + radius * direction)).dot(direction);
            let (found, is_outside) = on_sphere(projection, seen, centre, radius, normal_to_eye < 0.0);
            assert!(!is_outside);
            assert!(found.distance(direction) < 1e-2, "{found} {direction}");
        }
    }
}
