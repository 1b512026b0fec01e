//! A layer's style stack: operators from first to last, switched, soloed, dragged, drawn and named; and whole
//! stacks as presets.
//!
//! The panel changes a copy of the stack and says what changed; `properties.rs` turns that into one edit. A drag
//! of a number or of a curve's point is one step of the history.

use std::path::Path;

use egui::{Align, DragAndDrop, Layout, RichText, Sense, Ui, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::groom::Layer;
use lorelei_core::history::Merge;
use lorelei_core::look::{Choice, ParamValue};
use lorelei_core::maps::{MapKind, Maps};
use lorelei_core::style::presets::{Preset, PresetError, STRANDS, named_ops, presets};
use lorelei_core::style::{StyleKind, StyleOp, acting, left_out};

use super::curve_editor;
use super::widgets::{self, Change};
use crate::window::commands::Command;
use crate::window::desk::{Desk, Selection};
use crate::window::notices::Severity;
use crate::window::state_report::mark;
use crate::window::theme;

/// The operator that is being dragged, by its place in the stack.
#[derive(Debug, Clone, Copy)]
struct Dragged(usize);

/// What a row's buttons ask for; it concerns the whole stack.
enum Action {
    Remove(usize),
    Duplicate(usize),
    Move { from: usize, to: usize },
}

/// The stack of a layer. Returns what changed in it; `asked` gets commands that need a file.
pub fn ui(ui: &mut Ui, layer: &mut Layer, asked: &mut Vec<Command>) -> Option<Change> {
    let (n_strands, maps) = (layer.n_strands, &layer.maps);
    let stack = &mut layer.style;
    let mut change = None;
    ui.horizontal(|ui| {
        change = add_menu(ui, stack, n_strands).or(change.take());
        change = preset_menu(ui, stack, n_strands, asked).or(change.take());
    });
    ui.add_space(2.0);
    change = solo_banner(ui, stack).or(change);
    if let Some(why) = left_out(stack) {
        ui.label(RichText::new(format!("There is {why}")).color(theme::ERROR).small());
    }
    if stack.is_empty() {
        ui.label(RichText::new("No style: strands follow the hair mesh").color(theme::TEXT_WEAK));
    }
    let acts: Vec<bool> = (0..stack.len()).map(|op_idx| acting(stack).any(|(acting, _)| acting == op_idx)).collect();
    let mut action = None;
    let mut rows = Vec::with_capacity(stack.len());
    for (op_idx, op) in stack.iter_mut().enumerate() {
        let rect = operator(ui, op_idx, op, maps, acts[op_idx], &mut change, &mut action);
        rows.push(rect);
    }
    action = dragged(ui, &rows).or(action);
    if let Some(action) = action {
        change = Some(act(stack, &action));
    }
    change
}

fn act(stack: &mut Vec<StyleOp>, action: &Action) -> Change {
    match *action {
        Action::Remove(op_idx) => {
            let op = stack.remove(op_idx);
            Change::once(format!("Remove {}", op.label().to_lowercase()))
        }
        Action::Duplicate(op_idx) => {
            let op = stack[op_idx].clone();
            let label = format!("Duplicate {}", op.label().to_lowercase());
            stack.insert(op_idx + 1, StyleOp { seed: (op.seed + 1) % 10_000, ..op });
            Change::once(label)
        }
        Action::Move { from, to } => {
            let op = stack.remove(from);
            stack.insert(to, op);
            Change::once("Reorder style")
        }
    }
}

/// One operator: a header, and under it, where it is open, its numbers. Returns where its header is.
fn operator(
    ui: &mut Ui,
    op_idx: usize,
    op: &mut StyleOp,
    maps: &Maps,
    acts: bool,
    change: &mut Option<Change>,
    action: &mut Option<Action>,
) -> egui::Rect {
    let id = ui.make_persistent_id(("style", op_idx));
    let mut state = egui::collapsing_header::CollapsingState::load_with_default_open(ui.ctx(), id, false);
    let header = ui.horizontal(|ui| {
        grip(ui, op_idx);
        if widgets::switch(ui, &mut op.on).on_hover_text(op.kind.help()).changed() {
            *change = Some(Change::once(format!("{} {}", op.label(), if op.on { "on" } else { "off" })));
        }
        let colour = if acts { theme::TEXT } else { theme::TEXT_WEAK };
        let arrow = if state.is_open() { "\u{23f7}" } else { "\u{23f5}" };
        let name = egui::Label::new(RichText::new(format!("{arrow} {}", op.label())).color(colour));
        let name = ui.add(name.selectable(false).truncate().sense(Sense::click()));
        mark(ui.ctx(), || format!("style {op_idx}"), name.rect);
        let name = widgets::explained(name, op.kind.help(), "Click to show or hide its numbers");
        if name.clicked() {
            state.toggle(ui);
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.small_button("\u{d7}").on_hover_text("Remove the operator").clicked() {
                *action = Some(Action::Remove(op_idx));
            }
            if ui.small_button("\u{2295}").on_hover_text("Duplicate the operator, with another seed").clicked() {
                *action = Some(Action::Duplicate(op_idx));
            }
            let text = RichText::new("S").strong().color(if op.solo { theme::HEADER } else { theme::TEXT_WEAK });
            let fill = if op.solo { theme::ACCENT } else { theme::CONTROL };
            let solo = ui.add(egui::Button::new(text).small().fill(fill));
            mark(ui.ctx(), || format!("style {op_idx} solo"), solo.rect);
            if solo.on_hover_text("Solo: only operators with this switch act, while any has it").clicked() {
                op.solo = !op.solo;
                let what = if op.solo { "Solo" } else { "End solo of" };
                *change = Some(Change::once(format!("{what} {}", op.label())));
            }
        });
    });
    state.show_body_indented(&header.response, ui, |ui| {
        if let Some(new) = body(ui, op, maps) {
            *change = Some(new);
        }
    });
    header.response.rect
}

