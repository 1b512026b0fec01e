//! Rebuilding one side of a hair mesh as the mirror image of the other, topology included.
//!
//! Bundles on the side that is copied get their images; what was on the other side goes, but an image takes
//! the number of the bundle that it stands in for. Bundles across the middle stay: of those, the corners on
//! the other side become images.

use std::collections::{HashMap, HashSet};

use super::symmetry::{Counterpart, MirrorPairs, Side, mirrored};
use super::work::{Vertex, Work};
use super::{HairMesh, HairMeshError, HairMeshLayer};

/// Where something at the root lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lies {
    OnSource,
    OnTarget,
    /// A corner on the plane; a face that crosses it.
    Across,
}

impl Work {
    pub(super) fn mirror(&mut self, from: Side, tolerance_cm: f32) -> Result<(), HairMeshError> {
        if !(0.0..=10.0).contains(&tolerance_cm) {
            return Err(HairMeshError::OutOfRange { what: "the tolerance", min: "0", max: "10 cm" });
        }
        let corners = self.sides_of_corners(from.sign(), tolerance_cm);
        let lies: Vec<Option<Lies>> = corners.iter().map(|corners| side_of_face(corners)).collect();
        let bundles_that_lie = |side: Lies| {
            let lies = &lies;
            (0..lies.len()).filter(move |&bundle| lies[bundle] == Some(side))
        };
        let pairs = self.pairs_of_roots(tolerance_cm);
        let mut middle: Vec<(usize, Counterpart)> = Vec::new();
        for bundle in bundles_that_lie(Lies::Across) {
            let itself = pairs.bundles[bundle].filter(|pair| pair.bundle == bundle);
            middle.push((bundle, itself.ok_or(HairMeshError::AcrossTheMiddle { bundle })?));
        }
        // Images take the numbers of the bundles that they stand in for.
        let mut taken = HashSet::new();
        let mut images: Vec<(usize, Option<usize>)> = Vec::new();
        for source in bundles_that_lie(Lies::OnSource) {
            let there = pairs.bundle(source).filter(|&b| lies[b] == Some(Lies::OnTarget) && taken.insert(b));
            images.push((source, there));
        }
        let images: Vec<(usize, usize)> =
            images.into_iter().map(|(source, there)| (source, there.unwrap_or_else(|| self.push_bundle()))).collect();
        let own = self.own_images(&corners, &lies, tolerance_cm);
        for (layer, own) in self.layers.iter_mut().zip(&own) {
            for target in bundles_that_lie(Lies::OnTarget) {
                layer.faces[target] = None;
            }
            for (vertex, _) in layer.vertices.iter_mut().zip(own).filter(|(_, own)| **own) {
                vertex.position.x = 0.0;
            }
            let vertices = &mut layer.vertices;
            let mut copies: HashMap<u32, u32> = HashMap::new();
            let mut image = |v: u32| -> u32 {
                if own[v as usize] {
                    return v;
                }
                *copies.entry(v).or_insert_with(|| {
                    let vertex = vertices[v as usize];
                    vertices.push(Vertex { position: mirrored(vertex.position), ..vertex.copy() });
                    vertices.len() as u32 - 1
                })
            };
            for &(source, target) in &images {
                let turned = layer.faces[source].as_ref().map(|face| face.iter().rev().map(|&v| image(v)).collect());
                layer.faces[target] = turned;
            }
            for &(bundle, pair) in &middle {
                let Some(face) = &layer.faces[bundle] else { continue };
                let corner = |i: usize| match corners[bundle][i] {
                    Lies::OnTarget => image(face[pair.corner(i)]),
                    Lies::OnSource | Lies::Across => face[i],
                };
                let rebuilt = (0..face.len()).map(corner).collect();
                layer.faces[bundle] = Some(rebuilt);
            }
        }
        Ok(())
    }

    /// Per bundle and corner: where its root lies.
    fn sides_of_corners(&self, sign: f32, tolerance_cm: f32) -> Vec<Vec<Lies>> {
        let side = |&v: &u32| {
            let x = sign * self.layers[0].position(v).x;
            if x.abs() <= tolerance_cm {
                Lies::Across
            } else if x > 0.0 {
                Lies::OnSource
            } else {
                Lies::OnTarget
            }
        };
        let of_bundle = |bundle: usize| self.face(0, bundle).unwrap_or_default().iter().map(side).collect();
        (0..self.n_bundles()).map(of_bundle).collect()
    }

    fn pairs_of_roots(&self, tolerance_cm: f32) -> MirrorPairs {
        let root = HairMeshLayer {
            positions: self.layers[0].vertices.iter().map(|vertex| vertex.position).collect(),
            faces: self.layers[0].faces.clone(),
            pinned: Vec::new(),
        };
        MirrorPairs::of(&HairMesh { layers: vec![root] }, tolerance_cm)
    }

