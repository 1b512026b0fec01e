//! The hair mesh in the viewport: which of it is seen, how it is drawn, and what is under the pointer.

use std::sync::Arc;

use egui::{Color32, Mesh, Pos2, Shape, Stroke, Ui};
use glam::Vec3;
use lorelei_core::hair_mesh::{HairMesh, OuterSurface, VertexId};
use lorelei_core::mesh_query::MeshQuery;

use lorelei_core::hair_mesh::select::{FaceId, all_faces, corners};

use super::selection::{Element, MeshSelection, Picked};
use crate::window::theme;
use crate::window::tools::View;

/// How near the pointer a vertex or an edge is taken, in points.
const REACH: f32 = 10.0;
/// A vertex behind the surface by less than this still counts as on it, centimetres.
const ON_SURFACE: f32 = 0.06;

const FREE: Color32 = Color32::from_rgb(120, 170, 220);
const INNER: Color32 = Color32::from_rgb(200, 96, 88);
const PINNED: Color32 = Color32::from_rgb(150, 205, 130);
const SELECTED: Color32 = theme::ACCENT;

/// What is shown beside the outer surface, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Display {
    /// The vertices inside, which the studio places.
    pub shows_inside: bool,
    /// Draw and take what is behind, too.
    pub is_x_ray: bool,
    /// Of the cage's faces, 0-1.
    pub opacity: f32,
}

impl Default for Display {
    fn default() -> Self {
        Self { shows_inside: false, is_x_ray: false, opacity: 0.25 }
    }
}

/// The outer surface of one hair mesh, kept while the mesh is the same.
#[derive(Default)]
pub struct Cage {
    of: Option<Arc<HairMesh>>,
    pub outer: OuterSurface,
    query: Option<(MeshQuery, Vec<u32>)>,
    /// Outer vertices that nothing was before, when the mesh was last at rest, and from where that was seen.
    free: Vec<bool>,
    seen_from: Option<Vec3>,
}

/// Where everything is on the screen in this frame.
pub struct Seen {
    /// In the order of the cage's outer vertices: place, and whether nothing is before it.
    vertices: Vec<(Option<Pos2>, bool)>,
    /// The faces that are turned to the eye.
    front: Vec<bool>,
    /// Vertices inside, where they are shown.
    inside: Vec<(VertexId, Pos2)>,
}

impl Cage {
    /// Follow the mesh.
    pub fn update(&mut self, mesh: &Arc<HairMesh>) {
        if self.of.as_ref().is_some_and(|known| Arc::ptr_eq(known, mesh)) {
            return;
        }
        let is_same_topology = self.of.as_ref().is_some_and(|known| known.has_same_faces(mesh));
        if !is_same_topology {
            self.outer = OuterSurface::of(mesh);
            self.free.clear();
        }
        self.seen_from = None;
        self.query = self.outer.query(mesh);
        self.of = Some(Arc::clone(mesh));
    }

    fn position(&self, id: VertexId) -> Vec3 {
        self.of.as_ref().and_then(|mesh| mesh.position(id)).unwrap_or_default()
    }

    /// Project everything, and find what is hidden. While something moves, that is what was hidden before.
    pub fn look(&mut self, view: &View<'_>, display: Display, head: Option<&MeshQuery>, is_moving: bool) -> Seen {
        let Some(mesh) = &self.of else { return Seen { vertices: Vec::new(), front: Vec::new(), inside: Vec::new() } };
        let front: Vec<bool> = (0..self.outer.faces.len())
            .map(|face_idx| {
                let at = self.position(self.outer.faces[face_idx].corners[0]);
                self.outer.area_vector(mesh, face_idx).dot(view.eye - at) > 0.0
            })
            .collect();
        let is_known = self.free.len() == self.outer.vertices.len();
        if !is_known || (!is_moving && self.seen_from != Some(view.eye)) {
            self.free = self.free_vertices(view.eye, &front, head);
            self.seen_from = Some(view.eye);
        }
        let vertices = self.outer.vertices.iter().zip(&self.free);
        let vertices = vertices
            .map(|(&id, is_free)| (view.projection.point(self.position(id)), *is_free || display.is_x_ray))
            .collect();
        let mut inside = Vec::new();
        if display.shows_inside {
            for (layer, positions) in mesh.layers.iter().enumerate().skip(1) {
                for (vertex, &p) in positions.positions.iter().enumerate() {
                    let id = VertexId { layer, vertex: vertex as u32 };
                    if self.outer.vertices.binary_search(&id).is_err()
                        && let Some(at) = view.projection.point(p)
                    {
                        inside.push((id, at));
                    }
                }
            }
        }
        Seen { vertices, front, inside }
    }

