//! Dividing faces and edges with their whole bundles (paper 3.2: Face and Edge Divide).

use std::collections::HashMap;

use glam::Vec3;

use super::op::demand_share;
use super::separate::root_edge;
use super::work::{Vertex, Work, edge_of, edges};
use super::{EdgeId, FaceCut, HairMeshError, VertexId};

impl Work {
    pub(super) fn divide_face(&mut self, bundle: usize, cut: FaceCut) -> Result<(), HairMeshError> {
        self.tip_layer(bundle)?;
        match cut {
            FaceCut::Corners(a, b) => self.divide_at_corners(bundle, a, b),
            FaceCut::Fan => {
                self.divide_around_middle(bundle, 1);
                Ok(())
            }
            FaceCut::Quads => self.subdivide(&[bundle], super::Scheme::Linear),
        }
    }

    fn divide_at_corners(&mut self, bundle: usize, a: usize, b: usize) -> Result<(), HairMeshError> {
        let n_corners = self.face(0, bundle).map_or(0, <[u32]>::len);
        let (a, b) = (a.min(b), a.max(b));
        // Each part needs a corner beside the two.
        if b >= n_corners || b - a < 2 || n_corners - (b - a) < 2 {
            return Err(HairMeshError::CornersDoNotDivide { bundle, a, b, n_corners });
        }
        let new_bundle = self.push_bundle();
        for layer in &mut self.layers {
            let Some(face) = layer.faces[bundle].take() else { break };
            layer.faces[new_bundle] = Some(face[b..].iter().chain(&face[..=a]).copied().collect());
            layer.faces[bundle] = Some(face[a..=b].to_vec());
        }
        Ok(())
    }

    /// Replace a bundle's face of `k * step` corners in every layer by `k` faces around a new middle vertex,
    /// each over `step` edges: 1 makes triangles, and 2 makes quads where every second corner, from
    /// the last one on, is the middle of an edge. The first face keeps the bundle's number.
    pub(super) fn divide_around_middle(&mut self, bundle: usize, step: usize) {
        let n_corners = self.face(0, bundle).map_or(0, <[u32]>::len);
        let parts: Vec<usize> =
            (0..n_corners / step).map(|i| if i == 0 { bundle } else { self.push_bundle() }).collect();
        for layer in &mut self.layers {
            let Some(face) = layer.faces[bundle].take() else { break };
            let first = layer.position(face[0]);
            let shift = face.iter().map(|&v| layer.position(v) - first).sum::<Vec3>();
            let middle = layer.push(Vertex::new(first + shift / n_corners as f32));
            for (i, &part) in parts.iter().enumerate() {
                // Over two edges a part begins at the middle of the edge before its corner.
                let begin = i * step + n_corners - (step - 1);
                let mut corners: Vec<u32> = (0..=step).map(|k| face[(begin + k) % n_corners]).collect();
                corners.push(middle);
                layer.faces[part] = Some(corners);
            }
        }
    }

    pub(super) fn divide_edge(&mut self, edge: EdgeId, at: f32) -> Result<(), HairMeshError> {
        demand_share(at)?;
        let EdgeId { layer, ends: [a, b] } = edge;
        for vertex in edge.ends {
            self.demand_vertex(VertexId { layer, vertex })?;
        }
        if !self.bundles_of_edges().contains_key(&EdgeId::new(layer, a, b)) {
            return Err(HairMeshError::NoEdge { layer, a, b });
        }
        let roots = self.roots(layer);
        let root_edge = root_edge(&roots, [a, b]);
        let first_root = roots[a as usize];
        let of_layer: Vec<Vec<u32>> = (0..self.layers.len()).map(|layer| self.roots(layer)).collect();
        self.split_edges(&|edge| edge == root_edge, &mut |layer, [a, b], [p, q]| {
            let a_is_first = of_layer[layer][a as usize] == first_root || of_layer[layer][b as usize] != first_root;
            if a_is_first { p.lerp(q, at) } else { q.lerp(p, at) }
        });
        Ok(())
    }

    /// Put a corner into every edge that stands on a root edge for which `divided` holds, in all layers and
    /// faces. `place` gets layer, edge and its two places.
    pub(super) fn split_edges(
        &mut self,
        divided: &dyn Fn([u32; 2]) -> bool,
        place: &mut dyn FnMut(usize, [u32; 2], [Vec3; 2]) -> Vec3,
    ) {
        // Per bundle: which of its edges are divided, by corner.
        let root = self.layers.first().map_or(&[][..], |root| &root.faces);
        let of_bundle: Vec<Vec<bool>> = root
            .iter()
            .map(|face| edges(face.as_deref().unwrap_or_default()).map(|[a, b]| divided(edge_of(a, b))).collect())
            .collect();
        for (layer_idx, layer) in self.layers.iter_mut().enumerate() {
            let mut middle_of: HashMap<[u32; 2], u32> = HashMap::new();
            for (bundle, is_divided) in of_bundle.iter().enumerate() {
                let Some(face) = layer.faces[bundle].take() else { continue };
                let mut divided_face = Vec::with_capacity(2 * face.len());
                for ([a, b], &is_divided) in edges(&face).zip(is_divided) {
                    divided_face.push(a);
                    if is_divided {
                        let edge = edge_of(a, b);
                        let ends = edge.map(|v| layer.position(v));
                        divided_face.push(*middle_of.entry(edge).or_insert_with(|| {
                            layer.vertices.push(Vertex::new(place(layer_idx, edge, ends)));
                            layer.vertices.len() as u32 - 1
                        }));
                    }
                }
                layer.faces[bundle] = Some(divided_face);
            }
        }
    }
}
