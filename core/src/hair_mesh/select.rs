//! Selecting in a hair mesh: what to take with what is already selected, and how much of it a move takes
//! along. Pure functions over plain sets; a tool keeps the sets.

use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use serde::{Deserialize, Serialize};

use super::work::edges;
use super::{EdgeId, HairMesh, VertexId};
use crate::brush::Falloff;
use crate::point_grid::PointGrid;

/// The face of a bundle in one of its layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct FaceId {
    pub layer: usize,
    pub bundle: usize,
}

/// How far a vertex is from the selected ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Reach {
    /// Straight through the air.
    #[default]
    Straight,
    /// Along edges and hair: what is close but not connected stays.
    Connected,
}

/// What touches what in a hair mesh, worked out once for many questions.
#[derive(Debug, Clone, Default)]
pub struct Links {
    /// Bundles of every edge within a layer.
    bundles_of: BTreeMap<EdgeId, Vec<usize>>,
    /// Per layer and vertex: the other ends of its edges; the vertex it stands on; those that stand on it.
    around: Vec<Vec<BTreeSet<u32>>>,
    below: Vec<Vec<Option<u32>>>,
    above: Vec<Vec<BTreeSet<u32>>>,
}

impl Links {
    pub fn of(mesh: &HairMesh) -> Self {
        let n_of = |layer: usize| mesh.layers[layer].positions.len();
        let n_layers = mesh.layers.len();
        let mut links = Self {
            bundles_of: BTreeMap::new(),
            around: (0..n_layers).map(|k| vec![BTreeSet::new(); n_of(k)]).collect(),
            below: (0..n_layers).map(|k| vec![None; n_of(k)]).collect(),
            above: (0..n_layers).map(|k| vec![BTreeSet::new(); n_of(k)]).collect(),
        };
        for layer in 0..n_layers {
            for bundle in 0..mesh.n_bundles() {
                let Some(face) = mesh.face(layer, bundle) else { continue };
                for [a, b] in edges(face) {
                    links.bundles_of.entry(EdgeId::new(layer, a, b)).or_default().push(bundle);
                    links.around[layer][a as usize].insert(b);
                    links.around[layer][b as usize].insert(a);
                }
                let Some(below) = layer.checked_sub(1).and_then(|below| mesh.face(below, bundle)) else { continue };
                for (&v, &on) in face.iter().zip(below) {
                    links.below[layer][v as usize] = Some(on);
                    links.above[layer - 1][on as usize].insert(v);
                }
            }
        }
        links
    }

    /// All edges within layers.
    pub fn edges(&self) -> impl Iterator<Item = EdgeId> {
        self.bundles_of.keys().copied()
    }

    /// The bundles that an edge is between: one at a border.
    pub fn bundles_of_edge(&self, edge: EdgeId) -> &[usize] {
        self.bundles_of.get(&edge).map_or(&[], Vec::as_slice)
    }

    /// The vertex of the layer below that a vertex stands on.
    pub fn below(&self, id: VertexId) -> Option<VertexId> {
        let vertex = (*self.below.get(id.layer)?.get(id.vertex as usize)?)?;
        Some(VertexId { layer: id.layer - 1, vertex })
    }

    /// The vertices that stand on a vertex.
    pub fn above(&self, id: VertexId) -> impl Iterator<Item = VertexId> {
        let above = self.above.get(id.layer).and_then(|layer| layer.get(id.vertex as usize));
        above.into_iter().flatten().map(move |&vertex| VertexId { layer: id.layer + 1, vertex })
    }

    /// The other ends of a vertex's edges within its layer.
    pub fn beside(&self, id: VertexId) -> impl Iterator<Item = VertexId> {
        let around = self.around.get(id.layer).and_then(|layer| layer.get(id.vertex as usize));
        around.into_iter().flatten().map(move |&vertex| VertexId { layer: id.layer, vertex })
    }

    /// Everything one step away: within the layer, below and above.
    pub fn next_to(&self, id: VertexId) -> impl Iterator<Item = VertexId> {
        self.beside(id).chain(self.below(id)).chain(self.above(id))
    }

    /// The selection and its neighbours within their layers.
    pub fn grow(&self, selected: &BTreeSet<VertexId>) -> BTreeSet<VertexId> {
        selected.iter().flat_map(|&id| self.beside(id).chain([id])).collect()
    }

    /// The selection without those that have an unselected neighbour in their layer.
    pub fn shrink(&self, selected: &BTreeSet<VertexId>) -> BTreeSet<VertexId> {
        let inside = |id: &VertexId| self.beside(*id).all(|beside| selected.contains(&beside));
        selected.iter().copied().filter(inside).collect()
    }

