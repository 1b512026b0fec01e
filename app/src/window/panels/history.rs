//! The history: a click goes there. What it keeps in memory, and how much that may be.

use egui::{Align2, RichText, Sense, Ui, vec2};

use crate::window::commands::Command;
use crate::window::desk::Desk;
use crate::window::{state_report, theme};

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    memory(ui, desk);
    let n_done = desk.document.history.n_done();
    let labels: Vec<String> =
        std::iter::once("Opened".to_owned()).chain(desk.document.history.labels().map(str::to_owned)).collect();
    let mut go_to = None;
    for (n, label) in labels.iter().enumerate().rev() {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
        state_report::mark(ui.ctx(), || format!("step {n}"), rect);
        if n == n_done {
            ui.painter().rect_filled(rect, 3.0, theme::ACCENT_DIM);
        } else if response.hovered() {
            ui.painter().rect_filled(rect, 3.0, theme::CONTROL);
        }
        let colour = if n > n_done { theme::TEXT_WEAK } else { theme::TEXT };
        let font = egui::TextStyle::Body.resolve(ui.style());
        ui.painter().text(rect.left_center() + vec2(8.0, 0.0), Align2::LEFT_CENTER, label, font, colour);
        let help = if n > n_done { "Do everything up to here again" } else { "Go back to here" };
        if response.on_hover_text(help).clicked() {
            go_to = Some(n);
        }
    }
    if labels.len() == 1 {
        ui.label(RichText::new("Changes are listed here; a click goes back to one.").color(theme::TEXT_WEAK));
    }
    if let Some(n) = go_to {
        desk.document.go_to(n);
    }
}

/// What the steps take, what they may take, and the way to forget them.
fn memory(ui: &mut Ui, desk: &mut Desk) {
    ui.horizontal(|ui| {
        let n_bytes = desk.document.history.n_bytes();
        let used = RichText::new(format!("{} of", megabytes(n_bytes))).small().color(theme::TEXT_WEAK);
        ui.label(used).on_hover_text("What the steps keep in memory beside the groom, each part counted once");
        let limit = egui::DragValue::new(&mut desk.settings.history_mib)
            .range(16..=65_536)
            .speed(8.0)
            .suffix(" MiB")
            .update_while_editing(false);
        let limit = ui.add(limit).on_hover_text("Beyond this the oldest steps are forgotten");
        state_report::mark(ui.ctx(), || "history limit".to_owned(), limit.rect);
        let has_steps = desk.document.history.labels().len() > 0;
        let clear = ui.add_enabled(has_steps, egui::Button::new("Clear").small());
        let clear = clear.on_hover_text(Command::ClearHistory.row().help);
        state_report::mark(ui.ctx(), || "history clear".to_owned(), clear.rect);
        if clear.clicked() {
            desk.asked.push(Command::ClearHistory);
        }
    });
}

fn megabytes(n_bytes: usize) -> String {
    match n_bytes as f64 / f64::from(1 << 20) {
        mib if mib < 10.0 => format!("{mib:.1} MiB"),
        mib => format!("{mib:.0} MiB"),
    }
}
