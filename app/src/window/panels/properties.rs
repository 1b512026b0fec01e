//! What is selected: a layer's counts, widths, fibre and style stack; the head; a light.

use egui::{RichText, Ui};
use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, HairMaterial, HairPreset, Head, Layer, Source};
use lorelei_core::history::Merge;
use lorelei_core::layers::Companion;
use lorelei_core::look::Choice;
use lorelei_core::look::ParamValue;

use super::widgets::{self, Change, section, thousands};
use crate::window::commands::Command;
use crate::window::desk::{Desk, Selection, merge_of};
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    match desk.selection {
        Selection::Head => head(ui, desk),
        Selection::Layer(layer_idx) => layer(ui, desk, layer_idx),
        Selection::Light(light_idx) => super::lights::one(ui, desk, light_idx),
        Selection::Collider(collider_idx) => super::colliders::one(ui, desk, collider_idx),
        Selection::Pin(pin_idx) => super::pins::one(ui, desk, pin_idx),
        Selection::Wind(source_idx) => super::wind::one(ui, desk, source_idx),
    }
}

fn head(ui: &mut Ui, desk: &mut Desk) {
    if let Some(head) = &desk.document.groom.head {
        described_head(ui, head);
    } else {
        ui.label("Hair without a head: nothing to collide with, nothing to cast shadows on.");
        if ui.button("Use the mannequin").on_hover_text("The studio's own salon head").clicked() {
            let edit = Edit::SetHead(Some(lorelei_assets::mannequin()));
            desk.document.edit("Use the mannequin", edit, Merge::New);
            desk.measure();
        }
    }
    let read_as = desk.document.groom.head.as_ref().and_then(|head| head.read_as);
    super::read_as::ui(ui, &mut desk.document, read_as);
    ui.add_space(6.0);
    if desk.document.groom.head.is_some() {
        let button = ui.button("Remove the head").on_hover_text("Hair alone; undo brings it back");
        if button.clicked() {
            desk.document.edit("Remove the head", Edit::SetHead(None), Merge::New);
            desk.measure();
        }
    }
    if ui.button("Import another head\u{2026}").on_hover_text(Command::ImportHead.row().help).clicked() {
        desk.asked.push(Command::ImportHead);
    }
}

fn described_head(ui: &mut Ui, head: &Head) {
    ui.heading(&head.name);
    let mesh = &head.mesh;
    ui.label(format!("{} triangles", thousands(mesh.triangles.len() as u64)));
    if let Some((min, max)) = mesh.bounds() {
        let size = max - min;
        ui.label(format!("{:.1} \u{d7} {:.1} \u{d7} {:.1} cm", size.x, size.y, size.z));
    }
    if mesh.groups.is_empty() {
        ui.label(RichText::new("No named face groups").color(theme::TEXT_WEAK));
    }
    for group in &mesh.groups {
        let text = format!("{}: {} faces", group.name, thousands(group.triangles.len() as u64));
        ui.label(RichText::new(text).color(theme::TEXT_WEAK));
    }
}

fn layer(ui: &mut Ui, desk: &mut Desk, layer_idx: usize) {
    let Some(shown) = desk.document.groom.layers.get(layer_idx) else { return };
    let mut layer = shown.clone();
    ui.horizontal(|ui| {
        ui.heading(&layer.name);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.label(RichText::new(described(&layer.source)).color(theme::TEXT_WEAK));
        });
    });
    sharing(ui, desk, layer_idx);
    section(ui, "Fibre");
    let mut default_material = HairMaterial::default();
    let mut material_change = presets(ui, &mut layer.material);
    {
        let mut default = default_material.slot();
        let mut slot = layer.material.slot();
        material_change = widgets::slot(ui, &mut slot, &mut default, &widgets::Notes::default()).or(material_change);
    }
    section(ui, "Strands");
    let mut default = Layer::new("", layer.source.clone());
    default.n_strands = layer.n_strands;
    let defaults: Vec<(String, String)> =
        default.params().iter().map(|param| (param.key.clone(), param.value.to_text())).collect();
    let mut layer_change = None;
    for mut param in layer.params() {
        let default = defaults.iter().find(|(key, _)| *key == param.key).map(|(_, text)| text.as_str());
        // Where the strand count is the style's own, there is no other default to go back to.
        let default = if matches!(param.value, ParamValue::U32(_)) { None } else { default };
        layer_change = widgets::param(ui, &mut param, default).or(layer_change);
    }
    section(ui, "Style");
    let style_change = super::style::ui(ui, &mut layer, &mut desk.asked);
    let document = &mut desk.document;
    super::read_as::ui(ui, document, layer.read_as);
    if let Some(change) = material_change {
        let edit = Edit::SetMaterial { layer_idx, material: layer.material };
        document.edit(&change.label, edit, merge_of(change.drag));
    } else if let Some(change) = style_change {
        document.edit(&change.label, Edit::SetStyle { layer_idx, style: layer.style }, merge_of(change.drag));
    } else if let Some(change) = layer_change {
        let edit = Edit::SetLayer { layer_idx, layer: Box::new(layer) };
        document.edit(&change.label, edit, merge_of(change.drag));
    }
}

