//! The sculpting tool's settings: the brushes, the sculpt layers, and the brush's size and strength.

use egui::{RichText, Ui};
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;
use lorelei_core::maps::MapKind;
use lorelei_core::sculpt::{SculptInfo, SculptLayer, SculptMask};

use super::commands::{SculptCommand, is_enabled};
use super::{SculptTool, layer_idx, palette};
use crate::window::commands::Command;
use crate::window::desk::Desk;
use crate::window::panels::widgets;
use crate::window::state_report::mark;
use crate::window::theme;
use crate::window::tools::brush_input;

pub fn ui(tool: &mut SculptTool, ui: &mut Ui, desk: &mut Desk) {
    let Some(layer_idx) = layer_idx(desk) else {
        ui.label("There is no layer of hair to brush.");
        return;
    };
    let name = &desk.document.groom.layers[layer_idx].name;
    ui.label(RichText::new(format!("On the layer {name}")).color(theme::TEXT_WEAK));
    palette::ui(ui, &mut tool.kind);
    ui.label(RichText::new(tool.kind.info().help).color(theme::TEXT_WEAK));
    brush_input::panel(ui, &mut tool.brush);
    ui.label(RichText::new("Ctrl turns a brush round, Shift smooths, Esc gives a stroke up").color(theme::TEXT_WEAK));
    layers(tool, ui, desk, layer_idx);
}

