//! Rows of a form: one way to show a number, a colour, a choice and a switch, everywhere the same.
//!
//! A row's name stands at the left, its control fills the right. A changed value carries an accent mark;
//! double-clicking the name resets it. Controls write into a copy of the value, and the panel turns the
//! [`Change`] into an edit.

use std::hash::{Hash, Hasher};

use egui::{Align2, Color32, DragValue, Response, RichText, Sense, Ui, vec2};
use lorelei_core::look::{AnyChoice, Param, ParamValue, Slot};

use crate::window::state_report::mark;
use crate::window::theme;

/// That a control was used, on what, and in which drag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    pub label: String,
    /// Names the drag that the change is a part of; `None`: a step of its own.
    pub drag: Option<u64>,
}

impl Change {
    pub fn once(label: impl Into<String>) -> Self {
        Self { label: label.into(), drag: None }
    }

    /// What a control's response says about how it was changed.
    pub fn from_response(label: &str, response: &Response) -> Option<Self> {
        response.changed().then(|| {
            let drag = response.dragged().then(|| {
                let mut hasher = std::hash::DefaultHasher::new();
                response.id.hash(&mut hasher);
                hasher.finish()
            });
            Self { label: label.to_owned(), drag }
        })
    }
}

/// Longer units would not leave room for the number, bytes.
const LONGEST_UNIT: usize = 6;

/// Choices are to be seen all at once, points; a longer list scrolls.
const LONGEST_LIST: f32 = 480.0;

/// Share of a row that its name takes.
const NAME_SHARE: f32 = 0.5;

/// A name and the space for a control; returns whether the name was double-clicked, and the control's value.
pub fn form_row<R>(
    ui: &mut Ui,
    name: &str,
    help: &str,
    is_changed: bool,
    control: impl FnOnce(&mut Ui) -> R,
) -> (bool, R) {
    noted_row(ui, name, help, None, is_changed, control)
}

/// What a choice costs, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    pub time: String,
    /// Time and memory, where the memory is known.
    pub all: String,
}

/// What the choices of a slot cost, in the order of the choices; and what was measured. Empty: nothing is known.
#[derive(Debug, Default)]
pub struct Notes {
    pub of_choices: Vec<Option<Note>>,
    pub what: &'static str,
}

impl Notes {
    fn of(&self, choice_idx: usize) -> Option<&Note> {
        self.of_choices.get(choice_idx)?.as_ref()
    }
}

/// As [`form_row`], with a note at the right of the name, and what the note is: what the control's choice costs.
fn noted_row<R>(
    ui: &mut Ui,
    name: &str,
    help: &str,
    note: Option<(&Note, &str)>,
    is_changed: bool,
    control: impl FnOnce(&mut Ui) -> R,
) -> (bool, R) {
    ui.horizontal(|ui| {
        ui.set_min_height(theme::ROW);
        let width = ui.available_width();
        let name_width = (width * NAME_SHARE).floor();
        let (rect, response) = ui.allocate_exact_size(vec2(name_width, theme::ROW), Sense::click());
        let colour = if is_changed { theme::TEXT_STRONG } else { theme::TEXT };
        let font = egui::TextStyle::Body.resolve(ui.style());
        let galley = ui.painter().layout_no_wrap(name.to_owned(), font, colour);
        let mut name_rect = rect;
        if let Some((note, _)) = note {
            let font = egui::TextStyle::Small.resolve(ui.style());
            let right = rect.right_center() - vec2(4.0, 0.0);
            let drawn = ui.painter().text(right, Align2::RIGHT_CENTER, &note.time, font, theme::TEXT_WEAK);
            name_rect.max.x = drawn.left() - 4.0;
        }
        let is_cut = galley.size().x > name_rect.width() - 8.0;
        let at = Align2::LEFT_CENTER.anchor_size(rect.left_center() + vec2(8.0, 0.0), galley.size()).min;
        ui.painter().with_clip_rect(name_rect.intersect(ui.clip_rect())).galley(at, galley, colour);
        if is_changed {
            let mark = egui::Rect::from_center_size(rect.left_center() + vec2(2.0, 0.0), vec2(3.0, 12.0));
            ui.painter().rect_filled(mark, 1.5, theme::ACCENT);
        }
        mark(ui.ctx(), || format!("name {name}"), rect);
        let is_reset = response.double_clicked();
        if response.hovered() && (is_cut || !help.is_empty() || is_changed || note.is_some()) {
            response.on_hover_ui(|ui| {
                if is_cut {
                    ui.label(RichText::new(name).strong());
                }
                if !help.is_empty() {
                    ui.label(help);
                }
                if let Some((note, what)) = note {
                    let all = &note.all;
                    ui.label(format!("{all}: {what}, when it was last drawn. The list says what other choices took."));
                }
                if is_changed {
                    ui.label(RichText::new("Double-click the name to reset").color(theme::TEXT_WEAK).small());
                }
            });
        }
        (is_reset, control(ui))
    })
    .inner
}

