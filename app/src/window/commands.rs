//! Everything that a key, a menu or the palette can do: one table, which the shortcut sheet also prints.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::room::commands::{ROOM_COMMANDS, RoomCommand};
use super::tools::Tool;
use super::tools::mesh::commands::{MESH_COMMANDS, MeshCommand};
use super::tools::paint::commands::{PAINT_COMMANDS, PaintCommand};
use super::tools::sculpt::commands::{SCULPT_COMMANDS, SculptCommand};

/// What to do. Dispatched in one place, `Studio::run`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Command {
    New,
    Open,
    Save,
    SaveAs,
    ImportHair,
    ImportHead,
    ImportHairMesh,
    ExportHairMesh,
    FitHairMesh,
    Export,
    SavePicture,
    Quit,
    Undo,
    Redo,
    Frame,
    Front,
    Back,
    Left,
    Right,
    Top,
    ThreeQuarter,
    ToggleGizmos,
    ResetLayout,
    Fullscreen,
    Play,
    Step,
    StepBack,
    ToStart,
    ToEnd,
    Reset,
    MoveHead,
    TurnHead,
    SimulateRange,
    SimulateToFile,
    OpenFrames,
    LoadAnimation,
    SetRest,
    BakeGuides,
    MotionNone,
    MotionTurn,
    MotionNod,
    MotionShake,
    MotionWalk,
    MotionJump,
    MotionGust,
    ToggleShadows,
    ToggleLayer,
    DuplicateLayer,
    RemoveLayer,
    RecordMacro,
    PlayMacro,
    ClearHistory,
    AddFlyAways,
    AddFrizz,
    DetachLayer,
    LoadStyle,
    SaveStyle,
    DrawLevels,
    SolveLevel,
    Palette,
    Shortcuts,
    /// Take a tool; the one that is taken already is put down.
    Tool(Tool),
    Mesh(MeshCommand),
    Paint(PaintCommand),
    Sculpt(SculptCommand),
    Room(RoomCommand),
}

/// One row of the table.
pub struct Row {
    pub command: Command,
    pub group: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    /// The first is the one that menus show.
    pub shortcuts: &'static [KeyboardShortcut],
    /// Only while this tool is active, and then before all others; `None`: always.
    pub tool: Option<Tool>,
}

pub const fn key(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::NONE, key)
}
pub const fn ctrl(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND, key)
}
pub const fn ctrl_shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::COMMAND.plus(Modifiers::SHIFT), key)
}
pub const fn shift(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::SHIFT, key)
}

const fn row(
    command: Command,
    group: &'static str,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Row {
    Row { command, group, label, help, shortcuts, tool: None }
}