    /// Which outer vertices are at the front, with nothing of the surface or the head before them.
    fn free_vertices(&self, eye: Vec3, front: &[bool], head: Option<&MeshQuery>) -> Vec<bool> {
        let mut is_at_front = vec![false; self.outer.vertices.len()];
        for (face, _) in self.outer.faces.iter().zip(front).filter(|(_, is_front)| **is_front) {
            for corner in &face.corners {
                if let Ok(at) = self.outer.vertices.binary_search(corner) {
                    is_at_front[at] = true;
                }
            }
        }
        let is_behind = |query: &MeshQuery, p: Vec3| {
            let away = p - eye;
            let distance = away.length();
            query.ray(eye, away / distance.max(1e-6)).is_some_and(|hit| hit.distance < distance - ON_SURFACE)
        };
        let is_free = |(&id, is_at_front): (&VertexId, bool)| {
            let p = self.position(id);
            // Roots lie on the head, chords of the head a little under it.
            let before_scalp = p + 0.1 * (eye - p).normalize_or_zero();
            is_at_front
                && !self.query.as_ref().is_some_and(|(query, _)| is_behind(query, p))
                && !head.is_some_and(|head| is_behind(head, before_scalp))
        };
        self.outer.vertices.iter().zip(is_at_front).map(is_free).collect()
    }

    fn at(&self, seen: &Seen, id: VertexId) -> Option<(Pos2, bool)> {
        let at = self.outer.vertices.binary_search(&id).ok()?;
        let (place, is_free) = *seen.vertices.get(at)?;
        Some((place?, is_free))
    }

