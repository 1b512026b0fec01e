//! Modelling the hair mesh: one frame of the tool in the viewport, from what is seen to what the pointer does.
//!
//! `cage` draws and picks, `selection` says what is taken, `grab` moves it, `push` is the brush on the outer surface,
//! `ops` are the operations, `panel` their settings.

mod cage;
pub mod commands;
mod grab;
mod ops;
mod panel;
mod push;
mod selection;
mod settings;

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Align2, Color32, Pos2, Rect, Shape, Stroke, Ui, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::hair_mesh::{HairMesh, Limits, MeshOp, VertexId, VertexMotion};
use lorelei_core::history::Merge;
use lorelei_core::mesh_query::MeshQuery;

use super::View;
use super::surface::HeadSurface;
use crate::window::desk::Desk;
use crate::window::theme;
use cage::{Cage, Seen};
use commands::MeshCommand;
use grab::{Grab, GrabEnd};
use selection::{Join, MeshSelection, Picked};
use settings::{Area, Settings};

/// How long a refusal stays beside the pointer.
const TOLD_FOR: Duration = Duration::from_secs(6);

/// The operation that was done last, as long as nothing came after it: its numbers can still be changed.
pub struct LastOp {
    layer_idx: usize,
    label: String,
    op: MeshOp,
    before: MeshSelection,
    state: (u64, u64),
}

/// The tool's state.
#[derive(Default)]
pub struct MeshTool {
    pub settings: Settings,
    pub selection: MeshSelection,
    cage: Cage,
    grab: Option<Grab>,
    /// The grab has moved something: there is a step to take back.
    has_moved: bool,
    n_grabs: u64,
    push: push::PushStroke,
    /// The points of a box or a lasso that is being drawn.
    area: Vec<Pos2>,
    refusal: Option<(String, Instant)>,
    last: Option<LastOp>,
    head: Option<Arc<MeshQuery>>,
}

impl MeshTool {
    /// Keys belong to what is being moved, not to commands.
    pub fn takes_keys(&self) -> bool {
        self.grab.is_some()
    }

    /// True while something is dragged.
    pub fn viewport(&mut self, ui: &mut Ui, desk: &mut Desk, view: &View<'_>, surface: &mut HeadSurface) -> bool {
        self.head = surface.query(desk.document.groom.head.as_ref());
        let Some((layer_idx, mesh)) = ops::target(desk) else {
            self.grab = None;
            let at = view.projection.rect().center_top() + vec2(0.0, 30.0);
            let text = "No hair mesh yet: make one in the panel Tool";
            grab::outlined(ui, at, Align2::CENTER_CENTER, text, theme::TEXT);
            self.tell_refusal(ui, view);
            return false;
        };
        self.cage.update(&mesh);
        self.selection.keep_what_is_there(&mesh);
        if self.grab.as_ref().is_some_and(|grab| !grab.is_of(&mesh)) {
            // Undone, or another layer: there is nothing left to hold.
            self.grab = None;
        }
        let is_moving = self.grab.is_some() || self.push.is_drawn() || view.is_navigating;
        let seen = self.cage.look(view, self.settings.display, self.head.as_deref(), is_moving);
        let pointer = view.pointer(ui);
        let is_free = self.grab.is_none() && self.area.is_empty() && !self.settings.is_pushing;
        let hovered =
            pointer.filter(|_| is_free).and_then(|at| self.cage.pick(view, &seen, self.selection.element, at));
        self.cage.draw(ui, &seen, &self.selection, self.settings.display, hovered);
        self.mark(ui, view, &mesh);
        let mut is_busy = true;
        if self.grab.is_some() {
            self.follow_grab(ui, desk, view, layer_idx);
        } else if self.settings.is_pushing {
            is_busy = self.push_brush(ui, desk, view, layer_idx, &mesh);
        } else {
            let taken = self.handles(ui, view, &mesh);
            is_busy = taken || self.select(ui, view, &mesh, &seen, hovered);
        }
        self.tell_refusal(ui, view);
        is_busy
    }

