//! Wind: what of it is drawn in the viewport, and the sources that blow, in a list.

use egui::{RichText, Ui, vec2};
use glam::Vec3;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;
use lorelei_core::simulation::{SimulationSettings, Wind};
use lorelei_core::wind::{Eddies, MAX_RADIUS, MAX_SOURCES, MAX_SPEED, SourceKind, WindSource};

use super::widgets::{self, Change, form_row};
use crate::window::desk::{Desk, Selection, merge_of};
use crate::window::state_report::mark;
use crate::window::theme;

const STILL_AIR: &str = "The air is still: no source blows. Choose `Steady wind` or `Grid` above";
const ON_HELP: &str = "Whether it blows";

/// The section of the movement panel.
pub fn section(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "Wind in the viewport");
    overlays(ui, desk);
    widgets::section(ui, "Wind sources");
    ui.horizontal(|ui| {
        for (name, kind) in [("+ Fan", SourceKind::Fan), ("+ Vortex", SourceKind::Vortex)] {
            let button = ui.button(name).on_hover_text(kind.info().help);
            mark(ui.ctx(), || format!("add {}", kind.info().name), button.rect);
            if button.clicked() {
                add(desk, kind);
            }
        }
    });
    if desk.has_idle_sources() {
        let words = ui.label(RichText::new(STILL_AIR).small().color(theme::TEXT_WEAK));
        mark(ui.ctx(), || "sources are idle".to_owned(), words.rect);
    }
    for source_idx in 0..desk.document.groom.simulation.sources.len() {
        ui.push_id(("source", source_idx), |ui| row(ui, desk, source_idx));
    }
    if let Selection::Wind(source_idx) = desk.selection {
        one(ui, desk, source_idx);
    }
}

fn overlays(ui: &mut Ui, desk: &mut Desk) {
    let view = &mut desk.wind_view;
    for (name, help, is_on) in [
        ("Arrows", "Where the air goes; the longer an arrow, the faster", &mut view.arrows),
        ("Slice", "A plane through the air, coloured by speed", &mut view.slice),
        ("Tracers", "Smoke that the air carries along while time passes", &mut view.tracers),
    ] {
        let (_, response) = form_row(ui, name, help, false, |ui| widgets::switch(ui, is_on));
        mark(ui.ctx(), || format!("wind {}", name.to_lowercase()), response.rect);
        response.on_hover_text(help);
    }
    if view.slice {
        let help = "Which way the slice lies across";
        form_row(ui, "Across", help, false, |ui| {
            ui.horizontal(|ui| {
                for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
                    ui.selectable_value(&mut view.axis, axis, name).on_hover_text(help);
                }
            });
        });
        let help = "Where the slice is in the box of air";
        let (_, response) =
            form_row(ui, "At", help, false, |ui| widgets::number(ui, &mut view.at, (0.0, 1.0), "of the box"));
        response.on_hover_text(help);
    }
}

fn row(ui: &mut Ui, desk: &mut Desk, source_idx: usize) {
    let mut settings = desk.document.groom.simulation.clone();
    let name = settings.sources[source_idx].name.clone();
    let mut change = None;
    ui.horizontal(|ui| {
        if widgets::switch(ui, &mut settings.sources[source_idx].on).on_hover_text(ON_HELP).changed() {
            change = Some(format!("Switch {name}"));
        }
        let is_selected = desk.selection == Selection::Wind(source_idx);
        let label = ui.selectable_label(is_selected, &name);
        if label.on_hover_text("Click to select it: its handles are in the viewport").clicked() {
            desk.selection = if is_selected { Selection::Head } else { Selection::Wind(source_idx) };
        }
        let side = egui::Layout::right_to_left(egui::Align::Center);
        ui.with_layout(side, |ui| {
            if ui.add(egui::Button::new("\u{d7}").min_size(vec2(20.0, 18.0))).on_hover_text("Remove it").clicked() {
                change = Some(format!("Remove {name}"));
                settings.sources.remove(source_idx);
            }
        });
    });
    if let Some(label) = change {
        desk.document.edit(&label, Edit::SetSimulation(Box::new(settings)), Merge::New);
        desk.clamp_selection();
    }
}

