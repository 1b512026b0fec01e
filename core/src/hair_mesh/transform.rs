//! Moving, turning, scaling and sliding vertices of a hair mesh, softly if wanted, with what follows from it: the
//! head is not entered, roots stay on the scalp, and the inside is placed anew.
//!
//! A drag is always computed from where it began, so that it can go back and forth without wearing the mesh out.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{Quat, Vec3};

use super::{Accuracy, HairMesh, Relaxer, VertexId};
use crate::mesh_query::MeshQuery;

/// Vertices that follow a hand, from where they were.
#[derive(Debug, Clone)]
pub struct VertexDrag {
    start: Arc<HairMesh>,
    /// How much of the motion each vertex follows, 0-1.
    weights: Vec<(VertexId, f32)>,
    /// Where each weighted vertex's mirror image is; the same order.
    mirrors: Vec<Option<VertexId>>,
    /// The middle of what was selected.
    pub pivot: Vec3,
    /// The mesh as the drag has it now, from which the inside is placed, and what places it.
    now: HairMesh,
    relaxer: Option<Relaxer>,
}

/// What the hand does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VertexMotion {
    /// By centimetres.
    Move(Vec3),
    /// About an axis through the pivot.
    Rotate { axis: Vec3, angle: f32 },
    /// By factors along the axes, from the pivot.
    Scale(Vec3),
    /// Along its own hair, towards the tip, centimetres.
    Slide(f32),
    /// Out of the outer surface, along each vertex's own direction in the same order as the weights; centimetres.
    Extend(f32),
}

/// What keeps a drag within bounds.
#[derive(Clone, Copy, Default)]
pub struct Limits<'a> {
    /// Vertices stay out of this surface by `clearance`; roots lie on it.
    pub head: Option<&'a MeshQuery>,
    /// Centimetres.
    pub clearance: f32,
    /// Place the inside anew.
    pub relaxes: bool,
}

/// Vertices deeper in the head than this are not found to be in it, centimetres.
const DEEPEST: f32 = 4.0;

impl VertexDrag {
    /// Take hold of vertices. Those of `soft` follow by their share, 0-1 ([`super::select::soft_weights`]).
    pub fn new(
        start: &Arc<HairMesh>,
        selected: &[VertexId],
        soft: impl IntoIterator<Item = (VertexId, f32)>,
        mirror: impl Fn(VertexId) -> Option<VertexId>,
    ) -> Self {
        let held: Vec<(VertexId, Vec3)> = selected.iter().filter_map(|&id| Some((id, start.position(id)?))).collect();
        let pivot = held.iter().map(|(_, p)| *p).sum::<Vec3>() / held.len().max(1) as f32;
        let mut weights: Vec<(VertexId, f32)> = held.iter().map(|(id, _)| (*id, 1.0)).collect();
        let selected: HashSet<VertexId> = held.iter().map(|(id, _)| *id).collect();
        weights.extend(soft.into_iter().filter(|(id, _)| !selected.contains(id) && start.position(*id).is_some()));
        let followed: HashMap<VertexId, f32> = weights.iter().copied().collect();
        // A vertex whose image follows the hand more is led by that image.
        let mirrors = weights
            .iter()
            .map(|&(id, weight)| mirror(id).filter(|image| followed.get(image).is_none_or(|&other| other < weight)))
            .collect();
        Self { now: HairMesh::clone(start), start: Arc::clone(start), weights, mirrors, pivot, relaxer: None }
    }

    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// The vertices that follow, and how much.
    pub fn weights(&self) -> &[(VertexId, f32)] {
        &self.weights
    }

    /// The mesh where the drag began.
    pub fn start(&self) -> &Arc<HairMesh> {
        &self.start
    }

    /// Where the motion takes everything that it can move, moved or not: always the same vertices, in the same
    /// order, so that the steps of one drag overwrite each other. The inside is placed as well as a frame needs.
    pub fn places(&mut self, motion: VertexMotion, limits: Limits<'_>) -> Vec<(VertexId, Vec3)> {
        let held = self.held(motion, limits);
        self.placed(held, limits.relaxes, Accuracy::Drag)
    }

