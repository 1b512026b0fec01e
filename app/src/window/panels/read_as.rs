//! What an import's numbers were taken for: a guess that is shown and can be corrected.

use egui::Ui;
use lorelei_core::history::Merge;
use lorelei_core::io::{Axis, Space, Unit, reread};

use super::widgets::{form_row, section};
use crate::window::document::Document;

/// Unit and axes of an imported layer or head. A change moves all that was imported alike, as one step.
pub fn ui(ui: &mut Ui, document: &mut Document, read_as: Option<Space>) {
    let Some(from) = read_as else { return };
    section(ui, "Read as");
    let mut to = from;
    if let Some(unit) = combo(ui, "Unit", "Of the numbers in the file", from.unit, &Unit::ALL, Unit::label) {
        to.unit = unit;
    }
    let up = combo(ui, "Up", "The file's axis that points up", from.up, &Axis::ALL, Axis::label);
    if let Some(up) = up {
        to = to.with_up(up);
    }
    let sides: Vec<Axis> = Axis::ALL.into_iter().filter(|axis| axis.vector().dot(to.up.vector()) == 0.0).collect();
    let front = combo(ui, "Front", "The file's axis that the face looks along", from.front, &sides, Axis::label);
    if let Some(front) = front {
        to.front = front;
    }
    if to != from {
        let edit = reread(&document.groom, from, to);
        document.edit("Read import differently", edit, Merge::New);
    }
}

/// A row with a choice; `Some` where another one was chosen.
fn combo<T: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    help: &str,
    now: T,
    all: &[T],
    label: impl Fn(T) -> &'static str,
) -> Option<T> {
    let mut chosen = now;
    form_row(ui, name, help, false, |ui| {
        let width = ui.available_width();
        let combo = egui::ComboBox::from_id_salt(("read as", name)).width(width).selected_text(label(now));
        let combo = combo.show_ui(ui, |ui| {
            for &one in all {
                ui.selectable_value(&mut chosen, one, label(one));
            }
        });
        combo.response.on_hover_text(help);
    });
    (chosen != now).then_some(chosen)
}