/// A new one at the model's left, which blows at the middle; the wind becomes a grid, where a source does most.
fn add(desk: &mut Desk, kind: SourceKind) {
    let mut settings = desk.document.groom.simulation.clone();
    if settings.sources.len() >= MAX_SOURCES {
        desk.notices.error("No more sources", format!("{MAX_SOURCES} blow at a time"));
        return;
    }
    let label = kind.info().label;
    let n_same = settings.sources.iter().filter(|source| source.name.starts_with(label)).count();
    let name = format!("{label} {}", n_same + 1);
    let half = 0.5 * (desk.bounds.1 - desk.bounds.0);
    let source = match kind {
        SourceKind::Fan => WindSource::aimed_at(desk.centre(), half.length() + 2.0, &name),
        SourceKind::Vortex => WindSource {
            name: name.clone(),
            kind,
            place: desk.centre() + Vec3::new(half.x + 8.0, 0.0, 0.0),
            direction: Vec3::Y,
            radius: 10.0,
            speed: 300.0,
            eddies: Eddies::default(),
            ..WindSource::default()
        },
    };
    settings.sources.push(source);
    settings.wind = Wind::Grid;
    let source_idx = settings.sources.len() - 1;
    desk.document.edit(&format!("Add {name}"), Edit::SetSimulation(Box::new(settings)), Merge::New);
    desk.selection = Selection::Wind(source_idx);
}

/// Every number of one source.
pub fn one(ui: &mut Ui, desk: &mut Desk, source_idx: usize) {
    let mut settings: SimulationSettings = desk.document.groom.simulation.clone();
    let Some(source) = settings.sources.get_mut(source_idx) else { return };
    if let Some(change) = form(ui, source) {
        desk.document.edit(&change.label, Edit::SetSimulation(Box::new(settings)), merge_of(change.drag));
    }
}

fn form(ui: &mut Ui, source: &mut WindSource) -> Option<Change> {
    let mut change = None;
    let mut row = |ui: &mut Ui, name: &str, help: &str, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
        let (_, response) = form_row(ui, name, help, false, control);
        let label = format!("Wind {}", name.to_lowercase());
        if let Some(one) = Change::from_response(&label, &response.on_hover_text(help)) {
            change = Some(one);
        }
    };
    row(ui, "Name", "Click and type", &mut |ui| {
        ui.add(egui::TextEdit::singleline(&mut source.name).desired_width(f32::INFINITY))
    });
    row(ui, "On", ON_HELP, &mut |ui| widgets::switch(ui, &mut source.on));
    let kind = source.kind;
    row(ui, "Kind", "What it does with the air", &mut |ui| {
        let list = egui::ComboBox::from_id_salt("kind").width(ui.available_width());
        let shown = list.selected_text(kind.info().label).show_ui(ui, |ui| {
            for choice in SourceKind::ALL {
                ui.selectable_value(&mut source.kind, *choice, choice.info().label).on_hover_text(choice.info().help);
            }
        });
        let mut response = shown.response;
        if source.kind != kind {
            response.mark_changed();
        }
        response
    });
    let mut number = |ui: &mut Ui, name: &str, help: &str, value: &mut f32, range: (f32, f32), unit: &str| {
        row(ui, name, help, &mut |ui| widgets::number(ui, value, range, unit));
    };
    number(ui, "Speed", "In the core: 300 a fan, 900 a hair dryer", &mut source.speed, (0.0, MAX_SPEED), "cm/s");
    number(ui, "Radius", "Of the disc or the ball", &mut source.radius, (0.5, MAX_RADIUS), "cm");
    number(
        ui,
        "Falloff",
        "How quickly a fan's stream widens and slows: 1 as a jet in still air, 0 not at all",
        &mut source.falloff,
        (0.0, 5.0),
        "",
    );
    let gusts = &mut source.gusts;
    number(ui, "Gusts", "Share of the speed by which it swells and falls", &mut gusts.strength, (0.0, 2.0), "");
    number(ui, "Between gusts", "From one gust to about the next", &mut gusts.period_secs, (0.1, 60.0), "s");
    let eddies = &mut source.eddies;
    number(ui, "Eddies", "Their speed as a share of its own", &mut eddies.amount, (0.0, 2.0), "");
    number(ui, "Eddy size", "Size of the largest eddies", &mut eddies.size_cm, (0.5, 200.0), "cm");
    let mut seed = source.eddies.seed as f32;
    number(ui, "Seed", "Other gusts and eddies of the same kind", &mut seed, (0.0, 9999.0), "");
    source.eddies.seed = seed.round() as u32;
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        number(ui, name, "Its middle, in the world", &mut source.place[axis], (-500.0, 500.0), "cm");
    }
    let (mut azimuth_deg, mut elevation_deg) = super::lights::angles_of(source.direction.normalize_or(Vec3::NEG_Z));
    let before = (azimuth_deg, elevation_deg);
    number(
        ui,
        "Azimuth",
        "Where it blows to: 0 to the front, 90 to the model's left",
        &mut azimuth_deg,
        (-180.0, 180.0),
        "\u{b0}",
    );
    number(ui, "Elevation", "Above the horizon", &mut elevation_deg, (-90.0, 90.0), "\u{b0}");
    if before != (azimuth_deg, elevation_deg) {
        source.direction = lorelei_core::camera::direction_from_deg(azimuth_deg, elevation_deg);
    }
    change
}