/// Which layers trace the same source, and the way out of it.
fn sharing(ui: &mut Ui, desk: &mut Desk, layer_idx: usize) {
    let groom = &desk.document.groom;
    let others = groom.layers_sharing(layer_idx).into_iter().filter(|&other| other != layer_idx);
    let names: Vec<&str> = others.map(|other| groom.layers[other].name.as_str()).collect();
    if names.is_empty() {
        return;
    }
    ui.horizontal_wrapped(|ui| {
        let text = format!("Shared with {}: edits of its shape count for all", names.join(", "));
        ui.label(RichText::new(text).color(theme::TEXT_WEAK).small());
        let row = Command::DetachLayer.row();
        if ui.small_button("Make its own").on_hover_text(row.help).clicked() {
            desk.asked.push(Command::DetachLayer);
        }
    });
}

fn described(source: &Source) -> String {
    match source {
        Source::HairMesh(mesh) => {
            let n_bundles = mesh.layers.first().map_or(0, |layer| layer.faces.len());
            format!("hair mesh, {} bundles", thousands(n_bundles as u64))
        }
        Source::Guides(guides) => format!("{} guides", thousands(guides.n_strands() as u64)),
        Source::Strands(strands) => format!("{} points", thousands(strands.n_points() as u64)),
    }
}

fn presets(ui: &mut Ui, material: &mut HairMaterial) -> Option<Change> {
    let mut change = None;
    ui.horizontal_wrapped(|ui| {
        for &preset in HairPreset::ALL {
            let info = preset.info();
            if ui.small_button(info.label).on_hover_text(info.help).clicked() {
                material.take(preset);
                change = Some(Change::once(format!("{} hair", info.label)));
            }
        }
    });
    change
}

/// Add, copy or remove layers as the commands ask.
pub fn layer_command(desk: &mut Desk, command: Command) {
    let Selection::Layer(layer_idx) = desk.selection else { return };
    let groom: &Groom = &desk.document.groom;
    let Some(layer) = groom.layers.get(layer_idx) else { return };
    match command {
        Command::ToggleLayer => {
            let visible = !layer.visible;
            let label = format!("{} {}", if visible { "Show" } else { "Hide" }, layer.name);
            desk.document.edit(&label, Edit::SetLayerVisible { layer_idx, visible }, Merge::New);
        }
        Command::DuplicateLayer => {
            let mut copy = layer.clone();
            copy.name = format!("{} copy", layer.name);
            let edit = Edit::AddLayer { layer_idx: layer_idx + 1, layer: Box::new(copy) };
            desk.document.edit("Duplicate layer", edit, Merge::New);
            desk.selection = Selection::Layer(layer_idx + 1);
        }
        Command::DetachLayer => {
            let edit = Edit::SetSource { layer_idx, source: layer.source.detached() };
            desk.document.edit("Own hair mesh", edit, Merge::New);
        }
        Command::AddFlyAways | Command::AddFrizz => {
            let sort = if command == Command::AddFrizz { Companion::Frizz } else { Companion::FlyAways };
            let added = sort.beside(layer);
            let label = format!("Add {}", added.name.to_lowercase());
            let edit = Edit::AddLayer { layer_idx: layer_idx + 1, layer: Box::new(added) };
            desk.document.edit(&label, edit, Merge::New);
            desk.selection = Selection::Layer(layer_idx + 1);
        }
        Command::RemoveLayer => {
            let label = format!("Remove {}", layer.name);
            desk.document.edit(&label, Edit::RemoveLayer { layer_idx }, Merge::New);
        }
        other => log::error!("{other:?} is no layer command"),
    }
}