/// A number that is dragged or typed, with its place in the range drawn behind it.
pub fn number(ui: &mut Ui, value: &mut f32, (min, max): (f32, f32), unit: &str) -> Response {
    let speed =
        if min >= 0.0 && max / min.max(1.0) >= 2000.0 { (*value * 0.01).max(0.01) } else { (max - min) / 300.0 };
    let decimals = match max - min {
        range if range <= 5.0 => 3,
        range if range <= 100.0 => 2,
        range if range <= 1000.0 => 1,
        _ => 0,
    };
    let control = DragValue::new(value).range(min..=max).speed(f64::from(speed)).max_decimals(decimals);
    // What is typed counts when it is complete: every digit would be a step to undo.
    let control = control.update_while_editing(false);
    let response = field(ui, control, unit);
    fill(ui, response, (*value - min) / (max - min))
}

/// A whole number that is dragged or typed.
pub fn integer(ui: &mut Ui, value: &mut u32, (min, max): (u32, u32), unit: &str) -> Response {
    let is_wide = max > 2000;
    let speed = if is_wide { (f64::from(*value) * 0.01).max(1.0) } else { f64::from(max - min) / 300.0 };
    let control = DragValue::new(value).range(min..=max).speed(speed).update_while_editing(false);
    let response = field(ui, control, unit);
    fill(ui, response, (*value as f32 - min as f32) / (max - min).max(1) as f32)
}

/// The control over the rest of the row, its unit after the number.
fn field(ui: &mut Ui, control: DragValue<'_>, unit: &str) -> Response {
    // A long unit is told by the name's tooltip instead.
    let suffix = match unit {
        "" => String::new(),
        "deg" => "\u{b0}".to_owned(),
        _ if unit.len() > LONGEST_UNIT => String::new(),
        _ => format!(" {unit}"),
    };
    let size = vec2(ui.available_width(), theme::ROW);
    ui.add_sized(size, control.suffix(suffix))
}

/// Draw how far along its range a value is, over the lower edge of its field.
fn fill(ui: &Ui, response: Response, share: f32) -> Response {
    let rect = response.rect;
    if !response.has_focus() {
        let width = rect.width() * share.clamp(0.0, 1.0);
        let bar = egui::Rect::from_min_size(egui::pos2(rect.left(), rect.bottom() - 2.0), vec2(width, 2.0));
        let colour = if response.hovered() || response.dragged() { theme::ACCENT } else { Color32::from_gray(112) };
        ui.painter().rect_filled(bar, 1.0, colour);
    }
    response
}

/// One parameter of the tables in `core`; `default`: what it is reset to.
pub fn param(ui: &mut Ui, param: &mut Param<'_>, default: Option<&str>) -> Option<Change> {
    let is_changed = default.is_some_and(|default| default != param.value.to_text());
    let (label, unit, range) = (param.label, param.unit, (param.min, param.max));
    let help = if unit.len() > LONGEST_UNIT { format!("{}, in {unit}", param.help) } else { param.help.to_owned() };
    let how = match &param.value {
        ParamValue::F32(_) | ParamValue::U32(_) => "Drag, with Shift slowly, or click and type",
        ParamValue::Colour(_) | ParamValue::Choice(_) => "Click to pick",
    };
    let key = param.key.clone();
    let (is_reset, response) = form_row(ui, label, &help, is_changed, |ui| match &mut param.value {
        ParamValue::F32(value) => number(ui, value, range, unit),
        ParamValue::U32(value) => integer(ui, value, (range.0 as u32, range.1 as u32), unit),
        ParamValue::Colour(rgb) => colour(ui, rgb),
        ParamValue::Choice(choice) => combo(ui, &key, &mut **choice),
    });
    let response = explained(response, &help, how);
    mark(ui.ctx(), || format!("value {}", param.key), response.rect);
    if is_reset && let Some(default) = default {
        param.set_from_text(default).ok()?;
        return Some(Change::once(format!("Reset {}", label.to_lowercase())));
    }
    Change::from_response(label, &response)
}