    /// Everything that can be reached from the selection, within layers and from layer to layer.
    pub fn linked(&self, selected: &BTreeSet<VertexId>) -> BTreeSet<VertexId> {
        let mut linked = BTreeSet::new();
        let mut open: Vec<VertexId> = selected.iter().copied().collect();
        while let Some(id) = open.pop() {
            if linked.insert(id) {
                open.extend(self.next_to(id).filter(|next| !linked.contains(next)));
            }
        }
        linked
    }

    /// The hair that passes a vertex, from its root to all tips above it: the loop across layers.
    pub fn chain(&self, id: VertexId) -> BTreeSet<VertexId> {
        let mut chain: BTreeSet<VertexId> = std::iter::successors(Some(id), |&id| self.below(id)).collect();
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            open.extend(self.above(id));
            chain.insert(id);
        }
        chain
    }

    /// The edges that go on straight from an edge, within its layer, with itself: through vertices of four
    /// edges, or along the border.
    pub fn edge_loop(&self, edge: EdgeId) -> BTreeSet<EdgeId> {
        let mut of_loop = BTreeSet::new();
        if !self.bundles_of.contains_key(&edge) {
            return of_loop;
        }
        of_loop.insert(edge);
        for end in edge.ends {
            let (mut at, mut edge) = (end, edge);
            while let Some(next) = self.straight_on(edge, at) {
                if !of_loop.insert(next) {
                    break;
                }
                at = if next.ends[0] == at { next.ends[1] } else { next.ends[0] };
                edge = next;
            }
        }
        of_loop
    }

    fn straight_on(&self, edge: EdgeId, at: u32) -> Option<EdgeId> {
        let bundles = self.bundles_of_edge(edge);
        let around = &self.around[edge.layer][at as usize];
        let others = around.iter().map(|&end| EdgeId::new(edge.layer, at, end)).filter(|other| *other != edge);
        let is_border = bundles.len() == 1;
        let mut on: Vec<EdgeId> = others
            .filter(|other| {
                let of_other = self.bundles_of_edge(*other);
                // Along the border, or across a vertex of four edges to the one that shares no face.
                if is_border { of_other.len() == 1 } else { of_other.iter().all(|bundle| !bundles.contains(bundle)) }
            })
            .collect();
        let goes_on = on.len() == 1 && (is_border || around.len() == 4);
        if goes_on { on.pop() } else { None }
    }

    /// The edges opposite to an edge, from face to face with an even number of corners, with itself.
    pub fn edge_ring(&self, mesh: &HairMesh, edge: EdgeId) -> BTreeSet<EdgeId> {
        let mut ring = BTreeSet::new();
        let mut open = vec![edge];
        while let Some(edge) = open.pop() {
            if !self.bundles_of.contains_key(&edge) || !ring.insert(edge) {
                continue;
            }
            for &bundle in self.bundles_of_edge(edge) {
                let Some(face) = mesh.face(edge.layer, bundle).filter(|face| face.len() % 2 == 0) else { continue };
                let at = edges(face).position(|[a, b]| EdgeId::new(edge.layer, a, b) == edge);
                let opposite = at.map(|at| (at + face.len() / 2) % face.len());
                open.extend(opposite.map(|i| EdgeId::new(edge.layer, face[i], face[(i + 1) % face.len()])));
            }
        }
        ring
    }

    /// The edges that have both ends selected.
    pub fn edges_within(&self, selected: &BTreeSet<VertexId>) -> BTreeSet<EdgeId> {
        self.edges().filter(|edge| edge.vertices().iter().all(|id| selected.contains(id))).collect()
    }
}

/// All faces of some bundles.
pub fn faces_of_bundles(mesh: &HairMesh, bundles: &BTreeSet<usize>) -> BTreeSet<FaceId> {
    let layers = |&bundle: &usize| (0..mesh.layers.len()).map(move |layer| FaceId { layer, bundle });
    bundles.iter().flat_map(layers).filter(|face| mesh.face(face.layer, face.bundle).is_some()).collect()
}

/// All faces of a layer.
pub fn faces_of_layer(mesh: &HairMesh, layer: usize) -> BTreeSet<FaceId> {
    let faces = (0..mesh.n_bundles()).map(|bundle| FaceId { layer, bundle });
    faces.filter(|face| mesh.face(face.layer, face.bundle).is_some()).collect()
}

/// The faces and those that share a vertex with them in their layer.
pub fn grow_faces(mesh: &HairMesh, selected: &BTreeSet<FaceId>) -> BTreeSet<FaceId> {
    let vertices = vertices_of_faces(mesh, selected);
    let touches = |face: &FaceId| {
        let corners = mesh.face(face.layer, face.bundle).unwrap_or_default();
        corners.iter().any(|&vertex| vertices.contains(&VertexId { layer: face.layer, vertex }))
    };
    all_faces(mesh).filter(touches).collect()
}

