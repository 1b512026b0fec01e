//! The line between two looks, and which is on which side of it.

use egui::{Align2, Color32, CursorIcon, DragValue, Rect, Sense, Stroke, Ui, pos2, vec2};

use super::Beside;
use crate::window::desk::Desk;
use crate::window::state_report::mark;
use crate::window::theme;

/// Points around the line that take the pointer.
const GRIP: f32 = 14.0;

/// Draw the line and follow the hand, or show the difference's gain; true while it is dragged.
pub fn ui(ui: &mut Ui, desk: &mut Desk, rect: Rect) -> bool {
    if desk.room.other.is_none() {
        return false;
    }
    match desk.room.beside {
        Beside::Nothing => false,
        Beside::Wipe => line(ui, desk, rect),
        Beside::Difference => {
            gain(ui, desk, rect);
            false
        }
    }
}

fn line(ui: &mut Ui, desk: &mut Desk, rect: Rect) -> bool {
    let x = rect.left() + desk.room.wipe * rect.width();
    let handle = pos2(x, rect.top() + 0.86 * rect.height());
    let place = Rect::from_center_size(pos2(x, rect.center().y), vec2(GRIP, rect.height()));
    let response = ui.interact(place, ui.scope_id().with("wipe"), Sense::drag());
    mark(ui.ctx(), || "wipe".to_owned(), Rect::from_center_size(handle, vec2(GRIP, GRIP)));
    let is_active = response.hovered() || response.dragged();
    if response.dragged()
        && let Some(pointer) = response.interact_pointer_pos()
    {
        desk.room.wipe = ((pointer.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
    }
    if is_active {
        ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
    }
    let colour = if is_active { theme::ACCENT } else { Color32::from_gray(235) };
    let painter = ui.painter();
    painter.vline(x, rect.y_range(), Stroke::new(3.0, Color32::from_black_alpha(90)));
    painter.vline(x, rect.y_range(), Stroke::new(1.2, colour));
    painter.circle_filled(handle, 10.0, Color32::from_black_alpha(150));
    painter.circle_stroke(handle, 10.0, Stroke::new(1.5, colour));
    for side in [-1.0, 1.0] {
        let tip = handle + vec2(side * 7.0, 0.0);
        let back = handle + vec2(side * 2.5, 0.0);
        let points = vec![tip, back + vec2(0.0, 4.0), back - vec2(0.0, 4.0)];
        painter.add(egui::Shape::convex_polygon(points, colour, Stroke::NONE));
    }
    let font = egui::TextStyle::Heading.resolve(ui.style());
    for (name, align, offset) in [("A", Align2::RIGHT_TOP, -10.0), ("B", Align2::LEFT_TOP, 10.0)] {
        let at = pos2(x + offset, rect.top() + 40.0);
        for (shift, colour) in [(vec2(1.0, 1.0), Color32::from_black_alpha(190)), (vec2(0.0, 0.0), colour)] {
            painter.text(at + shift, align, name, font.clone(), colour);
        }
    }
    response.on_hover_text("Drag: the document's look (A) at the left, look B at the right");
    is_active && ui.input(|input| input.pointer.primary_down())
}

fn gain(ui: &mut Ui, desk: &mut Desk, rect: Rect) {
    let place = Rect::from_min_size(pos2(rect.center().x - 90.0, rect.bottom() - 40.0), vec2(180.0, 26.0));
    ui.painter().rect_filled(place, 6.0, Color32::from_black_alpha(170));
    let inner = place.shrink2(vec2(10.0, 2.0));
    let mut child = ui.new_child(egui::UiBuilder::new().max_rect(inner));
    child.horizontal_centered(|ui| {
        ui.label("|A \u{2212} B| \u{d7}");
        let value = DragValue::new(&mut desk.room.gain).range(0.1..=1000.0).speed(0.1).max_decimals(1);
        let response = ui.add(value).on_hover_text("What the difference of the display values is multiplied with");
        mark(ui.ctx(), || "difference gain".to_owned(), response.rect);
    });
}
