//! The curve of an operator from root to tip: points to drag over a drawing of what it does along the strand.
//!
//! Until a curve is drawn, the drawing shows the ramp; taking hold of it makes the curve from points on the ramp,
//! so that nothing jumps. Double-clicking adds a point or removes the one under the pointer.

use egui::{Align2, Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};
use lorelei_core::style::{Envelope, MOST_POINTS, Profile, SHAPES, StyleOp};

use super::widgets::{self, Change};
use crate::window::state_report::mark;
use crate::window::theme;

/// Height of the drawing, points.
const HEIGHT: f32 = 92.0;
/// A point is taken hold of from this far.
const REACH: f32 = 9.0;

/// The curve of `op`; `usual` is what it is reset to.
pub fn ui(ui: &mut Ui, op: &mut StyleOp, usual: &StyleOp) -> Option<Change> {
    let help = "How strong it is from root (left) to tip (right)";
    let is_changed = op.curve != usual.curve;
    let mut chosen = None;
    let (is_reset, ()) = widgets::form_row(ui, "Curve", help, is_changed, |ui| {
        let combo = egui::ComboBox::from_id_salt("curve").width(ui.available_width());
        let combo = combo.selected_text(shape_name(&op.curve)).show_ui(ui, |ui| {
            for shape in SHAPES {
                let is_it = op.curve.shape().is_some_and(|of| of.name == shape.name);
                if ui.selectable_label(is_it, shape.label).on_hover_text(shape.help).clicked() {
                    chosen = Some(Profile::of(shape.points));
                }
            }
        });
        mark(ui.ctx(), || "style shape".to_owned(), combo.response.rect);
        combo.response.on_hover_text("Curves to begin with");
    });
    if is_reset {
        chosen = Some(usual.curve.clone());
    }
    let change = drawing(ui, op);
    let Some(curve) = chosen else { return change };
    op.curve = curve;
    Some(Change::once(format!("{}: {} curve", op.label(), shape_name(&op.curve).to_lowercase())))
}

fn shape_name(curve: &Profile) -> &'static str {
    curve.shape().map_or("Own", |shape| shape.label)
}

/// Where strength `y` at `x` of the operator's part of the strand is on screen.
fn place(rect: Rect, from: f32, [x, y]: [f32; 2]) -> Pos2 {
    let along = from + (1.0 - from) * x;
    pos2(egui::lerp(rect.left()..=rect.right(), along), egui::lerp(rect.bottom()..=rect.top(), y))
}

