//! Movement: what happens and when, the air, and every number of the solver. The transport is the strip below
//! the viewport ([`crate::window::timeline`]).

use egui::{RichText, Ui};
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;
use lorelei_core::motion::{AtEnd, HeadPose, Motion, Movement};
use lorelei_core::simulation::{HairKind, Quality, SimulationSettings};

use super::widgets::{self, form_row, mebibytes};
use crate::window::commands::Command;
use crate::window::desk::{Desk, merge_of};
use crate::window::state_report::mark;
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "What happens");
    ui.horizontal_wrapped(|ui| {
        for motion in Motion::ALL {
            let info = motion.info();
            let is_chosen = desk.document.groom.movement.motion == *motion;
            let response = ui.selectable_label(is_chosen, info.label).on_hover_text(info.help);
            mark(ui.ctx(), || format!("motion {}", info.name), response.rect);
            if response.clicked() {
                desk.set_motion(*motion);
            }
        }
    });
    let is_moved = desk.playback.head_pose != HeadPose::default();
    ui.add_enabled_ui(is_moved, |ui| {
        if ui.button("Put the head back").on_hover_text("Where it was before it was dragged").clicked() {
            desk.playback.head_pose = HeadPose::default();
        }
    });
    range(ui, desk);
    animation(ui, desk);
    widgets::section(ui, "Hair and air");
    let mut settings = desk.document.groom.simulation.clone();
    let mut default = SimulationSettings::default();
    let mut change = None;
    let help = "Starting points: how stiff, heavy and held hair is. What is chosen is what its numbers are of";
    if let Some(kind) = one_of(ui, ("Kind of hair", "kind"), help, HairKind::of(&settings)) {
        settings.take(kind);
        change = Some(widgets::Change::once(format!("{} hair moves", kind.info().label)));
    }
    let help = "Steps, iterations and the cells of the wind's grid in one";
    if let Some(quality) = one_of(ui, ("Quality", "quality"), help, Quality::of(&settings)) {
        quality.put(&mut settings);
        change = Some(widgets::Change::once(format!("Quality: {}", quality.info().label.to_lowercase())));
    }
    for (mut slot, mut default) in settings.slots().into_iter().zip(default.slots()) {
        change = change.or(widgets::slot(ui, &mut slot, &mut default, &widgets::Notes::default()));
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetSimulation(Box::new(settings)), merge_of(change.drag));
    }
    super::wind::section(ui, desk);
    super::colliders::section(ui, desk);
    super::pins::section(ui, desk);
}

/// Sets of numbers, each a button below the row's name, with the one that is `chosen` now; returns another that was
/// pressed. `mark` names the buttons to tests.
fn one_of<T: Choice + Copy + PartialEq>(
    ui: &mut Ui,
    (name, mark_name): (&str, &str),
    help: &str,
    chosen: Option<T>,
) -> Option<T> {
    form_row(ui, name, help, false, |ui| {
        let shown = chosen.map_or("Numbers of its own", |chosen| chosen.info().label);
        ui.label(RichText::new(shown).color(theme::TEXT_WEAK));
    });
    let mut pressed = None;
    ui.indent(name, |ui| {
        ui.horizontal_wrapped(|ui| {
            for &one in T::ALL {
                let info = one.info();
                let is_chosen = chosen == Some(one);
                let button = ui.selectable_label(is_chosen, info.label).on_hover_text(info.help);
                mark(ui.ctx(), || format!("{mark_name} {}", info.name), button.rect);
                if button.clicked() && !is_chosen {
                    pressed = Some(one);
                }
            }
        });
    });
    pressed
}

/// Keyed poses that came from a file, and which of its nodes moves the head.
fn animation(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "Animation of a file");
    ui.horizontal_wrapped(|ui| {
        let load =
            ui.button("Load\u{2026}").on_hover_text("A node's movement from a .glb or .gltf moves head and body");
        mark(ui.ctx(), || "load animation".to_owned(), load.rect);
        if load.clicked() {
            desk.asked.push(Command::LoadAnimation);
        }
        let Some(track) = desk.document.groom.movement.track.clone() else { return };
        let remove = ui.button("Remove").on_hover_text("The head stays where the preset movement has it");
        mark(ui.ctx(), || "remove animation".to_owned(), remove.rect);
        if remove.clicked() {
            let movement = Movement { track: None, ..desk.document.groom.movement.clone() };
            desk.set_movement("Remove the animation", movement, Merge::New);
        }
        ui.label(format!("{}: {} keys, {:.2} s", track.name, track.keys.len(), track.secs()));
    });
    let mut chosen = None;
    if desk.takes.tracks.len() > 1 {
        let now = desk.document.groom.movement.track.as_ref().map_or("", |track| track.name.as_str());
        let shown = if now.is_empty() { "Choose a node" } else { now };
        let combo = egui::ComboBox::from_id_salt("node").selected_text(shown).show_ui(ui, |ui| {
            for track in &desk.takes.tracks {
                let row = ui.selectable_label(track.name == now, &track.name);
                mark(ui.ctx(), || format!("choice node={}", track.name), row.rect);
                if row.clicked() {
                    chosen = Some(track.clone());
                }
            }
        });
        mark(ui.ctx(), || "slot node".to_owned(), combo.response.rect);
        combo.response.on_hover_text("The node of the file whose movement it is");
    }
    if let Some(track) = chosen {
        desk.set_track(track);
    }
}

