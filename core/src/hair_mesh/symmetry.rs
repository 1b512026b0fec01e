//! The two sides of a hair mesh, left and right of the plane X = 0: which bundle and vertex answers which, and
//! rebuilding one side from the other.
//!
//! Bundles are paired by the places of their root faces' corners, and everything above by topology: so sides
//! stay paired however differently their hair was shaped.

use std::collections::HashMap;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::op::EdgeId;
use super::{Along, FaceCut, HairMesh, MeshOp, VertexId};

/// A side of the plane X = 0. The head looks along +Z, so its left side has positive X.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Side {
    PlusX,
    MinusX,
}

impl Side {
    pub(super) fn sign(self) -> f32 {
        match self {
            Self::PlusX => 1.0,
            Self::MinusX => -1.0,
        }
    }
}

/// Roots closer than this to their counterparts' mirror images are pairs, in centimetres, unless asked otherwise.
pub const MIRROR_TOLERANCE_CM: f32 = 0.2;

/// A place on the other side.
pub fn mirrored(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

/// A bundle's counterpart across X = 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Counterpart {
    pub bundle: usize,
    /// The counterpart's corner that answers this bundle's corner 0; from there the others run backwards.
    first: usize,
    n_corners: usize,
}

impl Counterpart {
    /// The counterpart's corner that answers corner `i`.
    pub fn corner(self, i: usize) -> usize {
        (self.first + self.n_corners - i % self.n_corners) % self.n_corners
    }
}

/// Which bundle answers which across X = 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MirrorPairs {
    /// Per bundle: its counterpart, which may be itself; `None` where there is none.
    pub bundles: Vec<Option<Counterpart>>,
    /// Per layer and vertex: its counterpart, which may be itself.
    pub vertices: Vec<Vec<Option<u32>>>,
}

impl MirrorPairs {
    /// Pair roots within `tolerance_cm`.
    pub fn of(mesh: &HairMesh, tolerance_cm: f32) -> Self {
        let n = mesh.n_bundles();
        let root = |bundle: usize| -> Vec<Vec3> {
            let corners = mesh.face(0, bundle).unwrap_or_default().iter();
            corners.map(|&v| mesh.layers[0].positions[v as usize]).collect()
        };
        let roots: Vec<Vec<Vec3>> = (0..n).map(root).collect();
        // Corners in cells as large as the tolerance: a counterpart's first corner is in a cell beside.
        let cell = tolerance_cm.max(1e-4);
        let cell_of = |p: Vec3| (p / cell).floor().as_ivec3();
        let mut corners_in: HashMap<glam::IVec3, Vec<(usize, usize)>> = HashMap::new();
        for (bundle, corners) in roots.iter().enumerate() {
            for (i, &p) in corners.iter().enumerate() {
                corners_in.entry(cell_of(p)).or_default().push((bundle, i));
            }
        }
        let pair = |bundle: usize| {
            let corners = &roots[bundle];
            let first = mirrored(*corners.first()?);
            let cells = (0..27).map(|i| cell_of(first) + glam::IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
            let candidates = cells.filter_map(|cell| corners_in.get(&cell)).flatten();
            let fit = |&(bundle, first): &(usize, usize)| {
                let theirs = &roots[bundle];
                let pair = Counterpart { bundle, first, n_corners: corners.len() };
                let far = |i: usize| mirrored(corners[i]).distance(theirs[pair.corner(i)]);
                let is_alike = theirs.len() == corners.len();
                let farthest = is_alike.then(|| (0..corners.len()).map(far).fold(0.0, f32::max))?;
                (farthest <= tolerance_cm).then_some((pair, farthest))
            };
            let best = candidates.filter_map(fit);
            best.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(pair, _)| pair)
        };
        let mut bundles: Vec<Option<Counterpart>> = (0..n).map(pair).collect();
        for bundle in 0..n {
            // Both must choose each other.
            if let Some(other) = bundles[bundle]
                && bundles[other.bundle].is_none_or(|back| back.bundle != bundle)
            {
                bundles[bundle] = None;
            }
        }
        let vertices = pair_vertices(mesh, &bundles);
        Self { bundles, vertices }
    }