fn drawing(ui: &mut Ui, op: &mut StyleOp) -> Option<Change> {
    let (outer, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    // An id of its own: taking hold of the ramp makes a row above vanish, and the drag has to go on.
    let response = ui.interact(outer, ui.make_persistent_id("curve"), Sense::click_and_drag());
    let rect = outer.shrink2(vec2(8.0, 8.0));
    mark(ui.ctx(), || "style curve".to_owned(), rect);
    let from = op.from.clamp(0.0, 0.99);
    let at = |p: Pos2| -> [f32; 2] {
        let along = egui::remap(p.x, rect.left()..=rect.right(), 0.0..=1.0);
        let y = egui::remap(p.y, rect.bottom()..=rect.top(), 0.0..=1.0);
        [((along - from) / (1.0 - from)).clamp(0.0, 1.0), y.clamp(0.0, 1.0)]
    };
    let before = op.curve.clone();
    let shown = if before.is_empty() { Profile::of_ramp(op.ramp) } else { before.clone() };
    let nearest = |profile: &Profile, p: Pos2| -> Option<usize> {
        let apart = |point: &[f32; 2]| place(rect, from, *point).distance(p);
        let near = profile.points().iter().map(apart).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        near.filter(|(_, apart)| *apart < REACH).map(|(point_idx, _)| point_idx)
    };
    let held_id = response.id.with("held");
    let mut held: Option<usize> = ui.data(|data| data.get_temp(held_id));
    let mut label = None;
    if response.drag_started()
        && let Some(p) = ui.input(|input| input.pointer.press_origin())
    {
        let mut taken = shown.clone();
        // Beside every point: a new one there, where there is room.
        held = nearest(&shown, p).or_else(|| taken.insert(at(p)));
        if held.is_some() {
            op.curve = taken;
        }
    }
    if response.dragged()
        && let Some(point_idx) = held.filter(|&point_idx| point_idx < op.curve.points().len())
        && let Some(p) = response.interact_pointer_pos()
    {
        op.curve.move_point(point_idx, at(p));
        label = Some("Curve");
    }
    if response.drag_stopped() {
        held = None;
    }
    if response.double_clicked()
        && let Some(p) = response.interact_pointer_pos()
    {
        let mut edited = shown.clone();
        match nearest(&shown, p) {
            Some(point_idx) => label = edited.remove(point_idx).then_some("Remove a point of the curve"),
            None => label = edited.insert(at(p)).map(|_| "Add a point to the curve"),
        }
        if label.is_some() {
            op.curve = edited;
        }
    }
    ui.data_mut(|data| match held {
        Some(point_idx) => {
            data.insert_temp(held_id, point_idx);
        }
        None => {
            data.remove::<usize>(held_id);
        }
    });
    let hovered = response.hover_pos().and_then(|p| nearest(&shown, p));
    paint(ui, outer, rect, op, held.or(hovered), &response);
    let how = format!(
        "Drag a point; double-click to add one (up to {MOST_POINTS}) or to remove it; double-click the name to reset"
    );
    let drag = response.dragged().then(|| response.id.value());
    widgets::explained(response, "How strong the operator is from root (left) to tip (right)", &how);
    let is_new = op.curve != before;
    label.filter(|_| is_new).map(|label| Change { label: format!("{}: {}", op.label(), label.to_lowercase()), drag })
}

fn paint(ui: &Ui, outer: Rect, rect: Rect, op: &StyleOp, marked: Option<usize>, response: &Response) {
    let painter = ui.painter_at(outer);
    painter.rect_filled(outer, 3.0, theme::FIELD);
    for quarter in 1..4 {
        let share = quarter as f32 / 4.0;
        let stroke = Stroke::new(1.0, theme::HEADER);
        painter.vline(egui::lerp(rect.left()..=rect.right(), share), rect.y_range(), stroke);
        painter.hline(rect.x_range(), egui::lerp(rect.top()..=rect.bottom(), share), stroke);
    }
    let table = op.curve.table();
    let envelope = Envelope { strength: 1.0, from: op.from.clamp(0.0, 0.99), ramp: op.ramp, table: table.as_ref() };
    let n = rect.width().max(2.0) as usize;
    let along = |k: usize| k as f32 / n as f32;
    let line: Vec<Pos2> = (0..=n).map(|k| place(rect, 0.0, [along(k), envelope.at(along(k))])).collect();
    let is_drawn = !op.curve.is_empty();
    let colour = if is_drawn { theme::ACCENT } else { theme::TEXT_WEAK };
    // What is under the line, as columns: the line may be steep, but it never folds back.
    for pair in line.windows(2) {
        let column = Rect::from_min_max(pos2(pair[0].x, pair[0].y.min(rect.bottom())), pos2(pair[1].x, rect.bottom()));
        painter.rect_filled(column, 0.0, colour.gamma_multiply(0.12));
    }
    painter.add(egui::Shape::line(line, Stroke::new(1.5, colour)));
    let shown = if is_drawn { op.curve.clone() } else { Profile::of_ramp(op.ramp) };
    for (point_idx, point) in shown.points().iter().enumerate() {
        let p = place(rect, envelope.from, *point);
        let is_marked = marked == Some(point_idx);
        let fill = if is_marked { Color32::WHITE } else { colour };
        painter.circle(p, if is_marked { 4.5 } else { 3.5 }, fill, Stroke::new(1.0, theme::HEADER));
        if is_marked && (response.dragged() || response.hovered()) {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let text = format!("{:.2} at {:.2}", point[1], envelope.from + (1.0 - envelope.from) * point[0]);
            painter.text(outer.right_top() + vec2(-4.0, 2.0), Align2::RIGHT_TOP, text, font, theme::TEXT);
        }
    }
}
