//! What keys and buttons do while the hair is brushed.

use std::sync::Arc;

use egui::Key;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::sculpt::{SculptBrush, SculptChange, SculptGuide, SculptLayer};

use crate::window::commands::{Command, Row, key, shift};
use crate::window::desk::Desk;
use crate::window::tools::{Tool, brush_input};

/// A command of the sculpting tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SculptCommand {
    Brush(SculptBrush),
    Radius,
    Strength,
    Mirror,
    AddLayer,
    RemoveLayer,
    MergeDown,
    Thaw,
    InvertFrozen,
}

const fn row(
    command: SculptCommand,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [egui::KeyboardShortcut],
) -> Row {
    Row { command: Command::Sculpt(command), group: "Sculpt", label, help, shortcuts, tool: Some(Tool::Sculpt) }
}

/// In the order of the shortcut sheet.
#[rustfmt::skip]
pub const SCULPT_COMMANDS: &[Row] = &[
    row(SculptCommand::Brush(SculptBrush::Comb), "Comb", "Draw the hair along with the pointer", &[key(Key::Num1)]),
    row(SculptCommand::Brush(SculptBrush::Smooth), "Smooth", "Straighten the hair and even it out with its neighbours", &[key(Key::Num2)]),
    row(SculptCommand::Brush(SculptBrush::Puff), "Puff", "Lift the hair off the scalp; Ctrl presses it down", &[key(Key::Num3)]),
    row(SculptCommand::Brush(SculptBrush::Pinch), "Pinch", "Gather the hair under the pointer; Ctrl spreads it", &[key(Key::Num4)]),
    row(SculptCommand::Brush(SculptBrush::Clump), "Clump", "Draw the hair to the middle of its lock; Ctrl apart", &[key(Key::Num5)]),
    row(SculptCommand::Brush(SculptBrush::Twist), "Twist", "Turn the lock about its own middle; Ctrl the other way", &[key(Key::Num6)]),
    row(SculptCommand::Brush(SculptBrush::Curl), "Curl", "Roll the hair up; Ctrl the other way", &[key(Key::Num7)]),
    row(SculptCommand::Brush(SculptBrush::Part), "Part", "Lay the hair to the two sides of the stroke", &[key(Key::Num8)]),
    row(SculptCommand::Brush(SculptBrush::Length), "Length", "Let the hair grow; Ctrl shrinks it", &[key(Key::Num9)]),
    row(SculptCommand::Brush(SculptBrush::Cut), "Cut", "Cut the hair where the pointer crosses it; Ctrl lets it come back", &[key(Key::Num0)]),
    row(SculptCommand::Brush(SculptBrush::Add), "Add", "Plant hair, or bring back what was deleted; Ctrl deletes", &[key(Key::A)]),
    row(SculptCommand::Brush(SculptBrush::Delete), "Delete", "Take hair away; Ctrl brings it back", &[key(Key::D)]),
    row(SculptCommand::Brush(SculptBrush::Slide), "Slide roots", "Move the roots over the scalp", &[key(Key::S)]),
    row(SculptCommand::Brush(SculptBrush::Freeze), "Freeze", "Frozen hair is left alone by every brush; Ctrl thaws it", &[key(Key::Z)]),
    row(SculptCommand::Brush(SculptBrush::Mask), "Mask", "Where this sculpt layer acts less, if its mask says so; Ctrl takes it off", &[key(Key::M)]),
    row(SculptCommand::Radius, "Radius of the brush", "Follows the pointer; click keeps, Esc takes back", &[key(Key::F)]),
    row(SculptCommand::Strength, "Strength of the brush", "Follows the pointer; click keeps, Esc takes back", &[shift(Key::F)]),
    row(SculptCommand::Mirror, "Mirror across X", "The same on the other side of the face, or not", &[key(Key::X)]),
    row(SculptCommand::AddLayer, "Add a sculpt layer", "Above the others; strokes go there", &[shift(Key::A)]),
    row(SculptCommand::RemoveLayer, "Remove the sculpt layer", "With its strokes", &[]),
    row(SculptCommand::MergeDown, "Merge the sculpt layer down", "Into the one below; the hair stays as it is", &[]),
    row(SculptCommand::Thaw, "Thaw all", "No hair is frozen any more", &[]),
    row(SculptCommand::InvertFrozen, "Invert what is frozen", "Frozen hair thaws, the rest freezes", &[shift(Key::I)]),
];

