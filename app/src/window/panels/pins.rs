//! Pins: what holds hair to its place on the head, in a list, and every number of the one that is selected.

use egui::{Ui, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::pin::{self, Pin};

use super::widgets::{self, Change, form_row};
use crate::window::desk::{Desk, Selection, merge_of};
use crate::window::state_report::mark;
use crate::window::theme;

const ON_HELP: &str = "Whether it holds hair";

/// The section of the movement panel.
pub fn section(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "Pins");
    let help = "A hair pin, a clip, a part of a band: what lies in it stays in its place on the head. \
                It comes to where the middle of the picture shows hair";
    let button = ui.button("+ Pin").on_hover_text(help);
    mark(ui.ctx(), || "add pin".to_owned(), button.rect);
    if button.clicked() {
        add(desk);
    }
    for pin_idx in 0..desk.document.groom.simulation.pins.len() {
        ui.push_id(("pin", pin_idx), |ui| row(ui, desk, pin_idx));
    }
    if let Selection::Pin(pin_idx) = desk.selection {
        one(ui, desk, pin_idx);
    }
}

fn row(ui: &mut Ui, desk: &mut Desk, pin_idx: usize) {
    let mut pins = desk.document.groom.simulation.pins.clone();
    let name = pins[pin_idx].name.clone();
    let mut change = None;
    ui.horizontal(|ui| {
        if widgets::switch(ui, &mut pins[pin_idx].on).on_hover_text(ON_HELP).changed() {
            change = Some(format!("Switch {name}"));
        }
        let is_selected = desk.selection == Selection::Pin(pin_idx);
        let label = ui.selectable_label(is_selected, &name);
        if label.on_hover_text("Click to select it: its handles are in the viewport").clicked() {
            desk.selection = if is_selected { Selection::Head } else { Selection::Pin(pin_idx) };
        }
        let side = egui::Layout::right_to_left(egui::Align::Center);
        ui.with_layout(side, |ui| {
            if ui.add(egui::Button::new("\u{d7}").min_size(vec2(20.0, 18.0))).on_hover_text("Remove it").clicked() {
                change = Some(format!("Remove {name}"));
                pins.remove(pin_idx);
            }
        });
    });
    if let Some(label) = change {
        desk.document.edit(&label, Edit::SetPins(pins), Merge::New);
        desk.clamp_selection();
    }
}

/// A new one on the hair in the middle of the picture.
fn add(desk: &mut Desk) {
    let head_from_world = desk.report.world_from_head.inverse();
    let eye = desk.camera.eye();
    let direction = (desk.camera.target - eye).normalize_or(glam::Vec3::NEG_Z);
    let (eye, direction) = (head_from_world.transform_point3(eye), head_from_world.transform_vector3(direction));
    let groom = &desk.document.groom;
    let mut pins = groom.simulation.pins.clone();
    let name = format!("Pin {}", pins.len() + 1);
    let centre = pin::place_seen(groom, eye, direction).unwrap_or(desk.centre());
    pins.push(Pin { name: name.clone(), centre, ..Pin::default() });
    desk.selection = Selection::Pin(pins.len() - 1);
    desk.document.edit(&format!("Add {name}"), Edit::SetPins(pins), Merge::New);
}

/// Every number of one pin.
pub fn one(ui: &mut Ui, desk: &mut Desk, pin_idx: usize) {
    let mut pins = desk.document.groom.simulation.pins.clone();
    let Some(pin) = pins.get_mut(pin_idx) else { return };
    if let Some(change) = form(ui, pin) {
        desk.document.edit(&change.label, Edit::SetPins(pins), merge_of(change.drag));
    }
}

fn form(ui: &mut Ui, pin: &mut Pin) -> Option<Change> {
    let mut change = None;
    let mut row = |ui: &mut Ui, name: &str, help: &str, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
        let (_, response) = form_row(ui, name, help, false, control);
        let label = format!("Pin {}", name.to_lowercase());
        if let Some(one) = Change::from_response(&label, &response.on_hover_text(help)) {
            change = Some(one);
        }
    };
    row(ui, "Name", "Click and type", &mut |ui| {
        ui.add(egui::TextEdit::singleline(&mut pin.name).desired_width(f32::INFINITY))
    });
    row(ui, "On", ON_HELP, &mut |ui| widgets::switch(ui, &mut pin.on));
    row(ui, "Radius", "What lies in it is held", &mut |ui| widgets::number(ui, &mut pin.radius, pin::RADII, "cm"));
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        row(ui, name, "Its middle, on the head", &mut |ui| {
            let control = egui::DragValue::new(&mut pin.centre[axis]).speed(0.05).max_decimals(2).suffix(" cm");
            ui.add_sized(vec2(ui.available_width(), theme::ROW), control.update_while_editing(false))
        });
    }
    change
}
