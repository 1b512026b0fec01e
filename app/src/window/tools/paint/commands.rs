//! What keys and buttons do while maps are painted.

use std::sync::Arc;

use egui::Key;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::maps::ScalpMap;

use crate::window::commands::{Command, Row, key, shift};
use crate::window::desk::Desk;
use crate::window::tools::{Tool, brush_input};

/// A command of the painting tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PaintCommand {
    Radius,
    Strength,
    Sample,
    Mirror,
    Fill,
    Clear,
    Invert,
    Load,
    Save,
}

const fn row(
    command: PaintCommand,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [egui::KeyboardShortcut],
) -> Row {
    Row { command: Command::Paint(command), group: "Paint", label, help, shortcuts, tool: Some(Tool::Paint) }
}

/// In the order of the shortcut sheet.
#[rustfmt::skip]
pub const PAINT_COMMANDS: &[Row] = &[
    row(PaintCommand::Radius, "Radius of the brush", "Follows the pointer; click keeps, Esc takes back", &[key(Key::F)]),
    row(PaintCommand::Strength, "Strength of the brush", "Follows the pointer; click keeps, Esc takes back", &[shift(Key::F)]),
    row(PaintCommand::Sample, "Take the value under the pointer", "From the map that is painted", &[key(Key::S)]),
    row(PaintCommand::Mirror, "Mirror across X", "The same on the other side of the face, or not", &[key(Key::X)]),
    row(PaintCommand::Fill, "Fill the map", "The value everywhere", &[shift(Key::K)]),
    row(PaintCommand::Clear, "Erase the map", "Back to what the hair is without it", &[shift(Key::Delete)]),
    row(PaintCommand::Invert, "Invert the map", "Least for most and most for least", &[shift(Key::I)]),
    row(PaintCommand::Load, "Load a map\u{2026}", "A PNG or EXR over the scalp's texture coordinates", &[]),
    row(PaintCommand::Save, "Save the map\u{2026}", "As PNG or EXR", &[]),
];

pub fn is_enabled(desk: &Desk, command: PaintCommand) -> bool {
    let layer = super::layer_idx(desk);
    let has_map = layer
        .and_then(|layer_idx| desk.document.groom.layers.get(layer_idx))
        .is_some_and(|layer| layer.maps.contains_key(&desk.tools.paint.kind));
    match command {
        PaintCommand::Radius | PaintCommand::Strength | PaintCommand::Sample | PaintCommand::Mirror => true,
        PaintCommand::Fill | PaintCommand::Load => layer.is_some(),
        PaintCommand::Clear | PaintCommand::Invert | PaintCommand::Save => has_map,
    }
}

/// Do what a command says; those on files are the window's own.
pub fn run(desk: &mut Desk, command: PaintCommand) {
    let Some(layer_idx) = super::layer_idx(desk) else { return };
    let paint = &mut desk.tools.paint;
    let kind = paint.kind.clone();
    let known = desk.document.groom.layers[layer_idx].maps.get(&kind).cloned();
    let (label, map) = match command {
        PaintCommand::Radius => return paint.setting = Some(brush_input::Setting::new(false, &paint.brush)),
        PaintCommand::Strength => return paint.setting = Some(brush_input::Setting::new(true, &paint.brush)),
        PaintCommand::Sample => return paint.wants_sample = true,
        PaintCommand::Mirror => return paint.brush.is_symmetric ^= true,
        PaintCommand::Load | PaintCommand::Save => return,
        PaintCommand::Fill => {
            let texel = kind.texel(paint.value);
            let [width, height] = known.map_or([ScalpMap::DEFAULT_SIDE; 2], |map| [map.width(), map.height()]);
            ("Fill", Some(ScalpMap::filled(width, height, texel)))
        }
        PaintCommand::Clear => ("Erase", None),
        PaintCommand::Invert => {
            let Some(map) = known else { return };
            let inverted = ScalpMap::from_fn(map.width(), map.height(), |x, y| 255 - map.texel(x, y));
            ("Invert", inverted.ok())
        }
    };
    let label = format!("{label} {}", kind.label().to_lowercase());
    super::count_where_full(desk, layer_idx, &kind);
    desk.document.edit(&label, Edit::SetMap { layer_idx, kind, map: map.map(Arc::new) }, Merge::New);
}
