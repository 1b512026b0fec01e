//! The outer surface of a hair mesh: the polygons, edges and vertices that an artist sees and takes hold of.
//!
//! It consists of the tip faces and of the sides that no other bundle shares (Yuksel, Schaefer and Keyser 2009,
//! section 3.3). The root layer lies on the scalp and closes it, but is no part of it, unless nothing was
//! extruded yet: then the root faces are the tips.

use std::collections::HashMap;

use glam::Vec3;

use super::{HairMesh, VertexId};
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;

/// A polygon of the outer surface, counter-clockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OuterFace {
    pub corners: Vec<VertexId>,
    pub bundle: usize,
    /// Of a tip face its layer, of a side the upper one.
    pub layer: usize,
    pub is_tip: bool,
}

/// An edge of the outer surface: within a layer, or from a layer to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OuterEdge {
    /// The lower layer, then the lower index, first.
    pub ends: [VertexId; 2],
    /// Indices into [`OuterSurface::faces`]; the same twice at the border to the scalp.
    pub faces: [u32; 2],
}

impl OuterEdge {
    /// Whether both ends are in one layer.
    pub fn is_within(&self) -> bool {
        self.ends[0].layer == self.ends[1].layer
    }
}

/// All of it. Only the topology: positions are the hair mesh's.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct OuterSurface {
    pub faces: Vec<OuterFace>,
    pub edges: Vec<OuterEdge>,
    /// Rising, each once.
    pub vertices: Vec<VertexId>,
}

impl OuterSurface {
    pub fn of(mesh: &HairMesh) -> Self {
        let mut faces = Vec::new();
        for bundle in 0..mesh.n_bundles() {
            let Some(tip) = mesh.tip_layer(bundle) else { continue };
            let mut corners = layer_corners(mesh, tip, bundle);
            if mesh.is_clockwise(bundle) {
                corners.reverse();
            }
            faces.push(OuterFace { corners, bundle, layer: tip, is_tip: true });
        }
        for layer in 1..mesh.layers.len() {
            for (bundle, side) in unshared_sides(mesh, layer) {
                let at = |layer: usize, vertex: u32| VertexId { layer, vertex };
                let mut corners =
                    vec![at(layer - 1, side[0]), at(layer - 1, side[1]), at(layer, side[2]), at(layer, side[3])];
                if mesh.is_clockwise(bundle) {
                    corners.reverse();
                }
                faces.push(OuterFace { corners, bundle, layer, is_tip: false });
            }
        }
        let mut edge_idx: HashMap<[VertexId; 2], usize> = HashMap::new();
        let mut edges: Vec<OuterEdge> = Vec::new();
        let mut vertices = Vec::new();
        for (face_idx, face) in faces.iter().enumerate() {
            vertices.extend_from_slice(&face.corners);
            for (i, &a) in face.corners.iter().enumerate() {
                let b = face.corners[(i + 1) % face.corners.len()];
                let ends = [a.min(b), a.max(b)];
                let known = *edge_idx.entry(ends).or_insert_with(|| {
                    edges.push(OuterEdge { ends, faces: [face_idx as u32; 2] });
                    edges.len() - 1
                });
                edges[known].faces[1] = face_idx as u32;
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        Self { faces, edges, vertices }
    }

    /// The surface as triangles to ask for a ray's hit, and the face of each triangle; `None` where it has no area.
    pub fn query(&self, mesh: &HairMesh) -> Option<(MeshQuery, Vec<u32>)> {
        let mut triangles = TriMesh::default();
        let mut face_of_triangle = Vec::new();
        for (face_idx, face) in self.faces.iter().enumerate() {
            let first = triangles.positions.len() as u32;
            triangles.positions.extend(face.corners.iter().filter_map(|&id| mesh.position(id)));
            for i in 1..face.corners.len() as u32 - 1 {
                triangles.triangles.push([first, first + i, first + i + 1]);
                face_of_triangle.push(face_idx as u32);
            }
        }
        Some((MeshQuery::new(&triangles).ok()?, face_of_triangle))
    }

    /// The area vector of a face, out of the hair.
    pub fn area_vector(&self, mesh: &HairMesh, face_idx: usize) -> Vec3 {
        let p: Vec<Vec3> = self.faces[face_idx].corners.iter().filter_map(|&id| mesh.position(id)).collect();
        (0..p.len()).map(|i| 0.5 * (p[i] - p[0]).cross(p[(i + 1) % p.len()] - p[0])).sum()
    }

    /// Unit normals of the outer vertices, in the order of [`OuterSurface::vertices`]; +Y where there is none.
    pub fn normals(&self, mesh: &HairMesh) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.vertices.len()];
        for (face_idx, face) in self.faces.iter().enumerate() {
            let area = self.area_vector(mesh, face_idx);
            for corner in &face.corners {
                if let Ok(at) = self.vertices.binary_search(corner) {
                    normals[at] += area;
                }
            }
        }
        normals.into_iter().map(|normal| normal.normalize_or(Vec3::Y)).collect()
    }
}

fn layer_corners(mesh: &HairMesh, layer: usize, bundle: usize) -> Vec<VertexId> {
    mesh.face(layer, bundle).unwrap_or_default().iter().map(|&vertex| VertexId { layer, vertex }).collect()
}