    pub fn vertex(&self, VertexId { layer, vertex }: VertexId) -> Option<VertexId> {
        let vertex = (*self.vertices.get(layer)?.get(vertex as usize)?)?;
        Some(VertexId { layer, vertex })
    }

    pub fn edge(&self, edge: EdgeId) -> Option<EdgeId> {
        let [a, b] = edge.vertices().map(|id| self.vertex(id));
        Some(EdgeId::new(edge.layer, a?.vertex, b?.vertex))
    }

    pub fn bundle(&self, bundle: usize) -> Option<usize> {
        self.bundles.get(bundle)?.map(|other| other.bundle)
    }

    /// An operation together with its mirror image, to be applied one after the other as one edit. What
    /// has no counterpart is done on its own side.
    pub fn with_mirror(&self, op: &MeshOp) -> Vec<MeshOp> {
        let bundles = |list: &[usize]| both(list, |bundle| self.bundle(bundle));
        let vertices = |list: &[VertexId]| both(list, |id| self.vertex(id));
        let edges = |list: &[EdgeId]| both(list, |edge| self.edge(edge));
        let mut op = op.clone();
        match &mut op {
            MeshOp::Extrude { bundles: list, along, length_cm, n_layers, weld } => {
                let turned = match along {
                    Along::Normal | Along::Onward | Along::Gravity { .. } => None,
                    Along::Direction(way) => Some(Along::Direction(mirrored(*way))),
                    Along::Curve(points) => Some(Along::Curve(points.iter().map(|&p| mirrored(p)).collect())),
                };
                let Some(along) = turned else {
                    *list = bundles(list);
                    return vec![op];
                };
                let there: Vec<usize> =
                    list.iter().filter_map(|&b| self.bundle(b)).filter(|b| !list.contains(b)).collect();
                let (length_cm, n_layers, weld) = (*length_cm, *n_layers, *weld);
                let mut ops = vec![op];
                if !there.is_empty() {
                    ops.push(MeshOp::Extrude { bundles: there, along, length_cm, n_layers, weld });
                }
                return ops;
            }
            MeshOp::DeleteTips { bundles: list }
            | MeshOp::DeleteBundles { bundles: list }
            | MeshOp::InsertLayer { bundles: list, .. }
            | MeshOp::RemoveLayer { bundles: list, .. }
            | MeshOp::Subdivide { bundles: list, .. } => *list = bundles(list),
            MeshOp::SeparateVertices { vertices: list }
            | MeshOp::WeldVertices { vertices: list }
            | MeshOp::SetPinned { vertices: list, .. }
            | MeshOp::SmoothVertices { vertices: list, .. } => *list = vertices(list),
            MeshOp::SeparateEdges { edges: list } | MeshOp::WeldEdges { edges: list } => *list = edges(list),
            MeshOp::DivideFace { bundle, cut } => {
                let other = self.bundles.get(*bundle).copied().flatten().filter(|other| other.bundle != *bundle);
                let Some(other) = other else { return vec![op] };
                let cut = match *cut {
                    FaceCut::Corners(a, b) => FaceCut::Corners(other.corner(a), other.corner(b)),
                    FaceCut::Fan | FaceCut::Quads => *cut,
                };
                return vec![op, MeshOp::DivideFace { bundle: other.bundle, cut }];
            }
            MeshOp::DivideEdge { edge, at } => {
                let Some(other) = self.edge(*edge).filter(|other| other != edge) else { return vec![op] };
                // Ends are in the order of their numbers, which mirroring may turn.
                let turned = self.vertex(edge.vertices()[0]).is_some_and(|id| id.vertex != other.ends[0]);
                let at = if turned { 1.0 - *at } else { *at };
                return vec![op, MeshOp::DivideEdge { edge: other, at }];
            }
            MeshOp::Relax | MeshOp::Mirror { .. } => {}
        }
        vec![op]
    }
}

/// The list, and what answers it.
fn both<T: Copy + PartialEq>(list: &[T], counterpart: impl Fn(T) -> Option<T>) -> Vec<T> {
    let mut all = list.to_vec();
    for &one in list {
        all.extend(counterpart(one).filter(|other| !list.contains(other)));
    }
    all
}