    /// As [`VertexDrag::places`], without what stays where it was, and the inside as exactly as can be.
    pub fn changes(&mut self, motion: VertexMotion, limits: Limits<'_>) -> Vec<(VertexId, Vec3)> {
        let held = self.held(motion, limits);
        self.changed(held, limits.relaxes)
    }

    /// Everything that is held onto the head, at `clearance`; roots exactly onto it.
    pub fn onto(&mut self, head: &MeshQuery, clearance: f32, relaxes: bool) -> Vec<(VertexId, Vec3)> {
        let limits = Limits { head: Some(head), clearance, relaxes };
        let onto_head = |&(id, _): &(VertexId, f32)| {
            let p = self.start.position(id)?;
            let nearest = head.closest(p).position;
            Some((id, limits.keep(id, nearest + 1e-3 * (p - nearest).normalize_or(Vec3::Y))))
        };
        let held = self.weights.iter().filter_map(onto_head).collect();
        self.changed(held, relaxes)
    }

    /// Where the hand takes what it holds, and the mirror images.
    fn held(&self, motion: VertexMotion, limits: Limits<'_>) -> Vec<(VertexId, Vec3)> {
        let mut held: Vec<(VertexId, Vec3)> = Vec::with_capacity(self.weights.len());
        for (&(id, weight), image) in self.weights.iter().zip(&self.mirrors) {
            let Some(p) = self.start.position(id) else { continue };
            let place = limits.keep(id, self.place(id, p, weight, motion));
            held.push((id, place));
            if let Some(image) = image {
                held.push((*image, limits.keep(*image, place * Vec3::new(-1.0, 1.0, 1.0))));
            }
        }
        held
    }

    fn changed(&mut self, held: Vec<(VertexId, Vec3)>, relaxes: bool) -> Vec<(VertexId, Vec3)> {
        let mut places = self.placed(held, relaxes, Accuracy::Full);
        places.retain(|(id, place)| self.start.position(*id) != Some(*place));
        places
    }

    fn placed(&mut self, held: Vec<(VertexId, Vec3)>, relaxes: bool, accuracy: Accuracy) -> Vec<(VertexId, Vec3)> {
        let mut places = held;
        for &(id, p) in &places {
            self.now.layers[id.layer].positions[id.vertex as usize] = p;
        }
        if !relaxes {
            return places;
        }
        let relaxer = self.relaxer.get_or_insert_with(|| {
            let mut fixed = self.start.fixed_vertices();
            for (id, _) in &places {
                fixed[id.layer][id.vertex as usize] = true;
            }
            Relaxer::with_fixed(&self.start, |layer, vertex| fixed[layer][vertex as usize])
        });
        relaxer.relax(&mut self.now, accuracy);
        places.extend(relaxer.free().filter_map(|id| Some((id, self.now.position(id)?))));
        places
    }

    fn place(&self, id: VertexId, p: Vec3, weight: f32, motion: VertexMotion) -> Vec3 {
        match motion {
            VertexMotion::Move(by) => p + weight * by,
            VertexMotion::Rotate { axis, angle } => {
                let turn = Quat::from_axis_angle(axis.normalize_or(Vec3::Y), weight * angle);
                self.pivot + turn * (p - self.pivot)
            }
            VertexMotion::Scale(factors) => {
                self.pivot + (Vec3::ONE + weight * (factors - Vec3::ONE)) * (p - self.pivot)
            }
            VertexMotion::Slide(by) => self.slid(id, p, weight * by),
            VertexMotion::Extend(by) => p + weight * by * self.direction(id),
        }
    }

