//! Hair meshes: layers of polygons over the scalp through which strands are traced (Yuksel, Schaefer
//! and Keyser 2009).
//!
//! Face `j` of layer `k` stands on face `j` of layer `k - 1`, corner on corner; so a bundle is an index,
//! and the one-to-many mapping of vertices follows from the corners. Storing prisms was rejected: they
//! would repeat what the index already says.
//!
//! What [`HairMesh::check`] demands:
//! - every layer has a place for every bundle; a bundle that has a face in a layer has one in all below;
//! - a face has at least three different corners, as many as the bundle's face in layer 0;
//! - a vertex stands on one vertex of the layer below, whichever face one asks (one-to-many, paper 3.1);
//! - indices are in range, positions finite, and pinned vertices listed once, in rising order.
//!
//! A bundle without a face in layer 0 is a deleted one: no hair grows there, and no other index moves.

mod divide;
mod error;
mod extrude;
mod fit;
mod layers;
mod mirror;
mod op;
#[cfg(test)]
mod op_tests;
mod outer;
mod relax;
pub mod scalp;
pub mod select;
mod separate;
mod smooth;
mod subdivide;
pub mod symmetry;
mod transform;
mod weld;
mod work;

use glam::Vec3;
use serde::{Deserialize, Serialize};

pub use error::HairMeshError;
pub use extrude::{Along, Extruded, Weld};
pub use op::{EdgeId, FaceCut, MeshOp, NewVertex, Report, Scheme, VertexId};
pub use outer::{OuterEdge, OuterFace, OuterSurface};
pub use relax::{Accuracy, Relaxed, Relaxer};
pub use transform::{Limits, VertexDrag, VertexMotion};

/// Layers over a root layer. Layer 0 lies on the scalp.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HairMesh {
    pub layers: Vec<HairMeshLayer>,
}

/// One layer of polygons. Positions in head space, centimetres.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HairMeshLayer {
    pub positions: Vec<Vec3>,
    /// Face of each bundle: at least three corners, as many as the bundle has in layer 0; `None` above
    /// the bundle's tip.
    pub faces: Vec<Option<Vec<u32>>>,
    /// Vertices that stay where they are when the inside is relaxed: rising indices.
    #[serde(default)]
    pub pinned: Vec<u32>,
}

/// The guide curves of a hair mesh: chains of vertices from layer to layer, each once however many
/// faces share it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chains {
    /// Vertex index in each layer, root first; as long as the bundle has layers.
    pub chains: Vec<Vec<u32>>,
    /// Per bundle and corner: index into `chains`; empty for a deleted bundle.
    pub of_bundle: Vec<Vec<u32>>,
}

impl HairMesh {
    /// A hair mesh of only a root layer.
    pub fn from_polygons(positions: Vec<Vec3>, faces: Vec<Vec<u32>>) -> Result<Self, HairMeshError> {
        let faces = faces.into_iter().map(Some).collect();
        let mesh = Self { layers: vec![HairMeshLayer { positions, faces, pinned: Vec::new() }] };
        mesh.check()?;
        Ok(mesh)
    }

    /// Places for bundles, deleted ones included.
    pub fn n_bundles(&self) -> usize {
        self.layers.first().map_or(0, |root| root.faces.len())
    }

    pub fn n_vertices(&self) -> usize {
        self.layers.iter().map(|layer| layer.positions.len()).sum()
    }

    pub fn face(&self, layer: usize, bundle: usize) -> Option<&[u32]> {
        self.layers.get(layer)?.faces.get(bundle)?.as_deref()
    }

    /// The bundle's topmost layer (n_j of the paper); `None` for a deleted bundle.
    pub fn tip_layer(&self, bundle: usize) -> Option<usize> {
        (0..self.layers.len()).take_while(|&layer| self.face(layer, bundle).is_some()).last()
    }

    /// Positions of a bundle's corner in every layer, root first.
    pub fn corner_positions(&self, bundle: usize, corner: usize) -> impl Iterator<Item = Vec3> {
        self.layers.iter().map_while(move |layer| {
            let face = layer.faces.get(bundle)?.as_deref()?;
            Some(layer.positions[face[corner] as usize])
        })
    }

    /// Whether `other` has the same faces, wherever its vertices are.
    pub fn has_same_faces(&self, other: &Self) -> bool {
        self.layers.len() == other.layers.len()
            && self
                .layers
                .iter()
                .zip(&other.layers)
                .all(|(a, b)| a.faces == b.faces && a.positions.len() == b.positions.len())
    }