/// Vertices answer each other where all bundles around them say so.
fn pair_vertices(mesh: &HairMesh, bundles: &[Option<Counterpart>]) -> Vec<Vec<Option<u32>>> {
    let of_layer = |layer: usize| {
        let n = mesh.layers[layer].positions.len();
        let mut pairs: Vec<Option<u32>> = vec![None; n];
        let mut is_disputed = vec![false; n];
        for (bundle, other) in bundles.iter().enumerate().filter_map(|(bundle, other)| Some((bundle, (*other)?))) {
            let (Some(face), Some(there)) = (mesh.face(layer, bundle), mesh.face(layer, other.bundle)) else {
                continue;
            };
            for (i, &v) in face.iter().enumerate() {
                let answer = there[other.corner(i)];
                is_disputed[v as usize] |= pairs[v as usize].is_some_and(|before| before != answer);
                pairs[v as usize] = Some(answer);
            }
        }
        for (pair, is_disputed) in pairs.iter_mut().zip(is_disputed) {
            if is_disputed {
                *pair = None;
            }
        }
        pairs
    };
    (0..mesh.layers.len()).map(of_layer).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Weld;
    use super::super::op_tests::straight_grid;
    use super::*;

    /// A grid whose middle line lies on X = 0; every second vertex away from it moved a little.
    fn grid() -> HairMesh {
        let mut mesh = straight_grid(4, 2);
        for layer in 0..3 {
            mesh.move_vertices(layer, |v, p| p - Vec3::X * 2.0 + Vec3::Z * 0.02 * (v % 2) as f32);
        }
        mesh
    }

    #[test]
    fn sides_are_paired_by_their_roots_and_stay_so_when_hair_is_shaped() {
        let mut mesh = grid();
        mesh.move_vertices(2, |_, p| p + Vec3::X * (3.0 + p.z * p.z));
        let pairs = MirrorPairs::of(&mesh, MIRROR_TOLERANCE_CM);
        for bundle in 0..16 {
            let (x, z) = (bundle % 4, bundle / 4);
            assert_eq!(pairs.bundle(bundle), Some(3 - x + 4 * z));
        }
        for (layer, vertex) in [(0, 6), (1, 12), (2, 6)] {
            let (x, z) = (vertex % 5, vertex / 5);
            let answer = Some(VertexId { layer, vertex: 4 - x + 5 * z });
            assert_eq!(pairs.vertex(VertexId { layer, vertex }), answer);
        }
        assert_eq!(pairs.edge(EdgeId::new(1, 5, 6)), Some(EdgeId::new(1, 8, 9)));
        mesh.layers[0].positions[0].x -= 1.0;
        assert_eq!(MirrorPairs::of(&mesh, MIRROR_TOLERANCE_CM).bundle(0), None);
    }

    #[test]
    fn an_operation_and_its_mirror_image_leave_the_mesh_symmetric() {
        let ops = [
            MeshOp::Extrude {
                bundles: vec![0, 4],
                along: Along::Direction(Vec3::new(1.0, 2.0, 0.0)),
                length_cm: 3.0,
                n_layers: 2,
                weld: Weld::Neighbours,
            },
            MeshOp::DivideFace { bundle: 5, cut: FaceCut::Corners(0, 2) },
            MeshOp::DivideEdge { edge: EdgeId::new(1, 5, 6), at: 0.2 },
            MeshOp::SeparateVertices { vertices: vec![VertexId { layer: 1, vertex: 6 }] },
            MeshOp::DeleteTips { bundles: vec![1] },
        ];
        for op in ops {
            let mut mesh = grid();
            let all = MirrorPairs::of(&mesh, MIRROR_TOLERANCE_CM).with_mirror(&op);
            for op in all {
                mesh.apply(&op).unwrap();
            }
            let pairs = MirrorPairs::of(&mesh, MIRROR_TOLERANCE_CM);
            for (layer, of_layer) in mesh.layers.iter().enumerate() {
                for (v, &p) in of_layer.positions.iter().enumerate() {
                    let answer = pairs.vertices[layer][v].unwrap_or_else(|| panic!("{op:?}: {v} of {layer}"));
                    assert!(mirrored(of_layer.positions[answer as usize]).distance(p) < 0.06, "{op:?}");
                }
            }
        }
    }
}