/// Range, frames a second, what happens at the end, and what kept frames may take.
fn range(ui: &mut Ui, desk: &mut Desk) {
    widgets::section(ui, "Timeline");
    let mut movement = desk.document.groom.movement.bounded();
    let default = Movement::default();
    let mut change = None;
    let mut row =
        |ui: &mut Ui, name: &str, help: &str, is_changed, control: &mut dyn FnMut(&mut Ui) -> egui::Response| {
            let (_, response) = form_row(ui, name, help, is_changed, control);
            let response = widgets::explained(response, help, "Drag, with Shift slowly, or click and type");
            mark(ui.ctx(), || format!("timeline {}", name.to_lowercase()), response.rect);
            if let Some(one) = widgets::Change::from_response(&format!("Timeline: {}", name.to_lowercase()), &response)
            {
                change = Some(one);
            }
        };
    let Movement { fps, start, end, warm_up_secs, .. } = &mut movement;
    let is_other = (*fps != default.fps, *start != default.start, *end != default.end, *warm_up_secs != 0.0);
    row(ui, "First frame", "Hair is at rest here, after the warm-up", is_other.1, &mut |ui| {
        widgets::integer(ui, start, (0, 100_000), "")
    });
    row(ui, "Last frame", "Of the range that plays", is_other.2, &mut |ui| widgets::integer(ui, end, (1, 100_000), ""));
    row(ui, "Frames a second", "Other frames are simulated for another rate", is_other.0, &mut |ui| {
        widgets::number(ui, fps, (1.0, 240.0), "1/s")
    });
    row(ui, "Warm-up", "Time that the hair settles before the first frame", is_other.3, &mut |ui| {
        widgets::number(ui, warm_up_secs, (0.0, 60.0), "s")
    });
    ui.horizontal_wrapped(|ui| {
        for fps in [24.0, 25.0, 30.0, 60.0] {
            let response = ui.selectable_label(movement.fps == fps, format!("{fps} fps"));
            if response.on_hover_text("Frames a second").clicked() && movement.fps != fps {
                // The same time on another ruler.
                let scale = |frame_idx: u32| (f64::from(frame_idx) * f64::from(fps / movement.fps)).round() as u32;
                (movement.start, movement.end) = (scale(movement.start), scale(movement.end));
                movement.fps = fps;
                change = Some(widgets::Change::once(format!("Timeline: {fps} frames a second")));
            }
        }
    });
    ui.horizontal_wrapped(|ui| {
        for at_end in AtEnd::ALL {
            let info = at_end.info();
            let response = ui.selectable_label(movement.at_end == *at_end, info.label).on_hover_text(info.help);
            mark(ui.ctx(), || format!("at end {}", info.name), response.rect);
            if response.clicked() && movement.at_end != *at_end {
                movement.at_end = *at_end;
                change = Some(widgets::Change::once(format!("Timeline: {}", info.label.to_lowercase())));
            }
        }
    });
    if let Some(change) = change {
        desk.set_movement(&change.label, movement.bounded(), merge_of(change.drag));
    }
    let help = "Memory that kept frames may take: what is behind is simulated again each time";
    let (_, response) = form_row(ui, "Keep frames", help, desk.settings.frames_mib != 1024, |ui| {
        widgets::integer(ui, &mut desk.settings.frames_mib, (0, 65_536), "MiB")
    });
    widgets::explained(response, help, "Drag, with Shift slowly, or click and type");
    let timeline = &desk.report.timeline;
    let n_kept: u32 = timeline.kept.iter().map(|[first, last]| last - first + 1).sum();
    let words = format!("Frames kept: {n_kept}, {}", mebibytes(timeline.n_kept_bytes as u64));
    ui.label(RichText::new(words).small().color(theme::TEXT_WEAK));
}
