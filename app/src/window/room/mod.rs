//! Look development: another look beside the document's own, one term of the light alone, what false colours mean, and
//! what is under the pointer. Nothing here is part of the document; what changes it goes through edits.

pub mod commands;
pub mod costs;
mod inspector;
mod legend;
mod wipe;

use egui::{Rect, Response, Ui, pos2, vec2};
use lorelei_core::look::Look;
use lorelei_core::look::presets::TERMS;
use lorelei_render::versus::Comparison;

use super::commands::Command;
use super::desk::Desk;
use super::state_report::mark;
use super::theme;
use crate::stage::shown::{Shown, Solo};
use commands::RoomCommand;
use costs::Costs;

/// How the other look is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Beside {
    #[default]
    Nothing,
    Wipe,
    Difference,
}

/// The room's own state.
#[derive(Debug)]
pub struct Room {
    pub solo: Option<Solo>,
    /// Look B.
    pub other: Option<Look>,
    pub beside: Beside,
    /// Where the wipe's line is, as a share of the width.
    pub wipe: f32,
    /// What a difference is multiplied with.
    pub gain: f32,
    /// The inspector tells what is under the pointer.
    pub inspects: bool,
    /// Pixel of the picture under the pointer, while it inspects.
    pub pixel: Option<[u32; 2]>,
    /// What the choices of the look have cost so far.
    pub costs: Costs,
    /// Slot of the next contact sheet: the one that was used last.
    pub slot: &'static str,
}

impl Default for Room {
    fn default() -> Self {
        Self {
            solo: None,
            other: None,
            beside: Beside::Nothing,
            wipe: 0.5,
            gain: 4.0,
            inspects: false,
            pixel: None,
            costs: Costs::default(),
            slot: "shadowing",
        }
    }
}

impl Room {
    /// What the stage is to show.
    pub fn shown(&self) -> Shown {
        let comparison = match self.beside {
            Beside::Nothing => None,
            Beside::Wipe => Some(Comparison::Wipe(self.wipe)),
            Beside::Difference => Some(Comparison::Difference(self.gain)),
        };
        Shown { solo: self.solo, versus: self.other.clone().zip(comparison) }
    }

    /// Show this alone, or everything again where it is alone already.
    pub fn toggle_solo(&mut self, solo: Solo) {
        self.solo = if self.solo == Some(solo) { None } else { Some(solo) };
    }
}

/// What is alone, in words.
pub fn solo_name(desk: &Desk, solo: Solo) -> String {
    match solo {
        Solo::Term(term) => {
            TERMS.iter().find(|(key, _)| *key == term).map_or_else(|| term.to_owned(), |(_, name)| (*name).to_owned())
        }
        Solo::Light(light_idx) => {
            desk.document.groom.lights.get(light_idx).map_or_else(|| "a lamp".to_owned(), |light| light.name.clone())
        }
    }
}

/// A button that shows one term or lamp alone; pressed while it does.
pub fn solo_button(ui: &mut Ui, desk: &mut Desk, solo: Solo) {
    let is_solo = desk.room.solo == Some(solo);
    let name = solo_name(desk, solo);
    let colour = if is_solo { theme::TEXT_STRONG } else { theme::TEXT_WEAK };
    let fill = if is_solo { theme::ACCENT_DIM } else { theme::CONTROL };
    let text = egui::RichText::new("Solo").small().color(colour);
    let response = ui.add(egui::Button::new(text).fill(fill).small());
    mark(ui.ctx(), || format!("solo {name}"), response.rect);
    if response.on_hover_text(format!("Show {name} alone, or everything again; the groom stays as it is")).clicked() {
        desk.room.toggle_solo(solo);
    }
}

/// Everything of the room that lies over the picture; true while something of it is dragged.
pub fn viewport(ui: &mut Ui, desk: &mut Desk, rect: Rect, response: &Response) -> bool {
    let is_dragging = wipe::ui(ui, desk, rect);
    legend::ui(ui, &desk.document.groom, rect);
    solo_mark(ui, desk, rect);
    inspector::ui(ui, desk, rect, response);
    is_dragging
}

/// A line around the picture and words at its top, while only a part of the light is shown.
fn solo_mark(ui: &mut Ui, desk: &mut Desk, rect: Rect) {
    let Some(solo) = desk.room.solo else { return };
    ui.painter().rect_stroke(rect.shrink(1.0), 0.0, egui::Stroke::new(2.0, theme::ACCENT), egui::StrokeKind::Inside);
    let text = egui::RichText::new(format!("SOLO  {}  \u{d7}", solo_name(desk, solo))).color(theme::TEXT_STRONG);
    let place = Rect::from_center_size(pos2(rect.center().x, rect.top() + 22.0), vec2(220.0, 24.0));
    let end = ui.put(place, egui::Button::new(text).fill(theme::ACCENT_DIM));
    mark(ui.ctx(), || "end solo".to_owned(), end.rect);
    if end.on_hover_text("Only this part of the light is shown. Click: all of it again").clicked() {
        desk.asked.push(Command::Room(RoomCommand::EndSolo));
    }
}

/// For the state report.
pub fn report(desk: &Desk) -> serde_json::Value {
    let room = &desk.room;
    let inspected = desk.report.inspection.as_ref().filter(|_| room.inspects);
    serde_json::json!({
        "solo": room.solo.map(|solo| solo_name(desk, solo)),
        "beside": format!("{:?}", room.beside),
        "wipe": room.wipe,
        "costs": room.costs.report(),
        "has_other": room.other.is_some(),
        "inspects": room.inspects,
        "inspected": inspected.map(|inspection| serde_json::json!({
            "pixel": inspection.pixel,
            "strand": inspection.strand.as_ref().map(|strand| strand.id),
            "terms": inspection.strand.as_ref().map_or(0, |strand| strand.terms.len()),
        })),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_compared_without_another_look_and_solo_ends_as_it_began() {
        let mut room = Room { beside: Beside::Wipe, ..Room::default() };
        assert_eq!(room.shown(), Shown::default());
        room.other = Some(Look::default());
        assert_eq!(room.shown().versus, Some((Look::default(), Comparison::Wipe(0.5))));
        room.toggle_solo(Solo::Term("r"));
        room.toggle_solo(Solo::Light(0));
        assert_eq!(room.shown().solo, Some(Solo::Light(0)));
        room.toggle_solo(Solo::Light(0));
        assert_eq!(room.shown().solo, None);
    }
}
