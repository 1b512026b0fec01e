//! Lights: presets of whole rigs, and every number of the light that is selected.

use egui::{RichText, Ui};
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::light::{Light, LightKind, three_point_rig};

use super::widgets::{self, Change, form_row, section};
use crate::stage::shown::Solo;
use crate::window::desk::{Desk, Selection, merge_of};
use crate::window::room;
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    ui.label(RichText::new("Rigs").small().color(theme::TEXT_WEAK));
    ui.horizontal_wrapped(|ui| {
        for (name, help, rig) in rigs() {
            if ui.button(name).on_hover_text(help).clicked() {
                desk.document.edit(&format!("{name} lights"), Edit::SetLights(rig), Merge::New);
            }
        }
    });
    ui.add_space(4.0);
    for light_idx in 0..desk.document.groom.lights.len() {
        let light = &desk.document.groom.lights[light_idx];
        let is_selected = desk.selection == Selection::Light(light_idx);
        let name = light.name.clone();
        ui.push_id(light_idx, |ui| {
            section(ui, &name);
            room::solo_button(ui, desk, Solo::Light(light_idx));
            if is_selected {
                one(ui, desk, light_idx);
            } else {
                short(ui, desk, light_idx);
            }
        });
    }
}

/// Switch and brightness only, for lights that are not selected.
fn short(ui: &mut Ui, desk: &mut Desk, light_idx: usize) {
    let mut lights = desk.document.groom.lights.clone();
    let light = &mut lights[light_idx];
    let mut change = None;
    let (_, response) = form_row(ui, "On", ON_HELP, false, |ui| widgets::switch(ui, &mut light.on));
    let response = response.on_hover_text(ON_HELP);
    change = Change::from_response("Switch light", &response).or(change);
    let (_, response) = form_row(ui, "Intensity", INTENSITY_HELP, false, |ui| {
        widgets::number(ui, &mut light.intensity, (0.0, 20.0), "")
    });
    let response = widgets::explained(response, INTENSITY_HELP, NUMBER);
    change = Change::from_response("Light intensity", &response).or(change);
    if ui.small_button("More\u{2026}").on_hover_text("Colour, kind, place and size of this light").clicked() {
        desk.selection = Selection::Light(light_idx);
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetLights(lights), merge_of(change.drag));
    }
}

const ON_HELP: &str = "Whether it lights anything";
const INTENSITY_HELP: &str = "1 makes a white card that faces the light white";
/// How a number is changed.
const NUMBER: &str = "Drag, with Shift slowly, or click and type";

/// Every number of one light.
pub fn one(ui: &mut Ui, desk: &mut Desk, light_idx: usize) {
    let centre = desk.centre();
    let mut lights = desk.document.groom.lights.clone();
    let Some(light) = lights.get_mut(light_idx) else { return };
    let mut change: Option<Change> = None;
    let mut row = |ui: &mut Ui, name: &str, help: &str, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
        let (_, response) = form_row(ui, name, help, false, control);
        let response = response.on_hover_text(if help.is_empty() { name } else { help });
        if let Some(one) = Change::from_response(&format!("Light {}", name.to_lowercase()), &response) {
            change = Some(one);
        }
    };
    row(ui, "On", ON_HELP, &mut |ui| widgets::switch(ui, &mut light.on));
    row(ui, "Colour", "Linear RGB", &mut |ui| widgets::colour(ui, &mut light.colour));
    row(ui, "Intensity", INTENSITY_HELP, &mut |ui| widgets::number(ui, &mut light.intensity, (0.0, 20.0), ""));
    if let Some(kind) = kind_combo(ui, light, centre) {
        light.kind = kind;
        change = Some(Change::once(format!("{}: {}", light.name, kind_name(kind))));
    }
    let mut row = |ui: &mut Ui, name: &str, help: &str, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
        let (_, response) = form_row(ui, name, help, false, control);
        let response = response.on_hover_text(if help.is_empty() { name } else { help });
        if let Some(one) = Change::from_response(&format!("Light {}", name.to_lowercase()), &response) {
            change = Some(one);
        }
    };
    row(ui, "Casts shadows", "Off: a light without shadows costs less", &mut |ui| {
        widgets::switch(ui, &mut light.casts_shadow)
    });
    let (mut azimuth_deg, mut elevation_deg) = angles_of(light.direction_to(centre));
    row(ui, "Azimuth", "0 from the front, 90 from the model's left", &mut |ui| {
        widgets::number(ui, &mut azimuth_deg, (-180.0, 180.0), "\u{b0}")
    });
    row(ui, "Elevation", "Above the horizon", &mut |ui| {
        widgets::number(ui, &mut elevation_deg, (-89.0, 89.0), "\u{b0}")
    });
    match &mut light.kind {
        LightKind::Directional { .. } => {}
        LightKind::Point { position } => place(ui, position, centre, &mut row),
        LightKind::Rect { position, size, .. } => {
            place(ui, position, centre, &mut row);
            row(ui, "Size", "Side of the square", &mut |ui| widgets::number(ui, size, (1.0, 300.0), "cm"));
        }
    }
    let direction = lorelei_core::camera::direction_from_deg(azimuth_deg, elevation_deg);
    if direction.distance(light.direction_to(centre)) > 1e-4 {
        light.aim_from(centre, direction);
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetLights(lights), merge_of(change.drag));
    }
}