/// The sculpt layers, the topmost first.
fn layers(tool: &mut SculptTool, ui: &mut Ui, desk: &mut Desk, layer_idx: usize) {
    widgets::section(ui, "Sculpt layers");
    let sculpts: Vec<SculptInfo> =
        desk.document.groom.layers[layer_idx].sculpt.layers.iter().map(SculptLayer::info).collect();
    tool.sculpt_idx = tool.sculpt_idx.min(sculpts.len().saturating_sub(1));
    ui.horizontal_wrapped(|ui| {
        for (command, label) in [
            (SculptCommand::AddLayer, "Add"),
            (SculptCommand::RemoveLayer, "Remove"),
            (SculptCommand::MergeDown, "Merge down"),
            (SculptCommand::Thaw, "Thaw all"),
            (SculptCommand::InvertFrozen, "Invert frozen"),
        ] {
            // The tool itself is out of the desk while its panel is shown.
            let is_possible = match command {
                SculptCommand::AddLayer => is_enabled(desk, command),
                SculptCommand::MergeDown => tool.sculpt_idx > 0 && tool.sculpt_idx < sculpts.len(),
                _ => !sculpts.is_empty(),
            };
            let help = Command::Sculpt(command).row().help;
            let button = ui.add_enabled(is_possible, egui::Button::new(label)).on_hover_text(help);
            mark(ui.ctx(), || format!("sculpt {label}"), button.rect);
            if button.clicked() {
                desk.asked.push(Command::Sculpt(command));
            }
        }
    });
    if sculpts.is_empty() {
        ui.label(RichText::new("The first stroke makes one.").color(theme::TEXT_WEAK));
    }
    let mut edit = None;
    for (sculpt_idx, info) in sculpts.iter().enumerate().rev() {
        let set = |info: SculptInfo| Edit::SetSculptInfo { layer_idx, sculpt_idx, info };
        ui.horizontal(|ui| {
            let mut on = info.on;
            if widgets::switch(ui, &mut on).on_hover_text("Whether its strokes are seen").clicked() {
                edit = Some(("Switch a sculpt layer", set(SculptInfo { on, ..info.clone() }), Merge::New));
            }
            let row = ui
                .selectable_label(tool.sculpt_idx == sculpt_idx, &info.name)
                .on_hover_text("Strokes go to the chosen layer");
            mark(ui.ctx(), || format!("sculpt layer {}", info.name), row.rect);
            if row.clicked() {
                tool.sculpt_idx = sculpt_idx;
            }
            for (text, to, help) in
                [("\u{25b2}", sculpt_idx + 1, "One higher"), ("\u{25bc}", sculpt_idx.wrapping_sub(1), "One lower")]
            {
                let button = ui.add_enabled(to < sculpts.len(), egui::Button::new(text).small());
                if button.on_hover_text(help).clicked() {
                    if tool.sculpt_idx == sculpt_idx {
                        tool.sculpt_idx = to;
                    }
                    edit =
                        Some(("Move a sculpt layer", Edit::MoveSculpt { layer_idx, from: sculpt_idx, to }, Merge::New));
                }
            }
        });
    }
    if let Some(info) = sculpts.get(tool.sculpt_idx) {
        let sculpt_idx = tool.sculpt_idx;
        let set = |info: SculptInfo| Edit::SetSculptInfo { layer_idx, sculpt_idx, info };
        let drag = Merge::Drag(0x5C01_0000 + sculpt_idx as u64);
        widgets::form_row(ui, "Name", "Of the chosen sculpt layer", false, |ui| {
            // What is being typed; it counts once the field is left.
            let draft = ui.scope_id().with(("name of sculpt layer", sculpt_idx));
            let mut name = ui.data(|data| data.get_temp(draft)).unwrap_or_else(|| info.name.clone());
            let field = ui.text_edit_singleline(&mut name).on_hover_text("Its name");
            if field.lost_focus() {
                ui.data_mut(|data| data.remove::<String>(draft));
                if name != info.name {
                    edit = Some(("Rename a sculpt layer", set(SculptInfo { name, ..info.clone() }), Merge::New));
                }
            } else if field.changed() {
                ui.data_mut(|data| data.insert_temp(draft, name));
            }
        });
        let mut weight = info.weight;
        let help = "0 is without effect, 1 as it was brushed";
        widgets::form_row(ui, "Weight", help, false, |ui| {
            let number = widgets::number(ui, &mut weight, (0.0, 1.0), "");
            mark(ui.ctx(), || "value sculpt weight".to_owned(), number.rect);
            if number.on_hover_text(help).changed() {
                edit = Some(("Weigh a sculpt layer", set(SculptInfo { weight, ..info.clone() }), drag));
            }
        });
        let maps: Vec<MapKind> = desk.document.groom.layers[layer_idx].maps.keys().cloned().collect();
        if let Some(mask) = choose_mask(ui, &info.mask, &maps) {
            edit = Some(("Mask a sculpt layer", set(SculptInfo { mask, ..info.clone() }), Merge::New));
        }
    }
    if let Some((label, edit, merge)) = edit {
        desk.document.edit(label, edit, merge);
    }
}

fn mask_label(mask: &SculptMask) -> String {
    match mask {
        SculptMask::Everywhere => "Everywhere".to_owned(),
        SculptMask::Painted => "Less where the mask brush painted".to_owned(),
        SculptMask::Inverted => "Only where the mask brush painted".to_owned(),
        SculptMask::Map(kind) => format!("By the map {}", kind.label()),
    }
}

fn choose_mask(ui: &mut Ui, mask: &SculptMask, maps: &[MapKind]) -> Option<SculptMask> {
    let help = "Where the sculpt layer acts";
    let mut chosen = None;
    widgets::form_row(ui, "Mask", help, false, |ui| {
        let painted = [SculptMask::Everywhere, SculptMask::Painted, SculptMask::Inverted];
        let all = painted.into_iter().chain(maps.iter().cloned().map(SculptMask::Map));
        egui::ComboBox::from_id_salt("sculpt mask")
            .width(ui.available_width())
            .selected_text(mask_label(mask))
            .show_ui(ui, |ui| {
                for choice in all {
                    if ui.selectable_label(choice == *mask, mask_label(&choice)).clicked() {
                        chosen = Some(choice);
                    }
                }
            })
            .response
            .on_hover_text(help);
    });
    chosen
}