    /// Draw the cage with its selection, and what the pointer would take.
    pub fn draw(&self, ui: &Ui, seen: &Seen, selection: &MeshSelection, display: Display, hovered: Option<Picked>) {
        let Some(mesh) = &self.of else { return };
        let painter = ui.painter();
        let mut faces = Mesh::default();
        for (face_idx, face) in self.outer.faces.iter().enumerate() {
            let id = FaceId { layer: face.layer, bundle: face.bundle };
            let is_selected = face.is_tip && selection.faces.contains(&id) && selection.element == Element::Faces;
            let is_hovered = hovered == Some(Picked::Face(id)) && face.is_tip;
            let is_free = || face.corners.iter().any(|&id| self.at(seen, id).is_some_and(|(_, is_free)| is_free));
            if !(display.is_x_ray || seen.front[face_idx] && is_free()) {
                continue;
            }
            let colour = match (is_selected, is_hovered) {
                (true, _) => SELECTED.gamma_multiply(0.45),
                (false, true) => Color32::WHITE.gamma_multiply(0.22),
                (false, false) => FREE.gamma_multiply(0.35 * display.opacity),
            };
            let places: Option<Vec<Pos2>> =
                face.corners.iter().map(|&id| self.at(seen, id).map(|(place, _)| place)).collect();
            let Some(places) = places else { continue };
            let first = faces.vertices.len() as u32;
            for place in &places {
                faces.colored_vertex(*place, colour);
            }
            for i in 1..places.len() as u32 - 1 {
                faces.add_triangle(first, first + i, first + i + 1);
            }
        }
        painter.add(Shape::mesh(faces));
        self.draw_inner_faces(ui, seen, mesh, selection);
        for edge in &self.outer.edges {
            let (Some((a, a_free)), Some((b, b_free))) = (self.at(seen, edge.ends[0]), self.at(seen, edge.ends[1]))
            else {
                continue;
            };
            let is_at_front = edge.faces.iter().any(|&face| seen.front[face as usize]);
            let is_seen = display.is_x_ray || (is_at_front && a_free && b_free);
            let is_selected = match selection.element {
                Element::Edges => selection.edges.contains(&edge.ends),
                Element::Vertices | Element::Faces => edge.ends.iter().all(|end| selection.vertices.contains(end)),
            };
            let is_hovered = hovered == Some(Picked::Edge(edge.ends));
            let (width, colour) = match (is_hovered, is_selected, is_seen) {
                (true, ..) => (2.4, Color32::WHITE),
                (false, true, _) => (1.8, SELECTED.gamma_multiply(if is_seen { 1.0 } else { 0.35 })),
                (false, false, true) => (1.0, FREE.gamma_multiply(if is_at_front { 0.75 } else { 0.25 })),
                (false, false, false) => continue,
            };
            painter.line_segment([a, b], Stroke::new(width, colour));
        }
        for (&id, (place, is_free)) in self.outer.vertices.iter().zip(&seen.vertices) {
            let Some(place) = place else { continue };
            let is_selected = selection.vertices.contains(&id);
            if !(*is_free || is_selected) {
                continue;
            }
            let is_hovered = hovered == Some(Picked::Vertex(id));
            let colour = match (is_selected, mesh.is_pinned(id)) {
                (true, _) if *is_free => SELECTED,
                (true, _) => SELECTED.gamma_multiply(0.3),
                (false, true) => PINNED,
                (false, false) => FREE,
            };
            let is_dot = selection.element == Element::Vertices || is_selected;
            let radius = if is_hovered {
                5.0
            } else if is_dot {
                3.0
            } else {
                1.5
            };
            if *is_free {
                painter.circle_filled(*place, radius + 1.0, Color32::from_black_alpha(140));
            }
            painter.circle_filled(*place, radius, if is_hovered { Color32::WHITE } else { colour });
        }
        for (id, place) in &seen.inside {
            let colour = match (selection.vertices.contains(id), mesh.is_pinned(*id)) {
                (true, _) => SELECTED,
                (false, true) => PINNED,
                (false, false) => INNER,
            };
            painter.circle_filled(*place, if hovered == Some(Picked::Vertex(*id)) { 4.5 } else { 2.5 }, colour);
        }
    }

    /// Selected faces that are not on the outside, as outlines.
    fn draw_inner_faces(&self, ui: &Ui, seen: &Seen, mesh: &HairMesh, selection: &MeshSelection) {
        for &face in selection.faces.iter().filter(|face| mesh.tip_layer(face.bundle) != Some(face.layer)) {
            let place = |id: VertexId| {
                let inside = || seen.inside.iter().find(|(inside, _)| *inside == id).map(|(_, place)| *place);
                self.at(seen, id).map(|(place, _)| place).or_else(inside)
            };
            let places: Option<Vec<Pos2>> = corners(mesh, face).map(place).collect();
            if let Some(places) = places {
                ui.painter().add(Shape::closed_line(places, Stroke::new(1.5, SELECTED.gamma_multiply(0.7))));
            }
        }
    }