type Row<'a> = dyn FnMut(&mut Ui, &str, &str, &mut dyn FnMut(&mut Ui) -> egui::Response) + 'a;

fn place(ui: &mut Ui, position: &mut glam::Vec3, centre: glam::Vec3, row: &mut Row<'_>) {
    let mut distance = position.distance(centre);
    row(ui, "Distance", "From the middle of head and hair; the light gets weaker with its square", &mut |ui| {
        widgets::number(ui, &mut distance, (1.0, 1000.0), "cm")
    });
    *position = centre + distance * (*position - centre).normalize_or(glam::Vec3::Y);
}

const KIND_HELP: &str = "Parallel as the sun, from a point, or from a square";

fn kind_name(kind: LightKind) -> &'static str {
    match kind {
        LightKind::Directional { .. } => "Parallel",
        LightKind::Point { .. } => "Point",
        LightKind::Rect { .. } => "Square",
    }
}

/// The light as another kind, from the same side; `None` where nothing was chosen.
fn kind_combo(ui: &mut Ui, light: &Light, centre: glam::Vec3) -> Option<LightKind> {
    let direction = light.direction_to(centre);
    let position = match light.kind {
        LightKind::Point { position } | LightKind::Rect { position, .. } => position,
        LightKind::Directional { .. } => centre + lorelei_core::light::INTENSITY_DISTANCE * direction,
    };
    let (azimuth_deg, elevation_deg) = angles_of(direction);
    let kinds = [
        LightKind::Directional { azimuth_deg, elevation_deg },
        LightKind::Point { position },
        LightKind::Rect { position, target: centre, size: 30.0 },
    ];
    let mut chosen = None;
    form_row(ui, "Kind", KIND_HELP, false, |ui| {
        let width = ui.available_width();
        let name = kind_name(light.kind);
        let combo = egui::ComboBox::from_id_salt("kind").width(width).selected_text(name).show_ui(ui, |ui| {
            for kind in kinds {
                let is_chosen = kind_name(kind) == name;
                if ui.selectable_label(is_chosen, kind_name(kind)).clicked() && !is_chosen {
                    chosen = Some(kind);
                }
            }
        });
        combo.response.on_hover_text(KIND_HELP);
    });
    chosen
}

/// Azimuth and elevation of a unit vector, degrees.
pub fn angles_of(direction: glam::Vec3) -> (f32, f32) {
    (direction.x.atan2(direction.z).to_degrees(), direction.y.clamp(-1.0, 1.0).asin().to_degrees())
}

fn rigs() -> [(&'static str, &'static str, Vec<Light>); 4] {
    [
        ("Three-point", "Key, fill and rim: a salon photograph", three_point_rig()),
        (
            "Rim",
            "Two lights from behind: what shines through the hair",
            vec![
                Light::directional("rim left", 150.0, 30.0, 3.0, [1.0, 0.97, 0.92]),
                Light::directional("rim right", -150.0, 30.0, 3.0, [0.92, 0.96, 1.0]),
                Light::directional("fill", 0.0, 15.0, 0.25, [1.0, 1.0, 1.0]),
            ],
        ),
        (
            "Outdoor",
            "A high warm sun and a weak blue sky from the other side",
            vec![
                Light::directional("sun", 30.0, 58.0, 3.6, [1.0, 0.93, 0.82]),
                Light::directional("sky", -140.0, 50.0, 0.5, [0.65, 0.8, 1.0]),
            ],
        ),
        (
            "Single",
            "One light from the front: what shadows do",
            vec![Light::directional("key", 30.0, 35.0, 3.0, [1.0; 3])],
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_are_inverses() {
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 40.0), (-135.0, -20.0)] {
            let (a, e) = angles_of(lorelei_core::camera::direction_from_deg(azimuth, elevation));
            assert!((a - azimuth).abs() < 1e-3 && (e - elevation).abs() < 1e-3);
        }
    }
}