    /// The way the hair goes where it reaches a vertex: from the vertex that it stands on. 0 at the root.
    fn direction(&self, id: VertexId) -> Vec3 {
        let Some(layer) = id.layer.checked_sub(1) else { return Vec3::ZERO };
        let below = self.start.layers[id.layer].faces.iter().zip(&self.start.layers[layer].faces).find_map(|pair| {
            let (Some(above), Some(below)) = pair else { return None };
            Some(below[above.iter().position(|&v| v == id.vertex)?])
        });
        let p = |layer: usize, vertex: u32| self.start.layers[layer].positions[vertex as usize];
        below.map_or(Vec3::ZERO, |below| (p(id.layer, id.vertex) - p(layer, below)).normalize_or_zero())
    }

    /// A place along the polyline of the hair through a vertex.
    fn slid(&self, id: VertexId, p: Vec3, by: f32) -> Vec3 {
        let chain = self.start.faces_at(id).next().map(|(bundle, corner)| {
            let points: Vec<Vec3> = self.start.corner_positions(bundle, corner).collect();
            points
        });
        let Some(points) = chain else { return p };
        let step: isize = if by > 0.0 { 1 } else { -1 };
        let (mut at, mut left, mut p) = (id.layer as isize, by.abs(), p);
        loop {
            let next = at + step;
            // The root stays the root, and past the tip the hair goes straight on.
            if next < 0 {
                return p;
            }
            let Some(&q) = points.get(next as usize) else {
                let last = points.len() - 1;
                let onward = if last > 0 { (points[last] - points[last - 1]).normalize_or_zero() } else { Vec3::ZERO };
                return p + left * onward;
            };
            let length = p.distance(q);
            if left < 0.9 * length || next == 0 {
                return p + (left / length.max(1e-6)).min(0.9) * (q - p);
            }
            (at, left, p) = (next, left - length, q);
        }
    }
}

impl Limits<'_> {
    /// A root on the scalp, anything else outside of the head.
    fn keep(&self, id: VertexId, p: Vec3) -> Vec3 {
        let Some(head) = self.head else { return p };
        if id.layer == 0 {
            return head.closest(p).position;
        }
        let Some(nearest) = head.closest_within(p, DEEPEST.max(self.clearance)) else { return p };
        let out = p - nearest.position;
        let is_inside = head.winding_number(p) > 0.5;
        if !is_inside && out.length() >= self.clearance {
            return p;
        }
        let away = if is_inside { -out } else { out };
        nearest.position + self.clearance.max(1e-3) * away.normalize_or(Vec3::Y)
    }
}

impl HairMesh {
    /// Outer vertices at places of their own, kept within limits, and where the inside is then. `relaxer` is the
    /// mesh's own ([`Relaxer::new`]).
    pub fn with_outer_at(
        &self,
        held: &[(VertexId, Vec3)],
        limits: Limits<'_>,
        relaxer: &Relaxer,
    ) -> Vec<(VertexId, Vec3)> {
        let mut places: Vec<(VertexId, Vec3)> = held.iter().map(|&(id, p)| (id, limits.keep(id, p))).collect();
        if limits.relaxes {
            let mut mesh = self.clone();
            for &(id, p) in &places {
                mesh.layers[id.layer].positions[id.vertex as usize] = p;
            }
            relaxer.relax(&mut mesh, Accuracy::Drag);
            places.extend(relaxer.free().filter_map(|id| Some((id, mesh.position(id)?))));
        }
        places
    }

    /// The middle of the vertices that share an edge with this one, in its layer, above and below; `None` without.
    pub fn middle_of_neighbours(&self, id: VertexId) -> Option<Vec3> {
        let mut neighbours: Vec<VertexId> = Vec::new();
        for (bundle, corner) in self.faces_at(id) {
            let face = self.face(id.layer, bundle)?;
            let n = face.len();
            let beside = [face[(corner + 1) % n], face[(corner + n - 1) % n]];
            neighbours.extend(beside.map(|vertex| VertexId { vertex, ..id }));
            for layer in [id.layer.wrapping_sub(1), id.layer + 1] {
                let vertex = self.face(layer, bundle).map(|face| face[corner]);
                neighbours.extend(vertex.map(|vertex| VertexId { layer, vertex }));
            }
        }
        neighbours.sort_unstable();
        neighbours.dedup();
        let sum: Vec3 = neighbours.iter().filter_map(|&id| self.position(id)).sum();
        (!neighbours.is_empty()).then(|| sum / neighbours.len() as f32)
    }

