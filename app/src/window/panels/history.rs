//! The history: a click goes there.

use egui::{Align2, RichText, Sense, Ui, vec2};

use crate::window::desk::Desk;
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let n_done = desk.document.history.n_done();
    let labels: Vec<String> =
        std::iter::once("Opened".to_owned()).chain(desk.document.history.labels().map(str::to_owned)).collect();
    let mut go_to = None;
    for (n, label) in labels.iter().enumerate().rev() {
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
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