/// All commands, in the order of the shortcut sheet.
#[rustfmt::skip]
pub const COMMANDS: &[Row] = &[
    row(Command::New, "File", "New", "Start from the default groom", &[ctrl(Key::N)]),
    row(Command::Open, "File", "Open\u{2026}", "A groom, or a hair file of another program", &[ctrl(Key::O)]),
    row(Command::Save, "File", "Save", "Write the groom to its file", &[ctrl(Key::S)]),
    row(Command::SaveAs, "File", "Save as\u{2026}", "Write the groom to another file", &[ctrl_shift(Key::S)]),
    row(Command::ImportHair, "File", "Import hair\u{2026}", "Add a layer: .hair, .tfx, .data, .bin, .ply", &[ctrl(Key::I)]),
    row(Command::ImportHead, "File", "Import head\u{2026}", "Replace the head: .obj, .glb, .gltf, .ply", &[ctrl_shift(Key::I)]),
    row(Command::Export, "File", "Export strands\u{2026}", "For other programs: .hair, .tfx, .data, .usda", &[ctrl(Key::E)]),
    row(Command::ImportHairMesh, "File", "Import hair mesh\u{2026}", "Add a layer from polygons with layers, or from locks that stand on the scalp: .obj, .glb, .gltf", &[]),
    row(Command::ExportHairMesh, "File", "Export hair mesh\u{2026}", "The selected layer's hair mesh as polygons: .obj, .glb", &[]),
    row(Command::FitHairMesh, "Edit", "Hair mesh around the guides", "A new layer whose hair mesh is fitted around the selected layer's guides or strands", &[]),
    row(Command::SavePicture, "File", "Save picture\u{2026}", "The viewport as a PNG", &[key(Key::F12)]),
    row(Command::Quit, "File", "Quit", "Close the studio", &[ctrl(Key::Q)]),
    row(Command::Undo, "Edit", "Undo", "Take back the last change", &[ctrl(Key::Z)]),
    row(Command::Redo, "Edit", "Redo", "Do it again", &[ctrl_shift(Key::Z), ctrl(Key::Y)]),
    row(Command::ToggleLayer, "Edit", "Show or hide the layer", "The selected layer", &[key(Key::H)]),
    row(Command::DuplicateLayer, "Edit", "Duplicate the layer", "The selected layer", &[shift(Key::D)]),
    row(Command::AddFlyAways, "Edit", "Add fly-aways", "A layer of loose strands on the selected layer's own hair mesh or guides", &[]),
    row(Command::AddFrizz, "Edit", "Add frizz", "A layer of short crinkled hair on the selected layer's own hair mesh or guides", &[]),
    row(Command::DetachLayer, "Edit", "Give the layer its own hair mesh", "Edits of the hair mesh then count for this layer alone", &[]),
    row(Command::LoadStyle, "Edit", "Load style\u{2026}", "Put a style from a file on the selected layer", &[]),
    row(Command::SaveStyle, "Edit", "Save style\u{2026}", "Write the selected layer's style to a file", &[]),
    row(Command::RemoveLayer, "Edit", "Remove the layer", "The selected layer", &[key(Key::Delete)]),
    row(Command::RecordMacro, "Edit", "Record a macro, or stop", "Every change until it is pressed again becomes a list of edits in a file", &[]),
    row(Command::PlayMacro, "Edit", "Play a macro\u{2026}", "A list of edits from a file, undone as one step", &[]),
    row(Command::ClearHistory, "Edit", "Clear the history", "Forget every step; the groom stays as it is", &[]),
    row(Command::ToggleShadows, "Look", "Switch shadows", "Between off and the technique used last", &[shift(Key::L)]),
    row(Command::Frame, "View", "Frame all", "Head and hair fill the viewport", &[key(Key::F), key(Key::Home)]),
    row(Command::Front, "View", "Front", "From the nose's side", &[key(Key::Num1)]),
    row(Command::Back, "View", "Back", "From behind", &[ctrl(Key::Num1)]),
    row(Command::Right, "View", "Side, from +X", "The model's left side", &[key(Key::Num3)]),
    row(Command::Left, "View", "Side, from \u{2212}X", "The model's right side", &[ctrl(Key::Num3)]),
    row(Command::Top, "View", "Top", "From above", &[key(Key::Num7)]),
    row(Command::ThreeQuarter, "View", "Three-quarter", "35 degrees to the side", &[key(Key::Num5)]),
    row(Command::ToggleGizmos, "View", "Show or hide handles", "Of lights and head", &[key(Key::O)]),
    row(Command::Fullscreen, "View", "Full screen", "And back", &[key(Key::F11)]),
    row(Command::ResetLayout, "View", "Reset the layout", "All panels back where they were at first", &[]),
    row(Command::Play, "Movement", "Play or pause", "Let the hair move", &[key(Key::Space)]),
    row(Command::Step, "Movement", "One frame forward", "On the timeline", &[key(Key::ArrowRight)]),
    row(Command::StepBack, "Movement", "One frame back", "On the timeline", &[key(Key::ArrowLeft)]),
    row(Command::ToStart, "Movement", "First frame", "Of the timeline's range", &[ctrl(Key::ArrowLeft)]),
    row(Command::ToEnd, "Movement", "Last frame", "Of the timeline's range: what is not there yet is simulated", &[ctrl(Key::ArrowRight)]),
    row(Command::Reset, "Movement", "Reset", "Hair at rest, head where it was", &[shift(Key::Space)]),
    row(Command::MoveHead, "Movement", "Grab the head", "Follows the pointer; click keeps, Esc takes back", &[key(Key::G)]),
    row(Command::TurnHead, "Movement", "Turn the head", "Follows the pointer; click keeps, Esc takes back", &[key(Key::R)]),
    row(Command::SimulateRange, "Movement", "Simulate the range", "All frames in the background; then play and scrub cost nothing", &[ctrl(Key::R)]),
    row(Command::SimulateToFile, "Movement", "Simulate to a file\u{2026}", "All frames in the background; a file that was begun is gone on with", &[]),
    row(Command::OpenFrames, "Movement", "Open frames\u{2026}", "Frames that were simulated before, of this groom and this movement", &[]),
    row(Command::LoadAnimation, "Movement", "Load an animation\u{2026}", "A node's movement from a .glb or .gltf moves head and body", &[]),
    row(Command::SetRest, "Movement", "Set current as rest", "The hair as it is now is where it rests", &[]),
    row(Command::BakeGuides, "Movement", "Bake to guides", "The selected layer as it is now, as a layer of guides; of strands, where every strand moves", &[]),
    row(Command::MotionNone, "Movement", "Head still", "No preset movement", &[]),
    row(Command::MotionTurn, "Movement", "Head turns", "Looks over one shoulder, then the other", &[]),
    row(Command::MotionNod, "Movement", "Head nods", "Yes", &[]),
    row(Command::MotionShake, "Movement", "Head shakes", "No", &[]),
    row(Command::MotionWalk, "Movement", "Walk", "Nine steps on the spot", &[]),
    row(Command::MotionJump, "Movement", "Jump", "18 cm high", &[]),
    row(Command::MotionGust, "Movement", "Gusts of wind", "Two, from where the wind is set to blow", &[]),
    row(Command::Tool(Tool::Select), "Tools", "Select", "Lights, the head, layers", &[key(Key::Q)]),
    row(Command::Tool(Tool::Mesh), "Tools", "Model the hair mesh", "Its faces, edges and vertices; again: back to Select", &[key(Key::Tab)]),
    row(Command::Tool(Tool::Sculpt), "Tools", "Sculpt", "Comb, cut and shape with brushes", &[shift(Key::S)]),
    row(Command::Tool(Tool::Paint), "Tools", "Paint maps", "Density, length and more, over the scalp", &[shift(Key::P)]),
    row(Command::Tool(Tool::Pull), "Tools", "Pull hair", "Drag hair while it plays: it is held at the pointer until the button is released", &[shift(Key::G)]),
    row(Command::DrawLevels, "View", "Draw the levels of detail", "Side by side in the panel Levels, with strands and times", &[]),
    row(Command::SolveLevel, "Edit", "Level of detail for a time", "The level whose frame takes as long as the panel Levels says", &[]),
    row(Command::Palette, "Help", "Find a command\u{2026}", "Search everything the studio can do", &[key(Key::F3), ctrl(Key::P)]),
    row(Command::Shortcuts, "Help", "Shortcuts", "This sheet", &[key(Key::F1)]),
];

