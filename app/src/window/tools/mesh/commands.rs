//! What keys and menus do to the hair mesh while it is modelled.

use egui::Key;

use crate::window::commands::{Command, Row, key};
use crate::window::tools::Tool;

/// A command of the modelling tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeshCommand {
    SelectAll,
}

const fn row(
    command: MeshCommand,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [egui::KeyboardShortcut],
) -> Row {
    Row { command: Command::Mesh(command), group: "Mesh", label, help, shortcuts, tool: Some(Tool::Mesh) }
}

/// In the order of the menu.
pub const MESH_COMMANDS: &[Row] =
    &[row(MeshCommand::SelectAll, "Select all or none", "All that is shown; again: nothing", &[key(Key::A)])];
