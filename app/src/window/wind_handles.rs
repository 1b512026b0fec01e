//! Sources of wind in the viewport: what moves and aims them, also while hair moves.
//!
//! A disc where a fan is, or the ring of a vortex, with an arrow along its axis. The dot in the middle moves it, the dot at
//! the arrow's tip aims it; both go in the plane of the picture.

use egui::{Align2, Color32, CursorIcon, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use glam::Vec3;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::wind::WindSource;

use super::desk::{Desk, Selection};
use super::projection::Projection;
use super::theme;

/// Sides of a ring.
const N_SIDES: u32 = 40;
/// Names the drags of sources among all drags.
const DRAGS: u64 = 0x31ED_0F5E << 16;

/// What a handle moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Place,
    Tip,
}

/// The handles of every source; true while one is dragged.
pub fn sources(ui: &mut Ui, desk: &mut Desk, projection: Projection) -> bool {
    let world_from_view = desk.camera.view_from_world().inverse();
    let (right, up) = (world_from_view.x_axis.truncate(), world_from_view.y_axis.truncate());
    let mut is_dragging = false;
    for source_idx in 0..desk.document.groom.simulation.sources.len() {
        let source = desk.document.groom.simulation.sources[source_idx].tamed();
        let is_selected = desk.selection == Selection::Wind(source_idx);
        draw(ui, projection, &source, is_selected);
        for (part, at_world) in [(Part::Place, source.place), (Part::Tip, tip_of(&source))] {
            let Some(at) = projection.point(at_world) else { continue };
            let id = ui.scope_id().with(("wind", source_idx, part == Part::Tip));
            let response = ui.interact(Rect::from_center_size(at, vec2(22.0, 22.0)), id, Sense::click_and_drag());
            super::state_report::mark(ui.ctx(), || format!("wind {source_idx} {part:?}"), response.rect);
            let is_active = response.hovered() || response.dragged();
            dot(ui, at, part, is_selected || is_active, source.on);
            if is_active {
                ui.ctx().set_cursor_icon(if response.dragged() { CursorIcon::Grabbing } else { CursorIcon::Grab });
                label(ui, at, &source);
            }
            if response.clicked() || response.drag_started() {
                desk.selection = Selection::Wind(source_idx);
            }
            is_dragging |= response.dragged();
            let drag = response.drag_delta();
            if response.dragged_by(egui::PointerButton::Primary) && drag != egui::Vec2::ZERO {
                let by = projection.cm_per_point(at_world) * (drag.x * right - drag.y * up);
                let mut settings = desk.document.groom.simulation.clone();
                let what = move_part(&mut settings.sources[source_idx], part, by);
                let id = DRAGS + 2 * source_idx as u64 + u64::from(part == Part::Tip);
                let label = format!("{what} {}", source.name);
                desk.document.edit(&label, Edit::SetSimulation(Box::new(settings)), Merge::Drag(id));
            }
        }
    }
    is_dragging
}

/// Where the arrow of a source ends.
fn tip_of(source: &WindSource) -> Vec3 {
    source.place + (source.radius + 8.0) * source.direction.normalize_or(Vec3::NEG_Z)
}

/// Move a part by a way in the world; says what was done.
fn move_part(source: &mut WindSource, part: Part, by: Vec3) -> &'static str {
    match part {
        Part::Place => {
            source.place += by;
            "Move"
        }
        Part::Tip => {
            source.direction = (tip_of(source) + by - source.place).normalize_or(source.direction);
            "Aim"
        }
    }
}

fn draw(ui: &Ui, projection: Projection, source: &WindSource, is_selected: bool) {
    let strength = if source.on { 1.0 } else { 0.35 };
    let colour = if is_selected { theme::ACCENT } else { Color32::from_rgb(150, 205, 225) };
    let direction = source.direction.normalize_or(Vec3::NEG_Z);
    let (a, b) = direction.any_orthonormal_pair();
    let ring: Option<Vec<Pos2>> = (0..=N_SIDES)
        .map(|i| {
            let (sin, cos) = (i as f32 / N_SIDES as f32 * std::f32::consts::TAU).sin_cos();
            projection.point(source.place + source.radius * (cos * a + sin * b))
        })
        .collect();
    let width = if is_selected { 1.8 } else { 1.1 };
    if let Some(ring) = ring {
        ui.painter().add(egui::Shape::line(ring, Stroke::new(width, colour.gamma_multiply(0.85 * strength))));
    }
    if let (Some(from), Some(to)) = (projection.point(source.place), projection.point(tip_of(source))) {
        arrow(ui.painter(), from, to, width, colour.gamma_multiply(strength));
    }
}

/// A line with a head at its end.
pub fn arrow(painter: &egui::Painter, from: Pos2, to: Pos2, width: f32, colour: Color32) {
    painter.line_segment([from, to], Stroke::new(width, colour));
    let along = to - from;
    let length = along.length();
    if length < 3.0 {
        return;
    }
    let head = along / length * (0.4 * length).min(4.0 + 2.0 * width);
    let side = head.rot90() * 0.45;
    let tip = vec![to, to - head + side, to - head - side];
    painter.add(egui::Shape::convex_polygon(tip, colour, Stroke::NONE));
}

fn dot(ui: &Ui, at: Pos2, part: Part, is_lit: bool, is_on: bool) {
    let colour = if is_lit { theme::ACCENT } else { Color32::from_gray(215) };
    let colour = colour.gamma_multiply(if is_on { 1.0 } else { 0.5 });
    let radius = if is_lit { 6.0 } else { 5.0 };
    ui.painter().circle_filled(at, radius + 1.5, Color32::from_black_alpha(110));
    let fill = if part == Part::Place { colour } else { Color32::from_black_alpha(60) };
    ui.painter().circle(at, radius - 1.0, fill, Stroke::new(1.4, colour));
}

fn label(ui: &Ui, at: Pos2, source: &WindSource) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let text = format!("{}  {:.0} cm/s", source.name, source.speed);
    for (offset, colour) in [(1.0, Color32::from_black_alpha(180)), (0.0, theme::TEXT_STRONG)] {
        let place = pos2(at.x + offset, at.y - 16.0 + offset);
        ui.painter().text(place, Align2::CENTER_CENTER, &text, font.clone(), colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_moves_a_source_and_the_tip_aims_it() {
        let mut fan = WindSource { place: Vec3::ZERO, direction: Vec3::X, radius: 2.0, ..WindSource::default() };
        assert_eq!(move_part(&mut fan, Part::Place, Vec3::Y), "Move");
        assert_eq!((fan.place, fan.direction), (Vec3::Y, Vec3::X));
        assert_eq!(move_part(&mut fan, Part::Tip, Vec3::new(-10.0, 0.0, 10.0)), "Aim");
        assert!(fan.direction.distance(Vec3::Z) < 1e-5, "{}", fan.direction);
        // A tip that is dragged to the middle leaves the direction.
        move_part(&mut fan, Part::Tip, Vec3::new(0.0, 0.0, -10.0));
        assert!(fan.direction.distance(Vec3::Z) < 1e-5);
    }
}