fn solo_banner(ui: &mut Ui, stack: &mut [StyleOp]) -> Option<Change> {
    let n_solo = stack.iter().filter(|op| op.on && op.solo).count();
    if n_solo == 0 {
        return None;
    }
    let n_silent = stack.iter().filter(|op| op.is_active() && !op.solo).count();
    ui.horizontal(|ui| {
        let text = format!("Solo: {n_silent} other operators do not act");
        ui.label(RichText::new(text).color(theme::ACCENT).small());
        let end = ui.small_button("End solo").on_hover_text("All operators that are on act again");
        end.clicked().then(|| {
            for op in stack.iter_mut() {
                op.solo = false;
            }
            Change::once("End solo")
        })
    })
    .inner
}

/// Six dots to drag an operator by.
fn grip(ui: &mut Ui, op_idx: usize) {
    let (rect, response) = ui.allocate_exact_size(vec2(12.0, theme::ROW), Sense::drag());
    let colour = if response.hovered() || response.dragged() { theme::TEXT_STRONG } else { theme::TEXT_WEAK };
    for (x, y) in [(-2.0, -5.0), (2.0, -5.0), (-2.0, 0.0), (2.0, 0.0), (-2.0, 5.0), (2.0, 5.0)] {
        ui.painter().circle_filled(rect.center() + vec2(x, y), 1.2, colour);
    }
    mark(ui.ctx(), || format!("style {op_idx} grip"), rect);
    response.dnd_set_drag_payload(Dragged(op_idx));
    let response = response.on_hover_cursor(egui::CursorIcon::Grab);
    response.on_hover_text("Drag to apply the operator earlier or later");
}

