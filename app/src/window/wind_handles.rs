//! Sources of wind in the viewport: what moves and aims them, also while hair moves.
//!
//! A disc where a fan is, or the ring of a vortex, with an arrow along its axis. The dot in the middle moves it, the dot at
//! the arrow's tip aims it; both go in the plane of the picture.

use egui::{Color32, Pos2, Stroke, Ui};
use glam::Vec3;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::wind::WindSource;

use super::desk::{Desk, Selection};
use super::handles::{GRIP, Grip, GripShape};
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
    let mut is_dragging = false;
    let are_idle = desk.has_idle_sources();
    for source_idx in 0..desk.document.groom.simulation.sources.len() {
        let mut source = desk.document.groom.simulation.sources[source_idx].tamed();
        source.on &= !are_idle;
        let is_selected = desk.selection == Selection::Wind(source_idx);
        draw(ui, projection, &source, is_selected);
        for (part, shape, place) in
            [(Part::Place, GripShape::Dot, source.place), (Part::Tip, GripShape::Ring, tip_of(&source))]
        {
            let id = ui.scope_id().with(("wind", source_idx, part == Part::Tip));
            let speed = if are_idle { "still air".to_owned() } else { format!("{:.0} cm/s", source.speed) };
            let label = Some(format!("{}  {speed}", source.name));
            let grip = Grip { place, id, shape, colour: GRIP, is_selected, is_on: source.on, label };
            let name = || format!("wind {source_idx} {part:?}");
            let Some(gripped) = grip.ui(ui, &desk.camera, projection, name) else { continue };
            if gripped.is_taken {
                desk.selection = Selection::Wind(source_idx);
            }
            is_dragging |= gripped.is_dragged;
            if let Some(by) = gripped.by {
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