/// One of a few, by its name in a list.
fn combo(ui: &mut Ui, key: &str, choice: &mut dyn AnyChoice) -> Response {
    let (infos, index) = (choice.infos(), choice.index());
    let mut chosen = index;
    let list =
        egui::ComboBox::from_id_salt(key).width(ui.available_width()).selected_text(infos[index].label).truncate();
    let mut response = list
        .show_ui(ui, |ui| {
            for (i, info) in infos.iter().enumerate() {
                let row = ui.selectable_value(&mut chosen, i, info.label).on_hover_text(info.help);
                mark(ui.ctx(), || format!("choice {key}={}", info.name), row.rect);
            }
        })
        .response
        .on_hover_text(infos[index].help);
    if chosen != index {
        choice.set_index(chosen);
        response.mark_changed();
    }
    response
}

/// What a control is for, and how it is used.
pub fn explained(response: Response, help: &str, how: &str) -> Response {
    response.on_hover_ui(|ui| {
        if !help.is_empty() {
            ui.label(help);
        }
        ui.label(RichText::new(how).color(theme::TEXT_WEAK).small());
    })
}

/// A colour that opens a picker; linear RGB.
pub fn colour(ui: &mut Ui, rgb: &mut [f32; 3]) -> Response {
    // The button rounds what it is given, be it only drawn: untouched, a colour stays what it is.
    let mut edited = *rgb;
    let edit = |ui: &mut Ui| {
        ui.spacing_mut().interact_size = vec2(ui.available_width(), theme::ROW);
        ui.color_edit_button_rgb(&mut edited)
    };
    let response = ui.scope(edit).inner;
    if response.changed() {
        *rgb = edited;
    }
    response
}

/// A slot: its choice, what choices cost, and the parameters that belong to the choice.
pub fn slot(ui: &mut Ui, slot: &mut Slot<'_>, default: &mut Slot<'_>, notes: &Notes) -> Option<Change> {
    let mut change = None;
    let infos = slot.choice.infos();
    let index = slot.choice.index();
    let is_switch = infos.len() == 2 && infos[0].name == "on" && infos[1].name == "off";
    let is_changed = index != default.choice.index();
    let mut chosen = index;
    let note = notes.of(index).map(|note| (note, notes.what));
    let (is_reset, ()) = noted_row(ui, slot.label, slot.help, note, is_changed, |ui| {
        if is_switch {
            let mut is_on = index == 0;
            if switch(ui, &mut is_on).on_hover_text(slot.help).changed() {
                chosen = usize::from(!is_on);
            }
        } else {
            let width = ui.available_width();
            let combo = egui::ComboBox::from_id_salt(slot.key)
                .width(width)
                .height(LONGEST_LIST)
                .selected_text(infos[index].label)
                .truncate()
                .show_ui(ui, |ui| {
                    for (i, info) in infos.iter().enumerate() {
                        let cost = notes.of(i).map_or("", |note| note.all.as_str());
                        let row = egui::Button::selectable(i == chosen, info.label).shortcut_text(cost);
                        let choice = ui.add(row).on_hover_text(info.help);
                        if choice.clicked() {
                            chosen = i;
                        }
                        mark(ui.ctx(), || format!("choice {}={}", slot.key, info.name), choice.rect);
                    }
                })
                .response
                .on_hover_text(infos[index].help);
            mark(ui.ctx(), || format!("slot {}", slot.key), combo.rect);
        }
    });
    if is_reset {
        chosen = default.choice.index();
    }
    if chosen != index {
        slot.choice.set_index(chosen);
        change = Some(Change::once(format!("{}: {}", slot.label, infos[chosen].label)));
    }
    let name = infos[slot.choice.index()].name;
    let defaults: Vec<String> = default.params.iter().map(|param| param.value.to_text()).collect();
    ui.indent(slot.key, |ui| {
        for (i, one) in slot.params.iter_mut().enumerate() {
            if one.of.is_empty() || one.of.contains(&name) {
                change = param(ui, one, defaults.get(i).map(String::as_str)).or(change.take());
            }
        }
    });
    change
}

