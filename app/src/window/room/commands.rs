//! What keys, menus and buttons do in look development.

use std::path::Path;

use egui::Key;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::FalseColour;
use lorelei_core::look::presets::{LookFileError, LookPreset};

use super::Beside;
use crate::window::commands::{Command, Row, ctrl, key, shift};
use crate::window::desk::Desk;
use crate::window::notices::Severity;

/// A command of look development.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RoomCommand {
    StoreOther,
    SwapOther,
    TakeOther,
    Wipe,
    Difference,
    EndSolo,
    Inspect,
    FinalPicture,
    ContactSheet,
    Turntable,
    LoadLook,
    LoadEnvironment,
    SaveLook,
}

const fn row(
    command: RoomCommand,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [egui::KeyboardShortcut],
) -> Row {
    Row { command: Command::Room(command), group: "Look", label, help, shortcuts, tool: None }
}

/// In the order of the shortcut sheet.
#[rustfmt::skip]
pub const ROOM_COMMANDS: &[Row] = &[
    row(RoomCommand::StoreOther, "Store the look as B", "A copy beside the document, to compare with", &[shift(Key::B)]),
    row(RoomCommand::Wipe, "Wipe between A and B", "The document's look left of a line, look B right of it; again: the document's alone", &[key(Key::B)]),
    row(RoomCommand::Difference, "Difference of A and B", "How far the two pictures are apart; again: the document's alone", &[ctrl(Key::B)]),
    row(RoomCommand::SwapOther, "Swap looks A and B", "B becomes the document's look and what that was becomes B", &[]),
    row(RoomCommand::TakeOther, "Take look B", "B becomes the document's look; B stays", &[]),
    row(RoomCommand::EndSolo, "All of the light", "No term and no lamp is alone any more", &[]),
    row(RoomCommand::Inspect, "Inspect pixels", "What the light under the pointer is made of, or not", &[key(Key::I)]),
    row(RoomCommand::FinalPicture, "Final picture", "Light instead of false colours", &[]),
    row(RoomCommand::ContactSheet, "Contact sheet\u{2026}", "Every choice of the slot of the look that was used last, in one labelled picture", &[]),
    row(RoomCommand::Turntable, "Turntable\u{2026}", "Pictures from all around, as files beside each other", &[]),
    row(RoomCommand::LoadEnvironment, "Load environment\u{2026}", "Light from all around from a .hdr or .exr picture; dropping one on the window does it too", &[]),
    row(RoomCommand::LoadLook, "Load look\u{2026}", "A look from a file, as one step", &[]),
    row(RoomCommand::SaveLook, "Save look\u{2026}", "The look alone, without lights and material", &[]),
];

pub fn is_enabled(desk: &Desk, command: RoomCommand) -> bool {
    match command {
        RoomCommand::StoreOther | RoomCommand::Inspect => true,
        RoomCommand::SwapOther | RoomCommand::TakeOther | RoomCommand::Wipe | RoomCommand::Difference => {
            desk.room.other.is_some()
        }
        RoomCommand::EndSolo => desk.room.solo.is_some(),
        RoomCommand::FinalPicture => !desk.document.groom.look.view.is_light(),
        RoomCommand::ContactSheet
        | RoomCommand::Turntable
        | RoomCommand::LoadEnvironment
        | RoomCommand::LoadLook
        | RoomCommand::SaveLook => !desk.document.is_none(),
    }
}

/// Do what a command says; those on files are the window's own.
pub fn run(desk: &mut Desk, command: RoomCommand) {
    let toggled = |beside: Beside, wanted: Beside| if beside == wanted { Beside::Nothing } else { wanted };
    match command {
        RoomCommand::StoreOther => {
            desk.room.other = Some(desk.document.groom.look.clone());
            desk.notices.push(Severity::Info, "Look B", "The look as it is now is B. B wipes between the two.");
        }
        RoomCommand::SwapOther => {
            let before = desk.document.groom.look.clone();
            if let Some(other) = desk.room.other.replace(before) {
                set_look(desk, "Swap looks", other);
            }
        }
        RoomCommand::TakeOther => {
            if let Some(other) = desk.room.other.clone() {
                set_look(desk, "Take look B", other);
            }
        }
        RoomCommand::Wipe => desk.room.beside = toggled(desk.room.beside, Beside::Wipe),
        RoomCommand::Difference => desk.room.beside = toggled(desk.room.beside, Beside::Difference),
        RoomCommand::EndSolo => desk.room.solo = None,
        RoomCommand::Inspect => desk.room.inspects ^= true,
        RoomCommand::FinalPicture => {
            let mut look = desk.document.groom.look.clone();
            look.view = FalseColour::Final;
            set_look(desk, "View: Final picture", look);
        }
        RoomCommand::ContactSheet
        | RoomCommand::Turntable
        | RoomCommand::LoadEnvironment
        | RoomCommand::LoadLook
        | RoomCommand::SaveLook => {}
    }
}

/// Replace the document's look, as one step.
pub fn set_look(desk: &mut Desk, label: &str, look: lorelei_core::look::Look) {
    if look != desk.document.groom.look {
        desk.document.edit(label, Edit::SetLook(Box::new(look)), Merge::New);
    }
}

/// Write the document's look to a file, or put a file's in its place.
pub fn file(desk: &mut Desk, is_save: bool, path: &Path) -> Result<(), LookFileError> {
    if is_save {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        LookPreset { name, help: String::new(), look: desk.document.groom.look.clone() }.save(path)?;
        desk.notices.push(Severity::Info, "Look saved", path.display().to_string());
        return Ok(());
    }
    let preset = LookPreset::open(path)?;
    set_look(desk, &format!("Look: {}", preset.name), preset.look);
    Ok(())
}