/// The rows of all tables: the studio's own and each tool's.
pub fn rows() -> impl Iterator<Item = &'static Row> {
    COMMANDS.iter().chain(ROOM_COMMANDS).chain(MESH_COMMANDS).chain(PAINT_COMMANDS).chain(SCULPT_COMMANDS)
}

/// What the pointer does in the viewport, for the shortcut sheet.
pub const POINTER: &[(&str, &str)] = &[
    ("Orbit", "Middle drag, or Alt + left drag"),
    ("Pan", "Shift + middle drag, or Alt + middle drag"),
    ("Zoom", "Wheel, Ctrl + middle drag, or Alt + right drag"),
    ("Aim a light", "Drag its disc"),
    ("Move the head", "Drag the handle at the neck; with Shift: turn it"),
    ("Pull hair", "With the tool Pull: drag it, while it plays"),
    ("Reset a value", "Double-click its name"),
    ("Type a value", "Click it; drag it to change it, with Shift slowly"),
];

impl Command {
    pub fn row(self) -> &'static Row {
        let found = rows().find(|row| row.command == self);
        found.expect("every command is in the table: tested")
    }
}

/// The command of the first key press that is a shortcut; that press is then used up. Where frames are slow, one
/// may hold several presses, even of one key: ask until there is none.
///
/// Shortcuts with more modifiers go first: Ctrl+Shift+Z is not Ctrl+Z. `is_typing`: only those with Ctrl or
/// a function key count, the rest belongs to the text. `tool`: the active one, whose keys go before all others.
pub fn pressed(ctx: &egui::Context, is_typing: bool, tool: Tool) -> Option<Command> {
    let is_live = |row: &&Row| row.tool.is_none_or(|of| of == tool);
    let mut all: Vec<(&KeyboardShortcut, &Row)> =
        rows().filter(is_live).flat_map(|row| row.shortcuts.iter().map(move |shortcut| (shortcut, row))).collect();
    all.sort_by_key(|(shortcut, row)| {
        let n_modifiers =
            shortcut.modifiers.shift as u8 + shortcut.modifiers.command as u8 + shortcut.modifiers.alt as u8;
        std::cmp::Reverse((n_modifiers, row.tool.is_some()))
    });
    let is_text = |(shortcut, row): &(&KeyboardShortcut, &Row)| {
        // Undo and redo inside a text field belong to the text.
        !shortcut.modifiers.command && !is_function_key(shortcut.logical_key)
            || matches!(row.command, Command::Undo | Command::Redo)
    };
    ctx.input_mut(|input| {
        let command_of = |event: &egui::Event| {
            let egui::Event::Key { key, pressed: true, modifiers, .. } = event else { return None };
            let is_pressed = |shortcut: &KeyboardShortcut| {
                *key == shortcut.logical_key && modifiers.matches_logically(shortcut.modifiers)
            };
            all.iter().find(|found| is_pressed(found.0) && !(is_typing && is_text(found))).map(|(_, row)| row.command)
        };
        let (at, command) = input.events.iter().enumerate().find_map(|(at, event)| Some((at, command_of(event)?)))?;
        input.events.remove(at);
        Some(command)
    })
}