/// A switch that slides.
pub fn switch(ui: &mut Ui, is_on: &mut bool) -> Response {
    let (rect, mut response) = ui.allocate_exact_size(vec2(30.0, 16.0), Sense::click());
    if response.clicked() {
        *is_on = !*is_on;
        response.mark_changed();
    }
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, *is_on, ""));
    let share = ui.ctx().animate_bool_responsive(response.id, *is_on);
    let track = if *is_on { theme::ACCENT } else { theme::CONTROL };
    ui.painter().rect_filled(rect, 8.0, track);
    let x = egui::lerp(rect.left() + 8.0..=rect.right() - 8.0, share);
    let knob = if response.hovered() { Color32::WHITE } else { Color32::from_gray(225) };
    ui.painter().circle_filled(egui::pos2(x, rect.center().y), 5.5, knob);
    response
}

/// A heading within a panel, with a line under it.
pub fn section(ui: &mut Ui, title: &str) {
    ui.add_space(6.0);
    ui.label(RichText::new(title).strong().color(theme::TEXT_STRONG));
    let rect = ui.available_rect_before_wrap();
    ui.painter().hline(rect.x_range(), rect.top() - 1.0, egui::Stroke::new(1.0, theme::LINE));
    ui.add_space(4.0);
}

/// A time as people read it: `0.42 ms`, `12.3 ms`, `1.40 s`.
pub fn milliseconds(ms: f32) -> String {
    match ms {
        ms if ms >= 1000.0 => format!("{:.2} s", ms / 1000.0),
        ms if ms >= 100.0 => format!("{ms:.0} ms"),
        ms if ms >= 10.0 => format!("{ms:.1} ms"),
        ms => format!("{ms:.2} ms"),
    }
}

/// Memory as people read it: `96 MiB`, `0.3 MiB`.
pub fn mebibytes(n_bytes: u64) -> String {
    match n_bytes as f64 / f64::from(1 << 20) {
        mib if mib >= 10.0 || mib == 0.0 => format!("{mib:.0} MiB"),
        mib => format!("{mib:.1} MiB"),
    }
}

/// A count with thin spaces between thousands.
pub fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_is_typed_digit_by_digit_is_one_change() {
        use egui::{Event, Key, Modifiers, RawInput};
        let ctx = egui::Context::default();
        let (mut value, mut n_changes) = (1.0, 0);
        let mut frame = |events: Vec<Event>| {
            let mut output = ctx.run_ui(RawInput { events, ..RawInput::default() }, |ui| {
                let response = number(ui, &mut value, (0.0, 1.0), "");
                n_changes += u32::from(response.changed());
                if ui.ctx().memory(|memory| memory.focused().is_none()) && n_changes == 0 {
                    response.request_focus();
                }
            });
            output.textures_delta.clear();
        };
        let press =
            |key, modifiers| vec![Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }];
        for _ in 0..3 {
            frame(Vec::new());
        }
        frame(press(Key::A, Modifiers::COMMAND));
        for text in ["0", ".", "5"] {
            frame(vec![Event::Text(text.to_owned())]);
        }
        frame(press(Key::Enter, Modifiers::NONE));
        frame(Vec::new());
        assert_eq!((value, n_changes), (0.5, 1));
    }

    #[test]
    fn a_colour_that_is_only_looked_at_stays_what_it_is() {
        let ctx = egui::Context::default();
        let skin = lorelei_core::look::Look::default().skin_colour;
        let mut rgb = skin;
        for _ in 0..3 {
            let mut output = ctx.run_ui(egui::RawInput::default(), |ui| {
                colour(ui, &mut rgb);
            });
            output.textures_delta.clear();
        }
        assert_eq!(rgb, skin);
    }

    #[test]
    fn numbers_are_grouped_by_thousands() {
        assert_eq!(thousands(3), "3");
        assert_eq!(thousands(100_000), "100\u{202f}000");
        assert_eq!(thousands(3_200_000), "3\u{202f}200\u{202f}000");
    }
}