/// Show where a dragged operator would go, and let it go there.
fn dragged(ui: &Ui, rows: &[egui::Rect]) -> Option<Action> {
    let from = DragAndDrop::payload::<Dragged>(ui.ctx())?.0;
    let pointer = ui.ctx().pointer_interact_pos()?;
    let first = rows.first()?;
    let last = rows.last()?;
    if from >= rows.len() {
        return None;
    }
    let gap = rows.iter().filter(|row| row.center().y < pointer.y).count();
    let y = rows.get(gap).map_or(last.bottom() + 2.0, |row| row.top() - 2.0);
    let is_near = pointer.y > first.top() - 60.0 && pointer.y < ui.max_rect().bottom() + 200.0;
    if is_near {
        let x_range = first.left()..=ui.max_rect().right();
        ui.painter().hline(x_range, y, egui::Stroke::new(2.0, theme::ACCENT));
    }
    if !ui.ctx().input(|input| input.pointer.any_released()) {
        return None;
    }
    DragAndDrop::clear_payload(ui.ctx());
    // Where the operator itself is taken out before the gap, what follows moves up.
    let to = if gap > from { gap - 1 } else { gap };
    (is_near && to != from).then_some(Action::Move { from, to })
}

/// The numbers of one operator.
pub(super) fn body(ui: &mut Ui, op: &mut StyleOp, maps: &Maps) -> Option<Change> {
    let usual = StyleOp::new(op.kind);
    let mut change = name_row(ui, op);
    let mut default = usual.clone();
    let defaults: Vec<String> = default.params().iter().map(|param| param.value.to_text()).collect();
    let is_drawn = !op.curve.is_empty();
    for (param, default) in op.params().iter_mut().zip(&defaults) {
        let is_ramp = param.key == "style.ramp";
        if matches!(param.value, ParamValue::U32(_)) {
            continue;
        }
        // A drawn curve says what the ramp said. Its row stays: the curve must not move under the hand that draws it.
        let is_in_use = !(is_ramp && is_drawn);
        let row = ui.add_enabled_ui(is_in_use, |ui| widgets::param(ui, param, Some(default)));
        change = row.inner.or(change.take());
    }
    change = curve_editor::ui(ui, op, &usual).or(change);
    change = map_row(ui, op, maps).or(change);
    change = blend_row(ui, op).or(change);
    seed_row(ui, op).or(change)
}

/// The operator's name; empty is the kind's.
fn name_row(ui: &mut Ui, op: &mut StyleOp) -> Option<Change> {
    let help = "What the operator is called here; empty: what it does";
    let is_named = !op.name.is_empty();
    let (is_reset, typed) = widgets::form_row(ui, "Name", help, is_named, |ui| {
        let id = ui.make_persistent_id("name");
        let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| op.name.clone());
        let width = ui.available_width();
        let edit = egui::TextEdit::singleline(&mut text).hint_text(op.kind.label()).desired_width(width);
        let response = widgets::explained(ui.add(edit), help, "Click and type; Enter keeps it");
        if response.has_focus() {
            ui.data_mut(|data| data.insert_temp(id, text.clone()));
            return None;
        }
        ui.data_mut(|data| data.remove::<String>(id));
        (response.lost_focus() && text.trim() != op.name).then(|| text.trim().to_owned())
    });
    let typed = if is_reset && is_named { Some(String::new()) } else { typed };
    typed.map(|name| {
        op.name = name;
        Change::once("Rename operator")
    })
}

fn blend_row(ui: &mut Ui, op: &mut StyleOp) -> Option<Change> {
    let blends = op.kind.blends();
    if blends.len() < 2 {
        return None;
    }
    let before = op.blend();
    let mut chosen = before;
    let help = "How it joins what the operators above it did";
    let is_changed = before != blends[0];
    let (is_reset, ()) = widgets::form_row(ui, "Blend", help, is_changed, |ui| {
        let combo = egui::ComboBox::from_id_salt("blend")
            .width(ui.available_width())
            .selected_text(before.info().label)
            .show_ui(ui, |ui| {
                for blend in blends {
                    let info = blend.info();
                    let row = ui.selectable_value(&mut chosen, *blend, info.label).on_hover_text(info.help);
                    mark(ui.ctx(), || format!("choice blend={}", info.name), row.rect);
                }
            });
        let response = combo.response.on_hover_text(before.info().help);
        mark(ui.ctx(), || "style blend".to_owned(), response.rect);
    });
    if is_reset {
        chosen = blends[0];
    }
    op.blend = chosen;
    (chosen != before).then(|| Change::once(format!("{}: {}", op.label(), chosen.info().label.to_lowercase())))
}

