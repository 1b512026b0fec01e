//! What the left button does in the viewport: one tool at a time, its settings in the panel `Tool`.
//!
//! A tool draws over the picture, answers the pointer, and changes the groom through edits. Navigation,
//! framing and undo belong to every tool alike and are not here.

pub mod brush_input;
pub mod mesh;
pub mod paint;
pub mod pull;
pub mod sculpt;
pub mod surface;

use egui::{Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};
use glam::Vec3;
use lorelei_core::groom::Groom;
use lorelei_render::overlay::Overlay;

use super::commands::Command;
use super::desk::{Desk, Selection};
use super::projection::Projection;
use super::state_report::mark;
use super::theme;

/// Which tool the left button is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Tool {
    /// Lights, the head, layers.
    #[default]
    Select,
    /// The hair mesh: its faces, edges and vertices.
    Mesh,
    /// Brushes on the hair.
    Sculpt,
    /// Brushes on maps over the scalp.
    Paint,
    /// A hand that holds hair while it moves.
    Pull,
}

impl Tool {
    pub const ALL: [Self; 5] = [Self::Select, Self::Mesh, Self::Sculpt, Self::Paint, Self::Pull];

    pub fn label(self) -> &'static str {
        match self {
            Self::Select => "Select",
            Self::Mesh => "Model",
            Self::Sculpt => "Sculpt",
            Self::Paint => "Paint",
            Self::Pull => "Pull",
        }
    }
}

/// The tools' own states; they stay when another one is taken.
#[derive(Default)]
pub struct Tools {
    pub active: Tool,
    pub mesh: mesh::MeshTool,
    pub sculpt: sculpt::SculptTool,
    pub paint: paint::PaintTool,
    pub pull: pull::PullTool,
    pub surface: surface::HeadSurface,
}

impl Tools {
    /// Plain keys belong to what a tool is doing, not to commands.
    pub fn takes_keys(&self) -> bool {
        match self.active {
            Tool::Mesh => self.mesh.takes_keys(),
            Tool::Sculpt => self.sculpt.takes_keys(),
            Tool::Select | Tool::Paint | Tool::Pull => false,
        }
    }

    /// What the active tool wants to see on the scalp.
    pub fn overlay(&self, groom: &Groom, selection: Selection) -> Option<Overlay> {
        match self.active {
            Tool::Paint => self.paint.overlay(groom, selection),
            Tool::Select | Tool::Mesh | Tool::Sculpt | Tool::Pull => None,
        }
    }
}

/// What a tool sees of the viewport in one frame. Places are in the space of the head at rest, in which the
/// groom is written: the projection has the head's pose in it.
pub struct View<'a> {
    pub projection: Projection,
    /// The eye, in the same space.
    pub eye: Vec3,
    pub response: &'a Response,
    /// The camera is being moved: the pointer is not the tool's.
    pub is_navigating: bool,
}

impl View<'_> {
    /// Unit vectors to the right and up on the screen, in the head's space.
    pub fn right(&self) -> Vec3 {
        self.across(vec2(40.0, 0.0))
    }

    pub fn up(&self) -> Vec3 {
        self.across(vec2(0.0, -40.0))
    }

    fn across(&self, by: egui::Vec2) -> Vec3 {
        let middle = self.projection.rect().center();
        let (a, toward) = self.projection.ray(middle);
        let (b, _) = self.projection.ray(middle + by);
        (b - a).reject_from_normalized(toward).normalize_or(Vec3::X)
    }

    /// The pointer, where it is over the viewport and free for the tool.
    pub fn pointer(&self, ui: &Ui) -> Option<Pos2> {
        let at = ui.input(|input| input.pointer.latest_pos())?;
        let is_ours = self.response.contains_pointer() || self.response.dragged();
        (is_ours && !self.is_navigating).then_some(at)
    }
}

/// Run the active tool; true while it is dragging something.
pub fn viewport(
    ui: &mut Ui,
    desk: &mut Desk,
    projection: Projection,
    response: &Response,
    is_navigating: bool,
) -> bool {
    let world_from_head = desk.report.world_from_head;
    let view = View {
        projection: projection.after(world_from_head.into()),
        eye: world_from_head.inverse().transform_point3(desk.camera.eye()),
        response,
        is_navigating: is_navigating || ui.input(|input| input.modifiers.alt),
    };
    let mut tools = std::mem::take(&mut desk.tools);
    let is_busy = match tools.active {
        Tool::Select => false,
        Tool::Mesh => tools.mesh.viewport(ui, desk, &view, &mut tools.surface),
        Tool::Sculpt => tools.sculpt.viewport(ui, desk, &view, &mut tools.surface),
        Tool::Paint => tools.paint.viewport(ui, desk, &view, &mut tools.surface),
        Tool::Pull => tools.pull.viewport(ui, desk, projection, &view),
    };
    if tools.active != Tool::Pull {
        desk.playback.hand = None;
    }
    desk.tools = tools;
    buttons(ui, desk, projection.rect());
    is_busy
}

