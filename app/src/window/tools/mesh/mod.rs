//! Modelling the hair mesh: what is selected of it, what the pointer does, and the tool's settings.

pub mod commands;

use egui::Ui;

use super::View;
use super::surface::HeadSurface;
use crate::window::desk::Desk;
use commands::MeshCommand;

/// The tool's state.
#[derive(Default)]
pub struct MeshTool {
    is_all_selected: bool,
}

impl MeshTool {
    /// True while something is dragged.
    pub fn viewport(&mut self, ui: &mut Ui, _desk: &mut Desk, view: &View<'_>, _surface: &mut HeadSurface) -> bool {
        if view.response.clicked() && view.pointer(ui).is_some() {
            self.is_all_selected = false;
        }
        false
    }

    pub fn panel(&mut self, ui: &mut Ui, _desk: &mut Desk) {
        ui.label(if self.is_all_selected { "All selected" } else { "Nothing selected" });
    }

    pub fn is_enabled(&self, desk: &Desk, command: MeshCommand) -> bool {
        match command {
            MeshCommand::SelectAll => self.is_all_selected || !desk.document.is_none(),
        }
    }
}

/// Do what a command says.
pub fn run(desk: &mut Desk, command: MeshCommand) {
    match command {
        MeshCommand::SelectAll => desk.tools.mesh.is_all_selected ^= true,
    }
}