    /// The bundles and corners that a vertex is at.
    pub fn faces_at(&self, VertexId { layer, vertex }: VertexId) -> impl Iterator<Item = (usize, usize)> {
        let faces = self.layers.get(layer).map(|layer| layer.faces.as_slice()).unwrap_or_default();
        faces.iter().enumerate().filter_map(move |(bundle, face)| {
            let corner = face.as_ref()?.iter().position(|&v| v == vertex)?;
            Some((bundle, corner))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brush::Falloff;
    use crate::hair_mesh::select::{Links, Reach, soft_weights};
    use crate::hair_mesh::tests::straight_grid;
    use crate::mesh_query::tests::sphere;

    /// The vertex of a layer at a place over the ground.
    fn vertex(mesh: &HairMesh, layer: usize, x: f32, z: f32) -> VertexId {
        let is_there = |p: &Vec3| (p.x - x).abs() < 1e-4 && (p.z - z).abs() < 1e-4;
        let found = mesh.layers[layer].positions.iter().position(is_there).unwrap();
        VertexId { layer, vertex: found as u32 }
    }

    fn drag(soft_radius: Option<f32>) -> (Arc<HairMesh>, VertexDrag) {
        let mesh = Arc::new(straight_grid(3, 4));
        let selected = vertex(&mesh, 4, 1.0, 1.0);
        let soft = soft_radius.map(|radius| {
            let selected = std::collections::BTreeSet::from([selected]);
            soft_weights(&mesh, &Links::of(&mesh), &selected, radius, Falloff::Smooth, Reach::Straight)
        });
        let drag = VertexDrag::new(&mesh, &[selected], soft.into_iter().flatten(), |_| None);
        (mesh, drag)
    }

    fn after(mesh: &HairMesh, places: &[(VertexId, Vec3)], id: VertexId) -> Vec3 {
        places.iter().find(|(moved, _)| *moved == id).map_or(mesh.position(id).unwrap(), |(_, p)| *p)
    }

    #[test]
    fn a_hard_drag_moves_what_is_selected_and_a_soft_one_less_of_the_rest() {
        let (mesh, mut hard) = drag(None);
        let places = hard.places(VertexMotion::Move(Vec3::Y), Limits::default());
        let top = vertex(&mesh, 4, 1.0, 1.0);
        assert_eq!(places, [(top, mesh.position(top).unwrap() + Vec3::Y)]);
        let (mesh, mut soft) = drag(Some(2.0));
        let places = soft.places(VertexMotion::Move(Vec3::Y), Limits::default());
        let beside = vertex(&mesh, 4, 2.0, 1.0);
        assert!((after(&mesh, &places, beside).y - mesh.position(beside).unwrap().y - 0.5).abs() < 1e-6);
        assert!(places.iter().all(|(id, _)| id.layer > 0), "roots stay, none was selected");
        assert!(soft.changes(VertexMotion::Move(Vec3::ZERO), Limits::default()).is_empty());
    }

    #[test]
    fn turning_scaling_and_sliding_do_what_they_say() {
        let mesh = Arc::new(straight_grid(3, 4));
        let tips: Vec<VertexId> = (0..16).map(|vertex| VertexId { layer: 4, vertex }).collect();
        let mut drag = VertexDrag::new(&mesh, &tips, [], |_| None);
        assert_eq!(drag.pivot, Vec3::new(1.5, 4.0, 1.5));
        let motion = VertexMotion::Rotate { axis: Vec3::Y, angle: std::f32::consts::FRAC_PI_2 };
        let turned = drag.places(motion, Limits::default());
        assert!(after(&mesh, &turned, vertex(&mesh, 4, 0.0, 0.0)).distance(Vec3::new(0.0, 4.0, 3.0)) < 1e-5);
        let wide = drag.places(VertexMotion::Scale(Vec3::new(2.0, 1.0, 1.0)), Limits::default());
        assert!(after(&mesh, &wide, vertex(&mesh, 4, 0.0, 0.0)).distance(Vec3::new(-1.5, 4.0, 0.0)) < 1e-5);
        let down = drag.places(VertexMotion::Slide(-0.4), Limits::default());
        assert!(after(&mesh, &down, vertex(&mesh, 4, 0.0, 0.0)).distance(Vec3::new(0.0, 3.6, 0.0)) < 1e-5);
        let out = drag.places(VertexMotion::Slide(1.5), Limits::default());
        assert!(after(&mesh, &out, vertex(&mesh, 4, 0.0, 0.0)).distance(Vec3::new(0.0, 5.5, 0.0)) < 1e-5);
        let longer = drag.places(VertexMotion::Extend(2.0), Limits::default());
        assert!(after(&mesh, &longer, vertex(&mesh, 4, 3.0, 0.0)).distance(Vec3::new(3.0, 6.0, 0.0)) < 1e-5);
        let mut root = VertexDrag::new(&mesh, &[VertexId { layer: 1, vertex: 0 }], [], |_| None);
        let low = root.places(VertexMotion::Slide(-9.0), Limits::default());
        assert!(low[0].1.y > 0.05, "a layer does not slide into the root: {}", low[0].1);
    }

    #[test]
    fn mirror_images_follow_and_the_inside_is_placed_anew() {
        let mut mesh = straight_grid(4, 3);
        for layer in &mut mesh.layers {
            layer.positions.iter_mut().for_each(|p| p.x -= 2.0);
        }
        let mesh = Arc::new(mesh);
        let image = |id: VertexId| {
            let p = mesh.position(id)? * Vec3::new(-1.0, 1.0, 1.0);
            let at = mesh.layers[id.layer].positions.iter().position(|q| q.distance(p) < 1e-4)?;
            Some(VertexId { vertex: at as u32, ..id }).filter(|image| *image != id)
        };
        let wall: Vec<VertexId> = (1..4).map(|layer| vertex(&mesh, layer, -2.0, 1.0)).collect();
        let mut drag = VertexDrag::new(&mesh, &wall, [], image);
        let limits = Limits { relaxes: true, ..Limits::default() };
        let places = drag.places(VertexMotion::Move(Vec3::new(-1.0, 0.0, 0.0)), limits);
        let right = vertex(&mesh, 2, 2.0, 1.0);
        assert!(after(&mesh, &places, right).distance(Vec3::new(3.0, 2.0, 1.0)) < 1e-5);
        let inner = vertex(&mesh, 2, -1.0, 1.0);
        assert!(after(&mesh, &places, inner).distance(mesh.position(inner).unwrap()) > 1e-3, "the inside follows");
    }

    #[test]
    fn nothing_is_dragged_into_the_head_and_roots_stay_on_it() {
        let ball = MeshQuery::new(&sphere(Vec3::ZERO, 8.0, 32)).unwrap();
        let mut mesh = straight_grid(2, 2);
        for layer in &mut mesh.layers {
            layer.positions.iter_mut().for_each(|p| p.y += 8.0);
        }
        let mesh = Arc::new(mesh);
        let ids = [vertex(&mesh, 2, 1.0, 1.0), vertex(&mesh, 0, 1.0, 1.0)];
        let mut drag = VertexDrag::new(&mesh, &ids, [], |_| None);
        let limits = Limits { head: Some(&ball), clearance: 0.5, relaxes: false };
        for by in [Vec3::new(0.0, -3.0, 0.0), Vec3::new(2.0, -4.0, 1.0)] {
            let places = drag.places(VertexMotion::Move(by), limits);
            assert!((after(&mesh, &places, ids[0]).length() - 8.5).abs() < 0.1);
            assert!((after(&mesh, &places, ids[1]).length() - 8.0).abs() < 0.1);
        }
    }
}