    fn limits(&self) -> Limits<'_> {
        let head = self.head.as_deref().filter(|_| self.settings.stays_out);
        Limits { head, clearance: self.settings.clearance, relaxes: self.settings.relaxes }
    }

    fn handles(&mut self, ui: &mut Ui, view: &View<'_>, mesh: &Arc<HairMesh>) -> bool {
        if self.selection.is_empty() || !self.area.is_empty() {
            return false;
        }
        let drag = self.drag_of(mesh, false);
        let kind = self.settings.handle;
        let Some(axis) = grab::handles(ui, view, kind, drag.pivot) else { return false };
        let drag = self.drag_of(mesh, self.settings.is_soft);
        self.n_grabs += 1;
        self.has_moved = false;
        self.grab = Some(Grab::held(kind, drag, axis));
        true
    }

    fn follow_grab(&mut self, ui: &Ui, desk: &mut Desk, view: &View<'_>, layer_idx: usize) {
        let Some(mut grab) = self.grab.take() else { return };
        let (motion, end) = grab.follow(ui, view);
        grab.draw(ui, view);
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
        if self.settings.is_soft {
            let radius = self.settings.soft_radius / view.projection.cm_per_point(grab.drag.pivot).max(1e-6);
            if let Some(at) = view.projection.point(grab.drag.pivot) {
                ui.painter().circle_stroke(at, radius, Stroke::new(1.0, Color32::from_white_alpha(90)));
            }
        }
        self.grab = Some(grab);
        match (end, motion) {
            (GrabEnd::GoesOn, Some(motion)) => self.move_to(desk, layer_idx, motion),
            (GrabEnd::GoesOn, None) => {}
            (GrabEnd::Kept, motion) => self.keep(desk, layer_idx, motion),
            (GrabEnd::TakenBack, _) => {
                if std::mem::take(&mut self.has_moved) {
                    desk.document.take_back();
                }
                self.grab = None;
            }
        }
    }

    /// End a grab: its step then holds what has moved and nothing more.
    fn keep(&mut self, desk: &mut Desk, layer_idx: usize, motion: Option<VertexMotion>) {
        let Some(mut grab) = self.grab.take() else { return };
        if std::mem::take(&mut self.has_moved) {
            desk.document.take_back();
        }
        let Some(motion) = motion else { return };
        let moves = grab.drag.changes(motion, self.limits());
        if !moves.is_empty() {
            let label = format!("{} {} vertices", grab.kind.label(), grab.drag.weights().len());
            desk.document.edit(&label, Edit::MoveVertices { layer_idx, moves }, Merge::New);
        }
    }

    /// Clicks, double-clicks, boxes and lassos.
    fn select(&mut self, ui: &Ui, view: &View<'_>, mesh: &HairMesh, seen: &Seen, hovered: Option<Picked>) -> bool {
        let response = view.response;
        let modifiers = ui.input(|input| input.modifiers);
        let join = match (modifiers.shift, modifiers.command) {
            (true, _) => Join::Add,
            (false, true) => Join::Remove,
            (false, false) => Join::Replace,
        };
        if response.double_clicked() && !modifiers.alt {
            let command = if modifiers.command { MeshCommand::Ring } else { MeshCommand::Loop };
            if let Err(why) = self.selection.spread(mesh, command) {
                self.refuse(why);
            }
        } else if response.clicked() && !modifiers.alt {
            let picked: Vec<Picked> = hovered.into_iter().collect();
            // A click on what is selected already, with Shift, takes it out.
            let join = if join == Join::Add { Join::Toggle } else { join };
            self.selection.join(mesh, &picked, join);
            self.last = None;
        }
        if response.drag_started_by(egui::PointerButton::Primary) && !view.is_navigating {
            self.area = ui.input(|input| input.pointer.press_origin()).into_iter().collect();
        }
        if self.area.is_empty() {
            return false;
        }
        let Some(at) = ui.input(|input| input.pointer.latest_pos()) else { return true };
        if self.settings.area == Area::Box {
            self.area.truncate(1);
        }
        self.area.push(at);
        let outline = self.outline();
        let stroke = Stroke::new(1.2, theme::ACCENT);
        ui.painter().add(Shape::closed_line(outline.clone(), stroke));
        if response.drag_stopped() || !ui.input(|input| input.pointer.primary_down()) {
            let picked = self.cage.within(seen, self.selection.element, |p| is_inside(&outline, p));
            self.selection.join(mesh, &picked, join);
            self.area.clear();
        } else if ui.input(|input| input.key_pressed(egui::Key::Escape)) {
            self.area.clear();
        }
        true
    }

    fn outline(&self) -> Vec<Pos2> {
        match (self.settings.area, &self.area[..]) {
            (Area::Box, [a, .., b]) => {
                let rect = Rect::from_two_pos(*a, *b);
                vec![rect.left_top(), rect.right_top(), rect.right_bottom(), rect.left_bottom()]
            }
            (Area::Box | Area::Lasso, points) => points.to_vec(),
        }
    }

    /// Why an operation was refused, where the pointer is.
    fn tell_refusal(&mut self, ui: &Ui, view: &View<'_>) {
        let Some((why, since)) = &self.refusal else { return };
        if since.elapsed() > TOLD_FOR {
            self.refusal = None;
            return;
        }
        let rect = view.projection.rect();
        let at = ui.input(|input| input.pointer.latest_pos()).filter(|at| rect.contains(*at)).unwrap_or(rect.center());
        let font = egui::TextStyle::Body.resolve(ui.style());
        let galley = ui.painter().layout(why.clone(), font, theme::TEXT_STRONG, 320.0);
        let place = Rect::from_min_size(at + vec2(18.0, 12.0), galley.size()).translate(vec2(0.0, 0.0));
        let place = place.translate(vec2(
            (rect.right() - 12.0 - place.right()).min(0.0),
            (rect.bottom() - 12.0 - place.bottom()).min(0.0),
        ));
        ui.painter().rect_filled(place.expand(8.0), 4.0, Color32::from_black_alpha(215));
        ui.painter().rect_stroke(place.expand(8.0), 4.0, Stroke::new(1.0, theme::ERROR), egui::StrokeKind::Inside);
        ui.painter().galley(place.min, galley, theme::TEXT_STRONG);
        ui.ctx().request_repaint_after(Duration::from_millis(500));
    }

    /// What a test needs to know of places.
    fn mark(&self, ui: &Ui, view: &View<'_>, mesh: &HairMesh) {
        let marks = self.cage.outer.vertices.iter().filter(|id: &&VertexId| id.vertex.is_multiple_of(5));
        for &id in marks {
            if let Some(at) = mesh.position(id).and_then(|p| view.projection.point(p)) {
                let name = || format!("vertex {} {}", id.layer, id.vertex);
                crate::window::state_report::mark(ui.ctx(), name, Rect::from_center_size(at, vec2(2.0, 2.0)));
            }
        }
    }

    /// For the state report.
    pub fn refusal(&self) -> Option<&str> {
        self.refusal.as_ref().map(|(why, _)| why.as_str())
    }
}

/// Even-odd rule.
fn is_inside(outline: &[Pos2], p: Pos2) -> bool {
    let n = outline.len();
    (0..n)
        .filter(|&i| {
            let (a, b) = (outline[i], outline[(i + 1) % n]);
            (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
        })
        .count()
        % 2
        == 1
}

/// Do what a command says.
pub fn run(desk: &mut Desk, command: MeshCommand) {
    let mut tool = std::mem::take(&mut desk.tools.mesh);
    tool.run(desk, command);
    desk.tools.mesh = tool;
}
