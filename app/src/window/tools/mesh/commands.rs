//! What keys and menus do to the hair mesh while it is modelled.

use egui::{Key, KeyboardShortcut, Modifiers};

use crate::window::commands::{Command, Row, ctrl, key, shift};
use crate::window::tools::Tool;

/// A command of the modelling tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MeshCommand {
    Vertices,
    Edges,
    Faces,
    SelectAll,
    SelectNone,
    Invert,
    Grow,
    Shrink,
    Loop,
    Ring,
    Bundle,
    Layer,
    Linked,
    Move,
    Rotate,
    Scale,
    Slide,
    Extend,
    Extrude,
    ExtrudeDown,
    DeleteTips,
    DeleteBundles,
    InsertLayer,
    RemoveLayer,
    Separate,
    Weld,
    DivideFace,
    DivideEdge,
    Subdivide,
    Relax,
    Smooth,
    Pin,
    Unpin,
    Mirror,
    SnapToHead,
    ToggleSoft,
    ToggleInside,
    ToggleXRay,
    PushBrush,
}

const fn row(
    command: MeshCommand,
    label: &'static str,
    help: &'static str,
    shortcuts: &'static [KeyboardShortcut],
) -> Row {
    Row { command: Command::Mesh(command), group: "Mesh", label, help, shortcuts, tool: Some(Tool::Mesh) }
}

const fn alt(key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(Modifiers::ALT, key)
}

/// In the order of the menu.
#[rustfmt::skip]
pub const MESH_COMMANDS: &[Row] = &[
    row(MeshCommand::Vertices, "Select vertices", "A click takes a vertex", &[key(Key::Num1)]),
    row(MeshCommand::Edges, "Select edges", "A click takes an edge", &[key(Key::Num2)]),
    row(MeshCommand::Faces, "Select faces", "A click takes a face: the tip of a bundle", &[key(Key::Num3)]),
    row(MeshCommand::SelectAll, "Select all", "The whole outer surface", &[key(Key::A)]),
    row(MeshCommand::SelectNone, "Select nothing", "", &[alt(Key::A)]),
    row(MeshCommand::Invert, "Invert the selection", "On the outer surface", &[ctrl(Key::I)]),
    row(MeshCommand::Grow, "Grow the selection", "By what is next to it", &[key(Key::Period)]),
    row(MeshCommand::Shrink, "Shrink the selection", "By its border", &[key(Key::Comma)]),
    row(MeshCommand::Loop, "Select the loop", "Edge after edge straight on; also a double-click", &[key(Key::L)]),
    row(MeshCommand::Ring, "Select the ring", "Edges side by side across faces; also Ctrl and a double-click", &[ctrl(Key::L)]),
    row(MeshCommand::Bundle, "Select whole bundles", "From root to tip", &[key(Key::U)]),
    row(MeshCommand::Layer, "Select whole layers", "All that is in the layers of what is selected", &[shift(Key::U)]),
    row(MeshCommand::Linked, "Select what holds together", "All that is connected with what is selected", &[ctrl(Key::U)]),
    row(MeshCommand::Move, "Move", "Follows the pointer", &[key(Key::G)]),
    row(MeshCommand::Rotate, "Rotate", "About the middle of what is selected", &[key(Key::R)]),
    row(MeshCommand::Scale, "Scale", "From the middle of what is selected", &[key(Key::S)]),
    row(MeshCommand::Slide, "Slide along the hair", "Towards the tip or the root", &[shift(Key::V)]),
    row(MeshCommand::Extend, "Extend", "Each vertex the way its hair goes: longer or shorter", &[alt(Key::S)]),
    row(MeshCommand::Extrude, "Extrude", "A new layer on the selected faces, then its length by the pointer", &[key(Key::E)]),
    row(MeshCommand::ExtrudeDown, "Extrude down", "As Extrude, giving way to the hair's weight", &[shift(Key::E)]),
    row(MeshCommand::DeleteTips, "Delete tip faces", "Shortens the selected bundles by a layer; at the root, deletes them", &[key(Key::X), key(Key::Delete)]),
    row(MeshCommand::DeleteBundles, "Delete bundles", "From tip to root: no hair grows there", &[shift(Key::X)]),
    row(MeshCommand::InsertLayer, "Insert a layer", "Below the topmost layer that has something selected", &[ctrl(Key::R)]),
    row(MeshCommand::RemoveLayer, "Remove a layer", "The topmost layer that has something selected", &[ctrl(Key::X)]),
    row(MeshCommand::Separate, "Separate", "Open the mesh along the selected edges, or at the selected vertices", &[key(Key::Y)]),
    row(MeshCommand::Weld, "Weld", "Join what was separated: selected edges, or vertices", &[key(Key::M)]),
    row(MeshCommand::DivideFace, "Divide faces", "Between two selected corners, or into quads around the middle", &[key(Key::J)]),
    row(MeshCommand::DivideEdge, "Divide an edge", "A new vertex on the selected edge, in all layers", &[key(Key::D)]),
    row(MeshCommand::Subdivide, "Subdivide", "The selected bundles, or all, by the scheme in the panel", &[key(Key::W)]),
    row(MeshCommand::Relax, "Relax the inside", "Place all inner vertices that are not pinned", &[shift(Key::R)]),
    row(MeshCommand::Smooth, "Smooth", "Selected vertices towards the middle of their neighbours", &[key(Key::V)]),
    row(MeshCommand::Pin, "Pin", "Selected vertices stay when the inside is placed", &[key(Key::P)]),
    row(MeshCommand::Unpin, "Unpin", "Selected vertices are placed with the inside again", &[alt(Key::P)]),
    row(MeshCommand::Mirror, "Mirror to the other side", "The half of +X as it is on \u{2212}X", &[ctrl(Key::M)]),
    row(MeshCommand::SnapToHead, "Snap to the head", "Selected vertices onto the head, at the clearance", &[shift(Key::H)]),
    row(MeshCommand::ToggleSoft, "Soft selection", "What is near follows less", &[key(Key::O)]),
    row(MeshCommand::ToggleInside, "Show the inside", "The vertices that the studio places", &[key(Key::I)]),
    row(MeshCommand::ToggleXRay, "See through", "Show and take what is behind", &[alt(Key::Z)]),
    row(MeshCommand::PushBrush, "Push brush", "Drags push the outer surface out, with Ctrl in, with Shift smooth it", &[key(Key::T)]),
];