/// The painted map that says where the operator acts.
fn map_row(ui: &mut Ui, op: &mut StyleOp, maps: &Maps) -> Option<Change> {
    let help = "A painted map that says where on the scalp it acts, and how strongly";
    let before = op.map.clone();
    // What is painted already, and what can be painted for it.
    let mut kinds: Vec<MapKind> = maps.keys().filter(|kind| matches!(kind, MapKind::Mask(_))).cloned().collect();
    kinds.extend([MapKind::Density, MapKind::Length, MapKind::Clump, MapKind::Curl]);
    kinds.extend(before.iter().filter(|kind| !kinds.contains(kind)).cloned().collect::<Vec<_>>());
    let name = |map: &Option<MapKind>| map.as_ref().map_or("Everywhere".to_owned(), MapKind::label);
    let (is_reset, ()) = widgets::form_row(ui, "Map", help, before.is_some(), |ui| {
        let combo = egui::ComboBox::from_id_salt("map").width(ui.available_width()).selected_text(name(&before));
        let combo = combo.truncate().show_ui(ui, |ui| {
            ui.selectable_value(&mut op.map, None, name(&None)).on_hover_text("No map: alike on the whole scalp");
            for kind in kinds {
                let text =
                    if maps.contains_key(&kind) { kind.label() } else { format!("{} (not painted)", kind.label()) };
                let help = kind.help();
                ui.selectable_value(&mut op.map, Some(kind), text).on_hover_text(help);
            }
        });
        mark(ui.ctx(), || "style map".to_owned(), combo.response.rect);
        combo.response.on_hover_text(help);
    });
    if is_reset {
        op.map = None;
    }
    (op.map != before).then(|| Change::once(format!("{}: {}", op.label(), name(&op.map).to_lowercase())))
}

/// The seed, and a dice that throws it anew.
fn seed_row(ui: &mut Ui, op: &mut StyleOp) -> Option<Change> {
    let help = "Another seed, another throw of the dice: the same style, other strands";
    let mut change = None;
    let (is_reset, ()) = widgets::form_row(ui, "Seed", help, op.seed != 0, |ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let dice = ui.add_sized(vec2(30.0, theme::ROW), egui::Button::new("\u{1f3b2}"));
            mark(ui.ctx(), || "style dice".to_owned(), dice.rect);
            if dice.on_hover_text("Throw the dice: another seed").clicked() {
                // A fixed walk through the seeds, so that a session can be repeated.
                op.seed = (op.seed * 7 + 1009) % 10_000;
                change = Some(Change::once("Throw the dice"));
            }
            let response = widgets::integer(ui, &mut op.seed, (0, 9999), "");
            let response = widgets::explained(response, help, "Drag, or click and type");
            change = Change::from_response("Seed", &response).or(change.take());
        });
    });
    if is_reset {
        op.seed = 0;
        return Some(Change::once("Reset seed"));
    }
    change
}

fn add_menu(ui: &mut Ui, stack: &mut Vec<StyleOp>, n_strands: u32) -> Option<Change> {
    let mut added = None;
    let menu = ui.menu_button("Add an operator", |ui| {
        for kind in StyleKind::DEFAULTS {
            if ui.button(kind.label()).on_hover_text(kind.help()).clicked() {
                added = Some(StyleOp::new(kind));
            }
        }
        ui.separator();
        for (help, mut op) in named_ops() {
            if ui.button(op.label()).on_hover_text(help).clicked() {
                op.kind.scale_clumps(n_strands as f32 / STRANDS as f32);
                added = Some(op);
            }
        }
    });
    mark(ui.ctx(), || "style add".to_owned(), menu.response.rect);
    menu.response.on_hover_text("Something more that happens to the strands, after what is there");
    let op = added?;
    let change = Change::once(format!("Add {}", op.label().to_lowercase()));
    stack.push(op);
    Some(change)
}

