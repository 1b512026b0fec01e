//! The look: every rendering question as a combo or a switch, what its choices cost beside them.

use egui::Ui;
use lorelei_core::edit::Edit;
use lorelei_core::look::Look;
use lorelei_core::look::presets::TERMS;

use super::widgets;
use crate::stage::shown::Solo;
use crate::window::desk::{Desk, merge_of};
use crate::window::room;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let mut look = desk.document.groom.look.clone();
    let mut default = Look::default();
    let mut change = None;
    {
        let mut slots = look.slots();
        let mut defaults = default.slots();
        for (slot, default) in slots.iter_mut().zip(&mut defaults) {
            let notes = desk.room.costs.notes(slot.key, slot.choice.infos().into_iter().map(|info| info.name));
            let of_slot = widgets::slot(ui, slot, default, &notes);
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