/// The faces without those that share a vertex with an unselected one.
pub fn shrink_faces(mesh: &HairMesh, selected: &BTreeSet<FaceId>) -> BTreeSet<FaceId> {
    let rest: BTreeSet<FaceId> = all_faces(mesh).filter(|face| !selected.contains(face)).collect();
    selected.difference(&grow_faces(mesh, &rest)).copied().collect()
}

/// The faces that have all corners selected.
pub fn faces_within(mesh: &HairMesh, selected: &BTreeSet<VertexId>) -> BTreeSet<FaceId> {
    let inside = |&FaceId { layer, bundle }: &FaceId| {
        let corners = mesh.face(layer, bundle).unwrap_or_default();
        corners.iter().all(|&vertex| selected.contains(&VertexId { layer, vertex }))
    };
    all_faces(mesh).filter(inside).collect()
}

/// The corners of faces.
pub fn vertices_of_faces(mesh: &HairMesh, faces: &BTreeSet<FaceId>) -> BTreeSet<VertexId> {
    faces.iter().flat_map(|&face| corners(mesh, face)).collect()
}

/// The corners of a face; none where there is no such face.
pub fn corners(mesh: &HairMesh, face: FaceId) -> impl Iterator<Item = VertexId> {
    let layer = face.layer;
    let corners = mesh.face(layer, face.bundle).unwrap_or_default();
    corners.iter().map(move |&vertex| VertexId { layer, vertex })
}

/// Every face of every layer.
pub fn all_faces(mesh: &HairMesh) -> impl Iterator<Item = FaceId> {
    let faces = (0..mesh.layers.len()).flat_map(|layer| (0..mesh.n_bundles()).map(move |bundle| (layer, bundle)));
    faces.map(|(layer, bundle)| FaceId { layer, bundle }).filter(|f| mesh.face(f.layer, f.bundle).is_some())
}

/// How much of a move each vertex takes (0-1): the selected ones all of it, others by their distance in
/// centimetres; those beyond `radius` are not named. The root layer follows only where some of it is selected.
pub fn soft_weights(
    mesh: &HairMesh,
    links: &Links,
    selected: &BTreeSet<VertexId>,
    radius: f32,
    falloff: Falloff,
    reach: Reach,
) -> BTreeMap<VertexId, f32> {
    let distances = match reach {
        Reach::Straight => straight_distances(mesh, selected, radius),
        Reach::Connected => connected_distances(mesh, links, selected, radius),
    };
    let moves_roots = selected.iter().any(|id| id.layer == 0);
    let weight = |(id, distance): (VertexId, f32)| {
        let weight = if selected.contains(&id) { 1.0 } else { falloff.at(distance / radius.max(f32::MIN_POSITIVE)) };
        (weight > 0.0 && (id.layer > 0 || moves_roots)).then_some((id, weight))
    };
    distances.into_iter().filter_map(weight).collect()
}

fn straight_distances(mesh: &HairMesh, selected: &BTreeSet<VertexId>, radius: f32) -> BTreeMap<VertexId, f32> {
    let mut distances: BTreeMap<VertexId, f32> = BTreeMap::new();
    let points: Vec<glam::Vec3> = selected.iter().filter_map(|&id| mesh.position(id)).collect();
    if points.is_empty() {
        return distances;
    }
    let grid = PointGrid::new(&points, radius.max(0.1));
    for (layer, of_layer) in mesh.layers.iter().enumerate() {
        for (vertex, &p) in of_layer.positions.iter().enumerate() {
            let ([(_, squared)], n_found) = grid.nearest::<1>(p);
            if n_found > 0 && squared < radius * radius {
                distances.insert(VertexId { layer, vertex: vertex as u32 }, squared.sqrt());
            }
        }
    }
    distances.extend(selected.iter().filter(|id| mesh.position(**id).is_some()).map(|&id| (id, 0.0)));
    distances
}