fn preset_menu(ui: &mut Ui, stack: &mut Vec<StyleOp>, n_strands: u32, asked: &mut Vec<Command>) -> Option<Change> {
    let mut change = None;
    let menu = ui.menu_button("Presets", |ui| {
        for (i, preset) in presets().into_iter().enumerate() {
            let help = format!("{}. Replaces the whole stack; undo brings it back.", preset.help);
            let button = ui.button(&preset.name).on_hover_text(help);
            mark(ui.ctx(), || format!("preset {i}"), button.rect);
            if button.clicked() {
                *stack = preset.for_strands(n_strands);
                change = Some(Change::once(format!("Style: {}", preset.name)));
            }
        }
        ui.separator();
        for command in [Command::LoadStyle, Command::SaveStyle] {
            let row = command.row();
            if ui.button(row.label).on_hover_text(row.help).clicked() {
                asked.push(command);
            }
        }
        let none = egui::Button::new("No style");
        if ui.add_enabled(!stack.is_empty(), none).on_hover_text("Remove all operators").clicked() {
            stack.clear();
            change = Some(Change::once("Remove the style"));
        }
    });
    mark(ui.ctx(), || "style presets".to_owned(), menu.response.rect);
    menu.response.on_hover_text("Whole stacks by name, the studio's and your own");
    change
}

/// Write the selected layer's style to a file, or put a file's on it.
pub fn file(desk: &mut Desk, is_save: bool, path: &Path) -> Result<(), PresetError> {
    let Selection::Layer(layer_idx) = desk.selection else { return Ok(()) };
    let Some(layer) = desk.selected_layer() else { return Ok(()) };
    if is_save {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let (n_strands, stack) = (layer.n_strands, layer.style.clone());
        Preset { name, help: String::new(), n_strands, stack }.save(path)?;
        desk.notices.push(Severity::Info, "Style saved", path.display().to_string());
        return Ok(());
    }
    let preset = Preset::open(path)?;
    let style = preset.for_strands(layer.n_strands);
    desk.document.edit(&format!("Style: {}", preset.name), Edit::SetStyle { layer_idx, style }, Merge::New);
    Ok(())
}

