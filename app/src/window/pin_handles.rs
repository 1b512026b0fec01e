//! Pins in the viewport: their outlines, and what moves and resizes them, also while hair moves.
//!
//! Always in a colour of their own, so that they are told from colliders. A dot in the middle selects and moves; a selected
//! one has a square on its rim that sets the radius. Both move in the plane of the picture.

use egui::Ui;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::pin::Pin;

use super::collider_handles::{draw, outline};
use super::desk::{Desk, Selection};
use super::handles::{Grip, GripShape, picture_plane};
use super::projection::Projection;
use super::theme;

/// Names the drags of pins among all drags.
const DRAGS: u64 = 0x0000_0917 << 32;

/// What a handle moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Whole,
    Rim,
}

/// The handles of every pin; true while one is dragged.
pub fn pins(ui: &mut Ui, desk: &mut Desk, projection: Projection) -> bool {
    let world_from_head = desk.report.world_from_head;
    let (right, up) = picture_plane(&desk.camera);
    let mut is_dragging = false;
    for pin_idx in 0..desk.document.groom.simulation.pins.len() {
        let pin = desk.document.groom.simulation.pins[pin_idx].clone();
        if !(pin.centre.is_finite() && pin.radius.is_finite()) {
            continue;
        }
        let centre = world_from_head.transform_point3(pin.centre);
        let is_selected = desk.selection == Selection::Pin(pin_idx);
        let circle = outline(projection, [centre; 2], [pin.radius; 2], (right, up));
        draw(ui, &circle, theme::PIN, is_selected, pin.on);
        let mut parts = vec![(Part::Whole, GripShape::Dot, centre)];
        if is_selected {
            parts.push((Part::Rim, GripShape::Square, centre + pin.radius * right));
        }
        for (part, shape, place) in parts {
            let id = ui.scope_id().with(("pin", pin_idx, part == Part::Rim));
            let label =
                (part == Part::Whole).then(|| format!("{}  {:.1} cm, holds the hair in it", pin.name, pin.radius));
            let grip = Grip { place, id, shape, colour: theme::PIN, is_selected, is_on: pin.on, label };
            let name = || format!("pin {pin_idx} {part:?}");
            let Some(gripped) = grip.ui(ui, &desk.camera, projection, name) else { continue };
            if gripped.is_taken {
                desk.selection = Selection::Pin(pin_idx);
            }
            is_dragging |= gripped.is_dragged;
            if let Some(by) = gripped.by {
                let mut pins = desk.document.groom.simulation.pins.clone();
                let moved: &mut Pin = &mut pins[pin_idx];
                let what = match part {
                    Part::Whole => {
                        moved.centre += world_from_head.inverse().transform_vector3(by);
                        "Move"
                    }
                    Part::Rim => {
                        moved.set_radius(pin.radius + by.dot(right));
                        "Resize"
                    }
                };
                let id = DRAGS + 2 * pin_idx as u64 + u64::from(part == Part::Rim);
                desk.document.edit(&format!("{what} {}", pin.name), Edit::SetPins(pins), Merge::Drag(id));
            }
        }
    }
    is_dragging
}