/// The sides between a layer and the one below that no other bundle shares: bundle, the lower edge, and the upper
/// edge the other way round.
fn unshared_sides(mesh: &HairMesh, layer: usize) -> Vec<(usize, [u32; 4])> {
    let mut sides: Vec<(usize, [u32; 4])> = Vec::new();
    let mut n_bundles_of: HashMap<[u32; 4], u32> = HashMap::new();
    for bundle in 0..mesh.n_bundles() {
        let (Some(above), Some(below)) = (mesh.face(layer, bundle), mesh.face(layer - 1, bundle)) else { continue };
        for i in 0..above.len() {
            let j = (i + 1) % above.len();
            let side = [below[i], below[j], above[j], above[i]];
            *n_bundles_of.entry(unordered(side)).or_default() += 1;
            sides.push((bundle, side));
        }
    }
    sides.retain(|(_, side)| n_bundles_of[&unordered(*side)] == 1);
    sides
}

/// The same for a side seen from either of its bundles.
fn unordered(side: [u32; 4]) -> [u32; 4] {
    let [a, b, c, d] = side;
    side.min([b, a, d, c])
}

impl HairMesh {
    /// Per layer and vertex: is it on the outer surface? The root layer, which lies on the scalp, counts too.
    pub fn external_vertices(&self) -> Vec<Vec<bool>> {
        let of_layer = |(i, layer): (usize, &super::HairMeshLayer)| vec![i == 0; layer.positions.len()];
        let mut external: Vec<Vec<bool>> = self.layers.iter().enumerate().map(of_layer).collect();
        for bundle in 0..self.n_bundles() {
            if let Some(tip) = self.tip_layer(bundle) {
                self.face(tip, bundle).into_iter().flatten().for_each(|&v| external[tip][v as usize] = true);
            }
        }
        for layer in 1..self.layers.len() {
            for (_, [a, b, c, d]) in unshared_sides(self, layer) {
                for (layer, v) in [(layer - 1, a), (layer - 1, b), (layer, c), (layer, d)] {
                    external[layer][v as usize] = true;
                }
            }
        }
        external
    }

    /// Whether a bundle's faces turn clockwise, seen from its tip.
    fn is_clockwise(&self, bundle: usize) -> bool {
        let (Some(root), Some(next)) = (self.face(0, bundle), self.face(1, bundle)) else { return false };
        let p = |layer: usize, face: &[u32], i: usize| self.layers[layer].positions[face[i % face.len()] as usize];
        let area: Vec3 =
            (0..root.len()).map(|i| (p(0, root, i) - p(0, root, 0)).cross(p(0, root, i + 1) - p(0, root, 0))).sum();
        let along: Vec3 = (0..root.len()).map(|i| p(1, next, i) - p(0, root, i)).sum();
        area.dot(along) < 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::tests::straight_grid;

    #[test]
    fn the_outer_surface_is_closed_but_for_the_scalp_and_faces_outwards() {
        let mesh = straight_grid(3, 4);
        let outer = OuterSurface::of(&mesh);
        // Nine tips, and four walls of 3 x 4 sides.
        assert_eq!(outer.faces.len(), 9 + 4 * 12);
        let n_border = outer.edges.iter().filter(|edge| edge.faces[0] == edge.faces[1]).count();
        assert_eq!(n_border, 12, "the edges on the scalp have one face");
        let middle = Vec3::new(1.5, 2.0, 1.5);
        for (face_idx, face) in outer.faces.iter().enumerate() {
            let at = mesh.position(face.corners[0]).unwrap();
            assert!(outer.area_vector(&mesh, face_idx).dot(at - middle) > 0.0, "{face:?}");
        }
        let external = mesh.external_vertices();
        assert!(outer.vertices.iter().all(|id| external[id.layer][id.vertex as usize]));
        for (id, normal) in outer.vertices.iter().zip(outer.normals(&mesh)) {
            assert!(normal.dot(mesh.position(*id).unwrap() - middle) > 0.0);
        }
    }

    #[test]
    fn turned_faces_look_outwards_too_and_a_ray_finds_them() {
        let mut mesh = straight_grid(2, 2);
        for layer in &mut mesh.layers {
            layer.faces.iter_mut().flatten().for_each(|face| face.reverse());
        }
        let outer = OuterSurface::of(&mesh);
        for face_idx in 0..outer.faces.len() {
            let at = mesh.position(outer.faces[face_idx].corners[0]).unwrap();
            assert!(outer.area_vector(&mesh, face_idx).dot(at - Vec3::ONE) > 0.0);
        }
        let (query, face_of_triangle) = outer.query(&mesh).unwrap();
        let hit = query.ray(Vec3::new(0.5, 9.0, 0.5), Vec3::NEG_Y).unwrap();
        let face = &outer.faces[face_of_triangle[hit.triangle_idx as usize] as usize];
        assert!(face.is_tip && face.layer == 2 && face.bundle == 0);
    }

    #[test]
    fn without_layers_the_root_faces_are_the_surface() {
        let outer = OuterSurface::of(&straight_grid(2, 0));
        assert_eq!((outer.faces.len(), outer.vertices.len()), (4, 9));
        assert!(outer.faces.iter().all(|face| face.is_tip && face.layer == 0));
    }
}