    /// What is under a point of the window.
    pub fn pick(&self, view: &View<'_>, seen: &Seen, element: Element, at: Pos2) -> Option<Picked> {
        match element {
            Element::Vertices => {
                let outer = self.outer.vertices.iter().zip(&seen.vertices);
                let free = outer.filter_map(|(&id, (place, is_free))| place.filter(|_| *is_free).map(|p| (id, p)));
                let all = free.chain(seen.inside.iter().copied());
                nearest(all.map(|(id, place)| (place.distance(at), Picked::Vertex(id))))
            }
            Element::Edges => nearest(self.outer.edges.iter().filter_map(|edge| {
                let (a, a_free) = self.at(seen, edge.ends[0])?;
                let (b, b_free) = self.at(seen, edge.ends[1])?;
                (a_free || b_free).then(|| (from_segment(at, a, b), Picked::Edge(edge.ends)))
            })),
            Element::Faces => {
                let (query, face_of_triangle) = self.query.as_ref()?;
                let (origin, direction) = view.projection.ray(at);
                let hit = query.ray(origin, direction)?;
                let face = &self.outer.faces[face_of_triangle[hit.triangle_idx as usize] as usize];
                Some(Picked::Face(FaceId { layer: face.layer, bundle: face.bundle }))
            }
        }
    }

    /// Everything that lies in a part of the window: what `is_in` says of points.
    pub fn within(&self, seen: &Seen, element: Element, is_in: impl Fn(Pos2) -> bool) -> Vec<Picked> {
        let Some(mesh) = &self.of else { return Vec::new() };
        let outer = self.outer.vertices.iter().zip(&seen.vertices);
        let free = outer.filter_map(|(&id, (place, is_free))| place.filter(|_| *is_free).map(|place| (id, place)));
        let inside: Vec<(VertexId, Pos2)> =
            free.chain(seen.inside.iter().copied()).filter(|(_, p)| is_in(*p)).collect();
        let mut ids: Vec<VertexId> = inside.iter().map(|(id, _)| *id).collect();
        ids.sort_unstable();
        let has = |id: &VertexId| ids.binary_search(id).is_ok();
        match element {
            Element::Vertices => ids.iter().map(|&id| Picked::Vertex(id)).collect(),
            Element::Edges => {
                let edges = self.outer.edges.iter().filter(|edge| edge.ends.iter().all(has));
                edges.map(|edge| Picked::Edge(edge.ends)).collect()
            }
            Element::Faces => {
                let is_tip = |face: &FaceId| mesh.tip_layer(face.bundle) == Some(face.layer);
                let faces = all_faces(mesh).filter(is_tip).filter(|&face| corners(mesh, face).all(|id| has(&id)));
                faces.map(Picked::Face).collect()
            }
        }
    }

    /// Everything of the outer surface.
    pub fn everything(&self, element: Element) -> Vec<Picked> {
        match element {
            Element::Vertices => {
                self.outer.vertices.iter().filter(|id| id.layer > 0).map(|&id| Picked::Vertex(id)).collect()
            }
            Element::Edges => self.outer.edges.iter().map(|edge| Picked::Edge(edge.ends)).collect(),
            Element::Faces => {
                let tips = self.outer.faces.iter().filter(|face| face.is_tip);
                tips.map(|face| Picked::Face(FaceId { layer: face.layer, bundle: face.bundle })).collect()
            }
        }
    }

    /// Where on the outer surface a ray arrives.
    pub fn hit(&self, origin: Vec3, direction: Vec3) -> Option<(Vec3, Vec3)> {
        let (query, face_of_triangle) = self.query.as_ref()?;
        let hit = query.ray(origin, direction)?;
        let face_idx = face_of_triangle[hit.triangle_idx as usize] as usize;
        let mesh = self.of.as_ref()?;
        Some((hit.position, self.outer.area_vector(mesh, face_idx).normalize_or(Vec3::Y)))
    }

    /// Normals of the outer vertices, in their order.
    pub fn normals(&self) -> Vec<Vec3> {
        self.of.as_ref().map(|mesh| self.outer.normals(mesh)).unwrap_or_default()
    }
}

fn nearest(all: impl Iterator<Item = (f32, Picked)>) -> Option<Picked> {
    all.filter(|(distance, _)| *distance < REACH).min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, picked)| picked)
}

fn from_segment(p: Pos2, a: Pos2, b: Pos2) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_sq().max(1e-6)).clamp(0.0, 1.0);
    (a + t * along).distance(p)
}