    /// Whether `other` has the same faces and the same root layer: the same strands grow on it, along other paths.
    pub fn differs_in_shape_only(&self, other: &Self) -> bool {
        self.has_same_faces(other)
            && self.layers.first().map(|root| &root.positions) == other.layers.first().map(|root| &root.positions)
    }

    /// Whether `other` has the same root layer, with hair on the same of its faces: the same strands grow on it,
    /// whatever the layers above are.
    pub fn grows_the_same_strands(&self, other: &Self) -> bool {
        let (Some(a), Some(b)) = (self.layers.first(), other.layers.first()) else { return false };
        let has_hair = |mesh: &Self, bundle: usize| mesh.face(1, bundle).is_some();
        a.positions == b.positions
            && a.faces == b.faces
            && (0..a.faces.len()).all(|bundle| has_hair(self, bundle) == has_hair(other, bundle))
    }

    /// Smallest box around all vertices as (min, max); `None` where there are none.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut all = self.layers.iter().flat_map(|layer| layer.positions.iter().copied());
        let first = all.next()?;
        Some(all.fold((first, first), |(lo, hi), p| (lo.min(p), hi.max(p))))
    }

    /// Check every invariant that the file's head states.
    pub fn check(&self) -> Result<(), HairMeshError> {
        let n_bundles = self.n_bundles();
        for (layer, HairMeshLayer { positions, faces, pinned }) in self.layers.iter().enumerate() {
            if faces.len() != n_bundles {
                return Err(HairMeshError::BundleCount { layer, found: faces.len(), expected: n_bundles });
            }
            if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
                return Err(HairMeshError::NotFinite { layer, vertex: vertex as u32 });
            }
            if let Some(&vertex) = pinned.iter().find(|&&v| v as usize >= positions.len()) {
                return Err(HairMeshError::NoVertex { layer, vertex });
            }
            if !pinned.is_sorted_by(|a, b| a < b) {
                return Err(HairMeshError::PinnedOrder { layer });
            }
            let mut parent = vec![u32::MAX; positions.len()];
            for (bundle, face) in faces.iter().enumerate().filter_map(|(bundle, face)| Some((bundle, face.as_ref()?))) {
                if let Some(&vertex) = face.iter().find(|&&v| v as usize >= positions.len()) {
                    return Err(HairMeshError::Index { layer, bundle, vertex });
                }
                let repeats = (1..face.len()).any(|i| face[..i].contains(&face[i]));
                if face.len() < 3 || repeats {
                    return Err(HairMeshError::Degenerate { layer, bundle });
                }
                if layer == 0 {
                    continue;
                }
                let Some(below) = self.face(layer - 1, bundle) else {
                    return Err(HairMeshError::Gap { layer, bundle });
                };
                if below.len() != face.len() {
                    let (found, expected) = (face.len(), below.len());
                    return Err(HairMeshError::CornerCount { layer, bundle, found, expected });
                }
                for (&vertex, &on) in face.iter().zip(below) {
                    let known = &mut parent[vertex as usize];
                    if *known != u32::MAX && *known != on {
                        return Err(HairMeshError::ManyToOne { layer, vertex });
                    }
                    *known = on;
                }
            }
        }
        Ok(())
    }

    /// Move vertices of one layer: `place` gets index and position.
    pub fn move_vertices(&mut self, layer: usize, mut place: impl FnMut(u32, Vec3) -> Vec3) {
        for (vertex, position) in self.layers[layer].positions.iter_mut().enumerate() {
            *position = place(vertex as u32, *position);
        }
    }

    /// The chains of vertices at the corners of all bundles. Neighbours share a chain where they share
    /// all its vertices.
    pub fn chains(&self) -> Chains {
        use std::collections::HashMap;
        let mut result = Chains::default();
        let mut index_of: HashMap<Vec<u32>, u32> = HashMap::new();
        for bundle in 0..self.n_bundles() {
            let n_corners = self.face(0, bundle).map_or(0, <[u32]>::len);
            let corners = (0..n_corners).map(|corner| {
                let chain: Vec<u32> =
                    (0..self.layers.len()).map_while(|layer| Some(self.face(layer, bundle)?[corner])).collect();
                *index_of.entry(chain).or_insert_with_key(|chain| {
                    result.chains.push(chain.clone());
                    result.chains.len() as u32 - 1
                })
            });
            let corners: Vec<u32> = corners.collect();
            result.of_bundle.push(corners);
        }
        result
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::HairMeshError as E;
    use super::*;

    /// A grid of `n` x `n` unit quads at y = 0, with `n_layers` more straight above, one apart.
    pub(crate) fn straight_grid(n: u32, n_layers: usize) -> HairMesh {
        let side = n + 1;
        let positions = (0..side * side).map(|i| Vec3::new((i % side) as f32, 0.0, (i / side) as f32)).collect();
        let faces = (0..n * n)
            .map(|i| i % n + side * (i / n))
            .map(|corner| vec![corner, corner + side, corner + side + 1, corner + 1])
            .collect();
        let mut mesh = HairMesh::from_polygons(positions, faces).unwrap();
        let all: Vec<usize> = (0..mesh.n_bundles()).collect();
        for _ in 0..n_layers {
            mesh.extrude(&all, Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
        }
        mesh
    }

    #[test]
    fn extruding_keeps_the_invariants_and_shares_chains() {
        let mesh = straight_grid(3, 4);
        mesh.check().unwrap();
        assert_eq!((mesh.layers.len(), mesh.n_vertices()), (5, 16 * 5));
        let chains = mesh.chains();
        assert_eq!((chains.chains.len(), chains.of_bundle.len()), (16, 9));
        assert!(chains.chains.iter().all(|chain| chain.len() == 5));
    }

    #[test]
    fn extruding_apart_opens_a_parting() {
        let mut mesh = straight_grid(2, 0);
        mesh.extrude(&[0, 2], Weld::Neighbours, |v| v.position + Vec3::NEG_X).unwrap();
        mesh.extrude(&[1, 3], Weld::Apart, |v| v.position + Vec3::X).unwrap();
        mesh.check().unwrap();
        assert_eq!(mesh.layers[1].positions.len(), 12);
        // The three vertices of the parting carry two chains each.
        assert_eq!(mesh.chains().chains.len(), 12);
    }

    #[test]
    fn deleting_a_tip_shortens_its_bundle_and_the_root_ends_it() {
        let delete_tip = |mesh: &mut HairMesh| mesh.apply(&MeshOp::DeleteTips { bundles: vec![0] });
        let mut mesh = straight_grid(2, 2);
        delete_tip(&mut mesh).unwrap();
        mesh.check().unwrap();
        assert_eq!((mesh.tip_layer(0), mesh.tip_layer(1)), (Some(1), Some(2)));
        assert_eq!(mesh.layers[2].positions.len(), 8);
        delete_tip(&mut mesh).unwrap();
        delete_tip(&mut mesh).unwrap();
        mesh.check().unwrap();
        assert_eq!((mesh.tip_layer(0), mesh.n_bundles()), (None, 4));
        assert_eq!(delete_tip(&mut mesh), Err(HairMeshError::NoBundle { bundle: 0 }));
        mesh.extrude(&[1], Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
        mesh.check().unwrap();
        assert_eq!(mesh.tip_layer(1), Some(3));
    }

    #[test]
    fn check_finds_each_broken_invariant() {
        let good = straight_grid(2, 1);
        let broken = |change: fn(&mut HairMesh)| {
            let mut mesh = good.clone();
            change(&mut mesh);
            mesh.check().unwrap_err()
        };
        assert!(matches!(broken(|m| drop(m.layers[1].faces.pop())), E::BundleCount { layer: 1, .. }));
        assert!(matches!(broken(|m| m.layers[0].faces[2] = None), E::Gap { bundle: 2, .. }));
        assert!(matches!(broken(|m| m.layers[1].faces[0] = Some(vec![0, 1, 2])), E::CornerCount { .. }));
        assert!(matches!(broken(|m| m.layers[0].faces[0] = Some(vec![0, 1, 1, 2])), E::Degenerate { .. }));
        assert!(matches!(broken(|m| m.layers[1].faces[0] = Some(vec![0, 1, 2, 99])), E::Index { vertex: 99, .. }));
        assert!(matches!(broken(|m| m.layers[1].faces.swap(0, 3)), E::ManyToOne { layer: 1, .. }));
        assert!(matches!(broken(|m| m.layers[1].pinned = vec![0, 9]), E::NoVertex { vertex: 9, .. }));
        assert!(matches!(broken(|m| m.layers[1].pinned = vec![4, 2]), E::PinnedOrder { layer: 1 }));
        assert!(matches!(broken(|m| m.layers[1].positions[3].y = f32::NAN), E::NotFinite { vertex: 3, .. }));
    }
}