pub fn is_enabled(desk: &Desk, command: SculptCommand) -> bool {
    let Some(layer) = super::layer_idx(desk).map(|layer_idx| &desk.document.groom.layers[layer_idx]) else {
        return false;
    };
    let sculpt_idx = desk.tools.sculpt.sculpt_idx;
    let has_layer = sculpt_idx < layer.sculpt.layers.len();
    match command {
        SculptCommand::Brush(_)
        | SculptCommand::Radius
        | SculptCommand::Strength
        | SculptCommand::Mirror
        | SculptCommand::AddLayer => true,
        SculptCommand::RemoveLayer | SculptCommand::Thaw | SculptCommand::InvertFrozen => has_layer,
        SculptCommand::MergeDown => has_layer && sculpt_idx > 0,
    }
}

/// Do what a command says.
pub fn run(desk: &mut Desk, command: SculptCommand) {
    let Some(layer_idx) = super::layer_idx(desk) else { return };
    let layer = &desk.document.groom.layers[layer_idx];
    let tool = &mut desk.tools.sculpt;
    let (sculpt_idx, n_sculpts) = (tool.sculpt_idx, layer.sculpt.layers.len());
    let (label, edit) = match command {
        SculptCommand::Brush(kind) => return tool.kind = kind,
        SculptCommand::Radius => {
            return tool.setting = Some(brush_input::Setting::new(false, &tool.brush));
        }
        SculptCommand::Strength => {
            return tool.setting = Some(brush_input::Setting::new(true, &tool.brush));
        }
        SculptCommand::Mirror => return tool.brush.is_symmetric ^= true,
        SculptCommand::AddLayer => {
            tool.sculpt_idx = n_sculpts;
            let sculpt = Box::new(SculptLayer::new(&format!("Sculpt {}", n_sculpts + 1)));
            ("Add a sculpt layer", Edit::AddSculpt { layer_idx, sculpt_idx: n_sculpts, sculpt })
        }
        SculptCommand::RemoveLayer => {
            tool.sculpt_idx = sculpt_idx.saturating_sub(1);
            ("Remove the sculpt layer", Edit::RemoveSculpt { layer_idx, sculpt_idx })
        }
        SculptCommand::MergeDown => {
            let Some(merged) = layer.sculpt.merged_down(&layer.maps, sculpt_idx) else {
                return desk
                    .notices
                    .error("The sculpt layers were not merged", "Both must be on: switch them on first.");
            };
            tool.sculpt_idx = sculpt_idx - 1;
            let below = sculpt_idx - 1;
            let edits = vec![
                Edit::RemoveSculpt { layer_idx, sculpt_idx },
                Edit::RemoveSculpt { layer_idx, sculpt_idx: below },
                Edit::AddSculpt { layer_idx, sculpt_idx: below, sculpt: Box::new(merged) },
            ];
            ("Merge the sculpt layer down", Edit::Batch(edits))
        }
        SculptCommand::Thaw => ("Thaw all", frozen(layer_idx, sculpt_idx, layer, |_| 0.0)),
        SculptCommand::InvertFrozen => {
            ("Invert what is frozen", frozen(layer_idx, sculpt_idx, layer, |frozen| 1.0 - frozen))
        }
    };
    desk.document.edit(label, edit, Merge::New);
}

/// What is frozen, changed everywhere: the chosen sculpt layer says it for all of them.
fn frozen(layer_idx: usize, sculpt_idx: usize, layer: &lorelei_core::groom::Layer, to: impl Fn(f32) -> f32) -> Edit {
    let sculpt = &layer.sculpt;
    let changes_of = |at: usize| -> Edit {
        let strokes = Arc::clone(&sculpt.layers[at].strokes);
        let all = (0..sculpt.roots.positions.len() as u32).filter_map(|guide| {
            let most = sculpt.layers.iter().filter_map(|layer| layer.strokes.get(guide)).map(|guide| guide.frozen);
            let wanted = if at == sculpt_idx { to(most.fold(0.0, f32::max)) } else { 0.0 };
            let before = strokes.get(guide).copied().unwrap_or_default();
            let after = SculptGuide { frozen: wanted, ..before };
            let to = (!after.is_untouched()).then(|| Box::new(after));
            (after != before).then_some(SculptChange { guide, to })
        });
        Edit::Sculpt { layer_idx, sculpt_idx: at, changes: all.collect() }
    };
    Edit::Batch((0..sculpt.layers.len()).map(changes_of).collect())
}