    /// Per layer and vertex: is it its own image? Vertices in the middle are, unless the two sides part there:
    /// that is where the other side has a vertex of its own on the same vertex below.
    fn own_images(&self, corners: &[Vec<Lies>], lies: &[Option<Lies>], tolerance_cm: f32) -> Vec<Vec<bool>> {
        let mut own: Vec<Vec<bool>> = Vec::new();
        for (layer_idx, layer) in self.layers.iter().enumerate() {
            let n = layer.vertices.len();
            let parents = self.parents(layer_idx);
            let (mut of_target, mut of_across) = (vec![false; n], vec![false; n]);
            let mut parts = HashSet::new();
            for (bundle, face) in layer.bundles() {
                for (i, &v) in face.iter().enumerate() {
                    of_across[v as usize] |= lies[bundle] == Some(Lies::Across) && corners[bundle][i] == Lies::Across;
                    if lies[bundle] == Some(Lies::OnTarget) {
                        of_target[v as usize] = true;
                        parts.insert(parents[v as usize]);
                    }
                }
            }
            let twin_at_root = |v: usize| {
                let p = layer.position(v as u32);
                let near = |u: usize| u != v && of_target[u] && layer.position(u as u32).distance(p) <= tolerance_cm;
                (0..n).any(near)
            };
            let is_own = |v: usize| {
                let is_near = layer.vertices[v].position.x.abs() <= tolerance_cm;
                let is_shared = of_target[v]
                    || match layer_idx {
                        0 => !(is_near && twin_at_root(v)),
                        _ => !parts.contains(&parents[v]),
                    };
                let stands_on_own = match layer_idx {
                    0 => true,
                    _ => own[layer_idx - 1].get(parents[v] as usize).copied().unwrap_or(false),
                };
                of_across[v] || (is_near && is_shared && stands_on_own)
            };
            own.push((0..n).map(is_own).collect());
        }
        own
    }
}

fn side_of_face(corners: &[Lies]) -> Option<Lies> {
    let has = |side: Lies| corners.contains(&side);
    match (has(Lies::OnSource), has(Lies::OnTarget)) {
        _ if corners.is_empty() => None,
        (true, false) => Some(Lies::OnSource),
        (false, true) => Some(Lies::OnTarget),
        (true, true) | (false, false) => Some(Lies::Across),
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::op_tests::straight_grid;
    use super::super::symmetry::MIRROR_TOLERANCE_CM;
    use super::super::{MeshOp, VertexId, Weld};
    use super::*;

    /// A grid of `n` x `n` around X = 0 with a layer above.
    fn grid(n: u32) -> HairMesh {
        let mut mesh = straight_grid(n, 1);
        for layer in 0..2 {
            mesh.move_vertices(layer, |_, p| p - Vec3::X * (n as f32 / 2.0));
        }
        mesh
    }

    fn assert_symmetric(mesh: &HairMesh) {
        let pairs = MirrorPairs::of(mesh, MIRROR_TOLERANCE_CM);
        for (layer, of_layer) in mesh.layers.iter().enumerate() {
            for (v, &p) in of_layer.positions.iter().enumerate() {
                let answer = pairs.vertices[layer][v].unwrap_or_else(|| panic!("{v} of layer {layer} at {p}"));
                assert_eq!(mirrored(of_layer.positions[answer as usize]), p);
            }
        }
    }

    #[test]
    fn the_other_side_becomes_the_mirror_image_with_its_heights_and_partings() {
        for n in [4, 5] {
            let mut mesh = grid(n);
            let left = (n - 1) as usize;
            mesh.extrude(&[left, 2 * left + 1], Weld::Neighbours, |v| v.position + Vec3::new(0.7, 1.0, 0.1)).unwrap();
            let vertex = n + 1 + n - 1;
            mesh.apply(&MeshOp::SeparateVertices { vertices: vec![VertexId { layer: 1, vertex }] }).unwrap();
            mesh.layers[1].positions[vertex as usize].y += 0.3;
            let before = mesh.clone();
            mesh.apply(&MeshOp::Mirror { from: Side::PlusX, tolerance_cm: MIRROR_TOLERANCE_CM }).unwrap();
            mesh.check().unwrap();
            assert_symmetric(&mesh);
            assert_eq!((mesh.n_bundles(), mesh.tip_layer(0)), (before.n_bundles(), Some(2)));
            let again = mesh.clone();
            mesh.apply(&MeshOp::Mirror { from: Side::MinusX, tolerance_cm: MIRROR_TOLERANCE_CM }).unwrap();
            assert_symmetric(&mesh);
            assert_eq!(mesh.n_vertices(), again.n_vertices());
        }
    }

    #[test]
    fn a_half_gets_its_other_half_and_a_parting_in_the_middle_stays() {
        let mut mesh = grid(4);
        let right: Vec<usize> = (0..16).filter(|bundle| bundle % 4 < 2).collect();
        let mut half = mesh.clone();
        half.apply(&MeshOp::DeleteBundles { bundles: right }).unwrap();
        half.apply(&MeshOp::Mirror { from: Side::PlusX, tolerance_cm: MIRROR_TOLERANCE_CM }).unwrap();
        assert_symmetric(&half);
        assert_eq!(half.n_vertices(), 50);
        // Open the middle: it has two vertices everywhere above the root.
        let middle = (0..5).map(|z| VertexId { layer: 1, vertex: 2 + 5 * z });
        let edges = middle.clone().zip(middle.skip(1)).map(|(a, b)| super::super::EdgeId::new(1, a.vertex, b.vertex));
        mesh.apply(&MeshOp::SeparateEdges { edges: edges.collect() }).unwrap();
        assert_eq!(mesh.n_vertices(), 55);
        mesh.apply(&MeshOp::Mirror { from: Side::MinusX, tolerance_cm: MIRROR_TOLERANCE_CM }).unwrap();
        assert_eq!(mesh.n_vertices(), 55, "the parting is still there");
        mesh.check().unwrap();
    }

    #[test]
    fn a_face_across_the_middle_that_is_not_symmetric_is_refused() {
        let mut mesh = grid(3);
        mesh.layers[0].positions[1].z += 0.5;
        let before = mesh.clone();
        let refused = mesh.apply(&MeshOp::Mirror { from: Side::PlusX, tolerance_cm: MIRROR_TOLERANCE_CM });
        assert_eq!(refused, Err(HairMeshError::AcrossTheMiddle { bundle: 1 }));
        assert_eq!(mesh, before);
    }
}