/// Dijkstra 1959, from all selected vertices at once.
fn connected_distances(
    mesh: &HairMesh,
    links: &Links,
    selected: &BTreeSet<VertexId>,
    radius: f32,
) -> BTreeMap<VertexId, f32> {
    let mut distances: BTreeMap<VertexId, f32> = BTreeMap::new();
    // Bits of a non-negative number rise with it; the heap gives the largest first.
    let mut open: BinaryHeap<(std::cmp::Reverse<u32>, VertexId)> =
        selected.iter().map(|&id| (std::cmp::Reverse(0), id)).collect();
    while let Some((std::cmp::Reverse(bits), id)) = open.pop() {
        let (distance, Some(p)) = (f32::from_bits(bits), mesh.position(id)) else { continue };
        if distances.contains_key(&id) {
            continue;
        }
        distances.insert(id, distance);
        for next in links.next_to(id).filter(|next| !distances.contains_key(next)) {
            let further = distance + mesh.position(next).map_or(f32::INFINITY, |q| q.distance(p));
            if further < radius {
                open.push((std::cmp::Reverse(further.to_bits()), next));
            }
        }
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::super::MeshOp;
    use super::super::op_tests::straight_grid;
    use super::*;

    fn id(layer: usize, vertex: u32) -> VertexId {
        VertexId { layer, vertex }
    }

    #[test]
    fn growing_and_shrinking_stay_in_the_layer_and_undo_each_other_inside() {
        let mesh = straight_grid(4, 2);
        let links = Links::of(&mesh);
        let one = BTreeSet::from([id(1, 12)]);
        let five = links.grow(&one);
        assert_eq!(five, BTreeSet::from([7, 11, 12, 13, 17].map(|v| id(1, v))));
        assert_eq!(links.shrink(&five), one);
        assert_eq!(links.linked(&one).len(), 75);
        assert_eq!(links.chain(id(1, 12)), BTreeSet::from([0, 1, 2].map(|k| id(k, 12))));
    }

    #[test]
    fn loops_go_straight_on_and_rings_across() {
        let mesh = straight_grid(4, 1);
        let links = Links::of(&mesh);
        let row = links.edge_loop(EdgeId::new(1, 11, 12));
        assert_eq!(row, BTreeSet::from([10, 11, 12, 13].map(|v| EdgeId::new(1, v, v + 1))));
        let ring = links.edge_ring(&mesh, EdgeId::new(1, 11, 12));
        assert_eq!(ring, BTreeSet::from([1, 6, 11, 16, 21].map(|v| EdgeId::new(1, v, v + 1))));
        // The border's loop goes all around.
        assert_eq!(links.edge_loop(EdgeId::new(1, 0, 1)).len(), 16);
        assert_eq!(links.edges_within(&BTreeSet::from([id(1, 0), id(1, 1), id(0, 1)])).len(), 1);
    }

    #[test]
    fn what_is_separated_is_not_linked() {
        let mut mesh = straight_grid(2, 1);
        mesh.apply(&MeshOp::DeleteBundles { bundles: vec![0, 3] }).unwrap();
        mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(1, 3)] }).unwrap();
        let links = Links::of(&mesh);
        // The roots still hold together.
        assert_eq!(links.linked(&BTreeSet::from([id(1, 0)])).len(), mesh.n_vertices());
        let faces = BTreeSet::from([FaceId { layer: 1, bundle: 1 }]);
        assert_eq!(grow_faces(&mesh, &faces), faces);
        let roots = BTreeSet::from([FaceId { layer: 0, bundle: 1 }]);
        assert_eq!(grow_faces(&mesh, &roots).len(), 2);
        assert_eq!(shrink_faces(&mesh, &faces_of_layer(&mesh, 0)).len(), 2);
        assert_eq!(faces_of_bundles(&mesh, &BTreeSet::from([0, 1])).len(), 2);
        assert_eq!(faces_within(&mesh, &vertices_of_faces(&mesh, &faces)), faces);
    }

    #[test]
    fn soft_selection_falls_off_through_the_air_or_along_the_mesh() {
        let mut mesh = straight_grid(4, 1);
        let middle = BTreeSet::from([id(1, 12)]);
        let links = Links::of(&mesh);
        let of =
            |mesh: &HairMesh, links: &Links, reach| soft_weights(mesh, links, &middle, 1.8, Falloff::Linear, reach);
        let straight = of(&mesh, &links, Reach::Straight);
        assert_eq!((straight[&id(1, 12)], straight.len()), (1.0, 9));
        assert!((straight[&id(1, 13)] - (1.0 - 1.0 / 1.8)).abs() < 1e-6);
        assert!((straight[&id(1, 6)] - (1.0 - 2.0_f32.sqrt() / 1.8)).abs() < 1e-6);
        assert_eq!(of(&mesh, &links, Reach::Connected).len(), 5, "a diagonal is two edges long");
        let line = (0..5).map(|k| id(1, 5 * k + 3)).collect();
        mesh.apply(&MeshOp::SeparateVertices { vertices: line }).unwrap();
        let links = Links::of(&mesh);
        assert!(of(&mesh, &links, Reach::Straight).len() > of(&mesh, &links, Reach::Connected).len());
    }
}
