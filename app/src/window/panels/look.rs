//! The look: every rendering question as a combo or a switch, its cost beside it.

use egui::Ui;
use lorelei_core::edit::Edit;
use lorelei_core::look::Look;
use lorelei_core::look::presets::TERMS;

use super::widgets;
use crate::stage::shown::Solo;
use crate::window::desk::{Desk, merge_of};
use crate::window::room;

/// What a pass is called decides which slot it is shown beside; the first match counts.
const COSTS: &[(&str, &[&str])] = &[
    ("primitive", &["raster", "ribbon", "generate", "bin", "visib"]),
    ("transparency", &["composit", "transparen", "resolve"]),
    ("scattering", &["shade", "scatter"]),
    ("shadowing", &["shadow", "opacity"]),
    ("head", &["head", "skin"]),
    ("tonemapping", &["tonemap", "post"]),
    ("background", &["background"]),
];

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let mut look = desk.document.groom.look.clone();
    let mut default = Look::default();
    let mut change = None;
    {
        let mut slots = look.slots();
        let mut defaults = default.slots();
        for (slot, default) in slots.iter_mut().zip(&mut defaults) {
            // A frame may leave out passes whose results stand; then the last time counts.
            let cost = desk.times.iter().rev().find_map(|frame| cost_ms(slot.key, &frame.passes));
            let of_slot = widgets::slot(ui, slot, default, cost);
            if of_slot.is_some() {
                desk.room.slot = slot.key;
            }
            change = of_slot.or(change);
            if TERMS.iter().any(|(term, _)| *term == slot.key) {
                ui.indent(("solo", slot.key), |ui| room::solo_button(ui, desk, Solo::Term(slot.key)));
            }
            ui.add_space(3.0);
        }
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetLook(Box::new(look)), merge_of(change.drag));
    }
}

/// GPU time of the passes that answer a slot's question; `None` where no pass is its own.
pub fn cost_ms(slot_key: &str, pass_times: &[(String, f32)]) -> Option<f32> {
    let slot_of = |pass: &str| {
        let pass = pass.to_lowercase();
        COSTS.iter().find(|(_, parts)| parts.iter().any(|part| pass.contains(part))).map(|(key, _)| *key)
    };
    let mut times = pass_times.iter().filter(|(pass, _)| slot_of(pass) == Some(slot_key)).peekable();
    times.peek()?;
    Some(times.map(|(_, ms)| ms).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_are_added_up_beside_their_slot() {
        let times =
            [("shadow.deep_opacity".to_owned(), 1.0), ("raster.bin".to_owned(), 2.0), ("raster.fine".to_owned(), 3.0)];
        assert_eq!(cost_ms("primitive", &times), Some(5.0));
        assert_eq!(cost_ms("shadowing", &times), Some(1.0));
        assert_eq!(cost_ms("background", &times), None);
    }
}