fn is_function_key(key: Key) -> bool {
    matches!(key, Key::F1 | Key::F3 | Key::F11 | Key::F12)
}

/// How well a label answers a search; `None` where it does not. Lower is better.
pub fn search_rank(query: &str, row: &Row) -> Option<usize> {
    let haystack = format!("{} {} {}", row.label, row.group, row.help).to_lowercase();
    let query = query.trim().to_lowercase();
    let mut rank = 0;
    for word in query.split_whitespace() {
        rank += haystack.find(word)?;
    }
    Some(rank)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_shortcut_and_none_is_listed_twice() {
        let mut shortcuts = std::collections::HashSet::new();
        let mut commands = std::collections::HashSet::new();
        for row in rows() {
            assert!(commands.insert(row.command), "{:?}", row.command);
            for shortcut in row.shortcuts {
                // A tool may take a key over while it is active.
                assert!(shortcuts.insert(format!("{:?} {shortcut:?}", row.tool)), "{}: {shortcut:?}", row.label);
            }
        }
    }

    #[test]
    fn every_press_of_a_slow_frame_is_a_command_in_the_order_of_the_presses() {
        let press =
            |modifiers, key| egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
        let ctrl = Modifiers::COMMAND;
        let redo = press(ctrl | Modifiers::SHIFT, Key::Z);
        let undo = press(ctrl, Key::Z);
        let all = |is_typing| {
            let ctx = egui::Context::default();
            let events = vec![undo.clone(), undo.clone(), redo.clone(), press(ctrl, Key::S), undo.clone()];
            let mut commands = Vec::new();
            let mut output = ctx.run_ui(egui::RawInput { events, ..Default::default() }, |_| {
                commands.extend(std::iter::from_fn(|| pressed(&ctx, is_typing, Tool::Select)));
            });
            output.textures_delta.clear();
            commands
        };
        use Command::{Redo, Save, Undo};
        assert_eq!(all(false), [Undo, Undo, Redo, Save, Undo]);
        assert_eq!(all(true), [Save]);
    }

    #[test]
    fn search_finds_words_in_any_order_and_ranks_labels_first() {
        let rank = |query: &str, command: Command| search_rank(query, command.row());
        assert!(rank("head turn", Command::TurnHead).is_some());
        assert!(rank("xyz", Command::TurnHead).is_none());
        assert!(rank("save", Command::Save) < rank("save", Command::SavePicture).map(|rank| rank + 1));
        assert!(rank("undo", Command::Undo) < rank("undo", Command::Redo).or(Some(99)));
    }
}
