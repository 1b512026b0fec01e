//! The brush on the outer surface of the hair mesh: a drag pushes it out, with Ctrl in, with Shift smooths it.
//!
//! A stroke is one step. Its strength is by centimetres of the pointer's way, so that it does not depend on how many
//! events the way came in.

use std::sync::Arc;

use egui::{Color32, Ui};
use glam::Vec3;
use lorelei_core::edit::Edit;
use lorelei_core::hair_mesh::{HairMesh, Relaxer, VertexId};
use lorelei_core::history::Merge;

use super::MeshTool;
use super::ops::DRAGS;
use crate::window::desk::Desk;
use crate::window::tools::{View, brush_input};

/// A stroke that is being drawn.
#[derive(Default)]
pub struct PushStroke {
    last: Option<Vec3>,
    /// Of the mesh that was pushed last.
    relaxer: Option<Relaxer>,
}

impl PushStroke {
    pub fn is_drawn(&self) -> bool {
        self.last.is_some()
    }
}

/// Centimetres that the surface moves for each centimetre of a stroke at full strength.
const PUSH_PER_CM: f32 = 0.35;

impl MeshTool {
    /// True while a stroke is drawn.
    pub(super) fn push_brush(
        &mut self,
        ui: &Ui,
        desk: &mut Desk,
        view: &View<'_>,
        layer_idx: usize,
        mesh: &Arc<HairMesh>,
    ) -> bool {
        let is_setting = brush_input::adjust(ui, view, &mut self.settings.push);
        let is_down = view.response.dragged_by(egui::PointerButton::Primary) && !is_setting && !view.is_navigating;
        if !is_down {
            self.push.last = None;
        }
        let Some(at) = view.pointer(ui) else { return is_setting };
        let (origin, direction) = view.projection.ray(at);
        let hit = self.cage.hit(origin, direction);
        let brush = self.settings.push.under_pressure(brush_input::pressure(ui));
        brush_input::ring(ui, view, &brush, at, hit, Color32::WHITE);
        let Some((place, _)) = hit.filter(|_| is_down) else { return is_setting };
        let Some(last) = self.push.last.replace(place) else {
            self.n_grabs += 1;
            return true;
        };
        let way = last.distance(place);
        if way < 1e-3 {
            return true;
        }
        let modifiers = ui.input(|input| input.modifiers);
        let sign = if modifiers.command { -1.0 } else { 1.0 };
        let normals = self.cage.normals();
        let reach = |p: Vec3| {
            let middle = last.lerp(place, ((p - last).dot(place - last) / (way * way)).clamp(0.0, 1.0));
            brush.strength * brush.falloff.at(p.distance(middle) / brush.radius_cm)
        };
        let mut held: Vec<(VertexId, Vec3)> = Vec::new();
        for (&id, &normal) in self.cage.outer.vertices.iter().zip(&normals) {
            let Some(p) = mesh.position(id).filter(|_| id.layer > 0) else { continue };
            let weight = reach(p);
            if weight <= 0.0 {
                continue;
            }
            let to = if modifiers.shift {
                let share = (weight * way).min(0.9);
                p.lerp(mesh.middle_of_neighbours(id).unwrap_or(p), share)
            } else {
                p + sign * PUSH_PER_CM * weight * way * normal
            };
            held.push((id, to));
        }
        if held.is_empty() {
            return true;
        }
        let relaxer = self.push.relaxer.take().filter(|known| known.fits(mesh)).unwrap_or_else(|| Relaxer::new(mesh));
        let mut moves = mesh.with_outer_at(&held, self.limits(), &relaxer);
        // The steps of a stroke join where each writes what the others wrote: all of the surface, moved or not.
        let still = self.cage.outer.vertices.iter().filter(|id| id.layer > 0);
        let still: Vec<VertexId> = still.copied().filter(|id| held.iter().all(|(touched, _)| touched != id)).collect();
        moves.extend(still.into_iter().filter_map(|id| Some((id, mesh.position(id)?))));
        moves.sort_unstable_by_key(|(id, _)| *id);
        self.push.relaxer = Some(relaxer);
        let label = if modifiers.shift { "Smooth brush" } else { "Push brush" };
        desk.document.edit(label, Edit::MoveVertices { layer_idx, moves }, Merge::Drag(DRAGS + self.n_grabs));
        true
    }
}
