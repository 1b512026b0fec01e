//! The painting tool's settings: which map, what is painted, the brush, and what is done to the whole map.

use egui::{RichText, Ui};
use lorelei_core::maps::MapKind;
use lorelei_core::maps::paint::PaintMode;
use lorelei_render::overlay::Veil;

use super::commands::{PaintCommand, is_enabled};
use super::{PaintTool, layer_idx};
use crate::window::commands::Command;
use crate::window::desk::Desk;
use crate::window::panels::widgets;
use crate::window::state_report::mark;
use crate::window::theme;
use crate::window::tools::brush_input;

pub fn ui(tool: &mut PaintTool, ui: &mut Ui, desk: &mut Desk) {
    let Some(layer_idx) = layer_idx(desk) else {
        ui.label("There is no layer of hair to paint maps for.");
        return;
    };
    if desk.document.groom.head.is_none() {
        ui.label("There is no head to paint on: import one, or put the mannequin on in its properties.");
        return;
    }
    let layer = &desk.document.groom.layers[layer_idx];
    ui.label(RichText::new(format!("For the layer {}", layer.name)).color(theme::TEXT_WEAK));
    let mut kinds: Vec<MapKind> = MapKind::PLAIN.to_vec();
    kinds.extend(layer.maps.keys().filter(|kind| !MapKind::PLAIN.contains(kind)).cloned());
    for kind in (1..4).flat_map(|level| [MapKind::LodDensity(level), MapKind::LodThickness(level)]) {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    }
    if !kinds.contains(&tool.kind) {
        kinds.push(tool.kind.clone());
    }
    let chosen = tool.kind.clone();
    let help = "What the map changes; a dot marks those that the layer has";
    widgets::form_row(ui, "Map", help, false, |ui| {
        let combo = egui::ComboBox::from_id_salt("paint map")
            .width(ui.available_width())
            .selected_text(chosen.label())
            .show_ui(ui, |ui| {
                for kind in kinds {
                    let dot = if layer.maps.contains_key(&kind) { " \u{2022}" } else { "" };
                    let text = format!("{}{dot}", kind.label());
                    let choice = ui.selectable_label(kind == chosen, text).on_hover_text(kind.help());
                    mark(ui.ctx(), || format!("choice map={kind}"), choice.rect);
                    if choice.clicked() {
                        tool.take_kind(kind);
                    }
                }
            })
            .response
            .on_hover_text(chosen.help());
        mark(ui.ctx(), || "slot map".to_owned(), combo.rect);
    });
    widgets::form_row(ui, "New mask", "A region under a name, for operators to be limited to", false, |ui| {
        let button = ui.small_button("Take").on_hover_text("Paint the mask of this name");
        ui.text_edit_singleline(&mut tool.mask_name).on_hover_text("Its name");
        if button.clicked() && !tool.mask_name.trim().is_empty() {
            tool.take_kind(MapKind::Mask(tool.mask_name.trim().to_owned()));
        }
    });
    let mode_help = "Ctrl turns it round, Shift smooths";
    widgets::form_row(ui, "Brush", mode_help, false, |ui| {
        let combo = egui::ComboBox::from_id_salt("paint mode")
            .width(ui.available_width())
            .selected_text(tool.mode.label())
            .show_ui(ui, |ui| {
                for mode in PaintMode::ALL {
                    ui.selectable_value(&mut tool.mode, mode, mode.label()).on_hover_text(mode.help());
                }
            })
            .response
            .on_hover_text(tool.mode.help());
        mark(ui.ctx(), || "slot paint mode".to_owned(), combo.rect);
    });
    let most = tool.kind.max_value();
    let value_help = format!("In {}; S takes it from under the pointer", tool.kind.unit());
    let (_, response) =
        widgets::form_row(ui, "Value", &value_help, false, |ui| widgets::number(ui, &mut tool.value, (0.0, most), ""));
    mark(ui.ctx(), || "value paint".to_owned(), response.rect);
    response.on_hover_text(value_help);
    brush_input::panel(ui, &mut tool.brush);
    widgets::section(ui, "Shown");
    let help = "The map's values as colours on the scalp";
    widgets::form_row(ui, "Map on the scalp", help, false, |ui| {
        widgets::switch(ui, &mut tool.shows_map).on_hover_text(help);
    });
    let label = |veil: Veil| match veil {
        Veil::Full => "All",
        Veil::Thin => "Thin",
        Veil::Hidden => "None",
    };
    let help = "How much of the hair is drawn while a map is shown";
    widgets::form_row(ui, "Hair", help, false, |ui| {
        let combo = egui::ComboBox::from_id_salt("paint veil")
            .width(ui.available_width())
            .selected_text(label(tool.veil))
            .show_ui(ui, |ui| {
                for veil in Veil::ALL {
                    let choice = ui.selectable_value(&mut tool.veil, veil, label(veil));
                    mark(ui.ctx(), || format!("choice hair={}", label(veil)), choice.rect);
                }
            })
            .response
            .on_hover_text(help);
        mark(ui.ctx(), || "slot paint hair".to_owned(), combo.rect);
    });
    widgets::section(ui, "The whole map");
    ui.horizontal_wrapped(|ui| {
        for (command, label) in [
            (PaintCommand::Fill, "Fill"),
            (PaintCommand::Clear, "Erase"),
            (PaintCommand::Invert, "Invert"),
            (PaintCommand::Load, "Load\u{2026}"),
            (PaintCommand::Save, "Save\u{2026}"),
        ] {
            let enabled = is_enabled(desk, command);
            let help = Command::Paint(command).row().help;
            let button = ui.add_enabled(enabled, egui::Button::new(label)).on_hover_text(help);
            mark(ui.ctx(), || format!("paint {label}"), button.rect);
            if button.clicked() {
                desk.asked.push(Command::Paint(command));
            }
        }
    });
    let help = "A PNG is written with 16 bits; what is painted has 8";
    widgets::form_row(ui, "16-bit PNG", help, false, |ui| {
        widgets::switch(ui, &mut tool.is_16_bit).on_hover_text(help);
    });
}