/// What the pointer does now, for the status bar.
pub fn hint(desk: &Desk) -> &'static str {
    match desk.tools.active {
        Tool::Pull if desk.report.held.is_some() && !desk.playback.is_playing => {
            "Held: Space lets time pass and the pull act; release lets go"
        }
        Tool::Pull => "Left drag on hair: pull it while it plays    Middle drag: orbit    Wheel: zoom    Space: play",
        Tool::Select | Tool::Mesh | Tool::Sculpt | Tool::Paint => {
            "Middle drag: orbit    Shift: pan    Wheel: zoom    F: frame    Space: play    F3: commands    F1: shortcuts"
        }
    }
}

/// The settings of the active tool.
pub fn panel(ui: &mut Ui, desk: &mut Desk) {
    let mut tools = std::mem::take(&mut desk.tools);
    ui.heading(tools.active.label());
    match tools.active {
        Tool::Select => {
            ui.label("Drag a light's disc to aim it, the handle at the neck to move the head.");
        }
        Tool::Mesh => tools.mesh.panel(ui, desk),
        Tool::Sculpt => tools.sculpt.panel(ui, desk),
        Tool::Paint => tools.paint.panel(ui, desk),
        Tool::Pull => tools.pull.panel(ui, desk),
    }
    desk.tools = tools;
}

/// One button a tool, at the viewport's left edge.
fn buttons(ui: &mut Ui, desk: &mut Desk, rect: Rect) {
    for (i, tool) in Tool::ALL.into_iter().enumerate() {
        let min = rect.left_top() + vec2(12.0, 48.0 + 38.0 * i as f32);
        let place = Rect::from_min_size(min, vec2(34.0, 34.0));
        let id = ui.scope_id().with(("tool", i));
        let response = ui.interact(place, id, Sense::click());
        let is_active = desk.tools.active == tool;
        let fill = match (is_active, response.hovered()) {
            (true, _) => theme::ACCENT_DIM,
            (false, true) => theme::CONTROL_HOVER,
            (false, false) => theme::CONTROL.gamma_multiply(0.85),
        };
        ui.painter().rect_filled(place, 4.0, fill);
        let colour = if is_active { theme::TEXT_STRONG } else { theme::TEXT };
        icon(ui, tool, place.center(), colour);
        mark(ui.ctx(), || format!("tool {}", tool.label()), place);
        let row = Command::Tool(tool).row();
        let key = row.shortcuts.first().map(|s| ui.ctx().format_shortcut(s)).unwrap_or_default();
        if response.on_hover_text(format!("{} ({key})\n{}", row.label, row.help)).clicked() {
            desk.asked.push(Command::Tool(tool));
        }
    }
}

fn icon(ui: &Ui, tool: Tool, at: Pos2, colour: Color32) {
    let painter = ui.painter();
    let stroke = Stroke::new(1.4, colour);
    let line = |points: &[(f32, f32)]| {
        let points = points.iter().map(|(x, y)| pos2(at.x + x, at.y + y)).collect();
        painter.add(egui::Shape::line(points, stroke));
    };
    match tool {
        Tool::Select => {
            line(&[
                (-4.0, -8.0),
                (-4.0, 6.0),
                (-0.5, 2.5),
                (2.0, 8.0),
                (4.5, 7.0),
                (2.0, 1.5),
                (6.5, 1.5),
                (-4.0, -8.0),
            ]);
        }
        Tool::Mesh => {
            line(&[(-8.0, 5.0), (0.0, 8.0), (8.0, 5.0), (7.0, -5.0), (0.0, -8.0), (-7.0, -5.0), (-8.0, 5.0)]);
            line(&[(-7.0, -5.0), (0.0, -2.5), (7.0, -5.0)]);
            line(&[(0.0, -2.5), (0.0, 8.0)]);
        }
        Tool::Sculpt => {
            line(&[(-8.0, -6.0), (8.0, -6.0), (8.0, -2.0), (-8.0, -2.0), (-8.0, -6.0)]);
            for x in [-7.0, -3.5, 0.0, 3.5, 7.0] {
                line(&[(x, -2.0), (x, 7.0)]);
            }
        }
        Tool::Paint => {
            line(&[(8.0, -8.0), (-1.0, 1.0)]);
            line(&[(-1.0, 1.0), (-4.0, 1.5), (-6.0, 4.0), (-8.0, 8.0), (-3.5, 7.0), (-0.5, 5.0), (-1.0, 1.0)]);
        }
        Tool::Pull => {
            // A strand that is drawn aside, and where it is held.
            line(&[(-5.0, -8.0), (-4.5, -4.0), (-2.0, -1.0), (3.0, 1.0)]);
            line(&[(3.0, 1.0), (-0.5, 3.0), (-2.5, 5.5), (-3.0, 8.0)]);
            painter.circle_stroke(at + vec2(5.0, 1.5), 2.6, stroke);
        }
    }
}
