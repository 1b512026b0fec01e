//! Movement: the transport, the head's preset movements, wind, and every number of the solver.

use egui::{RichText, Ui, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::look::Choice;
use lorelei_core::motion::{HeadPose, Motion};
use lorelei_core::simulation::SimulationSettings;

use super::widgets;
use crate::window::commands::Command;
use crate::window::desk::{Desk, merge_of};
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    transport(ui, desk);
    widgets::section(ui, "Head");
    ui.horizontal_wrapped(|ui| {
        for motion in Motion::ALL {
            let info = motion.info();
            let is_chosen = desk.playback.motion == *motion;
            if ui.selectable_label(is_chosen, info.label).on_hover_text(info.help).clicked() {
                desk.playback.motion = *motion;
                desk.playback.is_playing |= *motion != Motion::None;
            }
        }
    });
    let is_moved = desk.playback.head_pose != HeadPose::default();
    ui.add_enabled_ui(is_moved, |ui| {
        if ui.button("Put the head back").on_hover_text("Where it was before it was dragged").clicked() {
            desk.playback.head_pose = HeadPose::default();
        }
    });
    widgets::section(ui, "Hair and air");
    let mut settings = desk.document.groom.simulation.clone();
    let mut default = SimulationSettings::default();
    let mut change = None;
    for (mut slot, mut default) in settings.slots().into_iter().zip(default.slots()) {
        change = change.or(widgets::slot(ui, &mut slot, &mut default, &widgets::Notes::default()));
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetSimulation(Box::new(settings)), merge_of(change.drag));
    }
    super::colliders::section(ui, desk);
}

fn transport(ui: &mut Ui, desk: &mut Desk) {
    ui.horizontal(|ui| {
        let size = vec2(64.0, 28.0);
        let is_playing = desk.playback.is_playing;
        let (text, fill) = if is_playing { ("Pause", theme::ACCENT_DIM) } else { ("Play", theme::CONTROL) };
        let play = egui::Button::new(RichText::new(text).color(theme::TEXT_STRONG)).fill(fill).min_size(size);
        for (button, command) in [
            (play, Command::Play),
            (egui::Button::new("Step").min_size(size), Command::Step),
            (egui::Button::new("Reset").min_size(size), Command::Reset),
        ] {
            let shortcut = command.row().shortcuts.first().map(|s| ui.ctx().format_shortcut(s)).unwrap_or_default();
            if ui.add(button).on_hover_text(format!("{} ({shortcut})", command.row().help)).clicked() {
                desk.asked.push(command);
            }
        }
        ui.label(RichText::new(format!("{:.2} s", desk.report.sim_secs)).color(theme::TEXT_WEAK));
    });
}