#[cfg(test)]
mod tests {
    use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2};
    use lorelei_core::groom::Source;
    use lorelei_core::style::Profile;

    use super::*;
    use crate::window::state_report::marked;

    /// The panel without a window, used by hand.
    struct Hand {
        ctx: egui::Context,
        layer: Layer,
        time: f64,
        changes: Vec<Change>,
    }

    impl Hand {
        fn new(style: Vec<StyleOp>) -> Self {
            let layer = Layer { style, ..Layer::new("hair", Source::Guides(std::sync::Arc::default())) };
            let ctx = egui::Context::default();
            theme::install(&ctx);
            let mut hand = Self { ctx, layer, time: 0.0, changes: Vec::new() };
            assert_eq!(marked(&hand.ctx, "nothing"), None);
            hand.draw(Vec::new());
            hand.draw(Vec::new());
            hand
        }

        fn draw(&mut self, events: Vec<Event>) {
            self.time += 0.01;
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(340.0, 2000.0)));
            let input = RawInput { events, screen_rect, time: Some(self.time), ..RawInput::default() };
            let (layer, changes) = (&mut self.layer, &mut self.changes);
            let mut output = self.ctx.run_ui(input, |ui| {
                egui::CentralPanel::default().show(ui, |panel| changes.extend(ui_of(panel, layer)));
            });
            // Nobody paints.
            output.textures_delta.clear();
        }

        fn at(&self, name: &str) -> Rect {
            marked(&self.ctx, name).unwrap_or_else(|| panic!("`{name}` is on the panel"))
        }

        fn button(&mut self, at: Pos2, pressed: bool) {
            let button = PointerButton::Primary;
            self.draw(vec![Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE }]);
        }

        fn drag(&mut self, from: Pos2, to: Pos2) {
            self.draw(vec![Event::PointerMoved(from)]);
            self.button(from, true);
            for step in 1..=4 {
                self.draw(vec![Event::PointerMoved(from + (to - from) * (step as f32 / 4.0))]);
            }
            self.button(to, false);
            self.draw(Vec::new());
        }

        fn click(&mut self, at: Pos2) {
            self.drag(at, at);
        }

        /// A click that is no part of a double click.
        fn lone_click(&mut self, at: Pos2) {
            self.time += 2.0;
            self.click(at);
        }

        fn labels(&self) -> Vec<&str> {
            self.layer.style.iter().map(StyleOp::label).collect()
        }
    }

    fn ui_of(panel: &mut Ui, layer: &mut Layer) -> Option<Change> {
        ui(panel, layer, &mut Vec::new())
    }

    fn stack() -> Vec<StyleOp> {
        StyleKind::DEFAULTS[..4].iter().map(|kind| StyleOp::new(*kind)).collect()
    }

    #[test]
    fn operators_are_dragged_to_another_place_in_one_step() {
        let mut hand = Hand::new(stack());
        assert_eq!(hand.labels(), ["Clump", "Length", "Wave", "Curl"]);
        let (first, third) = (hand.at("style 0 grip").center(), hand.at("style 2 grip").center_bottom());
        hand.drag(first, third);
        assert_eq!(hand.labels(), ["Length", "Wave", "Clump", "Curl"]);
        assert_eq!(hand.changes, [Change::once("Reorder style")]);
        let (last, above) = (hand.at("style 3 grip").center(), hand.at("style 0 grip").center_top() - vec2(0.0, 6.0));
        hand.drag(last, above);
        assert_eq!(hand.labels(), ["Curl", "Length", "Wave", "Clump"]);
        // Back where it was: no step.
        let n_changes = hand.changes.len();
        let second = hand.at("style 1 grip").center();
        hand.drag(second, second + vec2(0.0, 3.0));
        assert_eq!(hand.changes.len(), n_changes);
    }

    #[test]
    fn solo_is_switched_by_its_button() {
        let mut hand = Hand::new(stack());
        let solo = hand.at("style 2 solo").center();
        hand.lone_click(solo);
        assert!(hand.layer.style[2].solo);
        assert_eq!(hand.changes, [Change::once("Solo Wave")]);
        assert_eq!(acting(&hand.layer.style).count(), 1);
    }

    #[test]
    fn a_curve_is_drawn_by_dragging_and_points_come_and_go_with_double_clicks() {
        let mut hand = Hand::new(vec![StyleOp::new(StyleKind::DEFAULTS[3])]);
        let name = hand.at("style 0").center();
        hand.lone_click(name);
        for _ in 0..10 {
            hand.draw(Vec::new());
        }
        let rect = hand.at("style curve");
        let at = |x: f32, y: f32| pos2(rect.left() + x * rect.width(), rect.bottom() - y * rect.height());
        assert!(hand.layer.style[0].curve.is_empty());
        hand.time += 2.0;
        hand.drag(at(1.0, 1.0), at(1.0, 0.25));
        let points = |hand: &Hand| hand.layer.style[0].curve.points().to_vec();
        assert_eq!(points(&hand).len(), 2);
        assert!((points(&hand)[1][1] - 0.25).abs() < 0.02, "{:?}", points(&hand));
        let drags: std::collections::HashSet<_> = hand.changes.iter().map(|change| change.drag).collect();
        assert!(drags.len() == 1 && !drags.contains(&None), "one drag, one step");
        hand.time += 2.0;
        hand.click(at(0.4, 0.5));
        hand.click(at(0.4, 0.5));
        assert_eq!(points(&hand).len(), 3, "{:?}", points(&hand));
        hand.time += 2.0;
        let [x, y] = points(&hand)[1];
        hand.click(at(x, y));
        hand.click(at(x, y));
        assert_eq!(points(&hand).len(), 2);
        assert_ne!(hand.layer.style[0].curve, Profile::default());
    }
}
