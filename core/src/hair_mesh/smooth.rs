//! Moving vertices towards the middle of their neighbours, in their layer and along their hair.

use glam::Vec3;

use super::op::demand_any;
use super::work::{Work, edges};
use super::{HairMeshError, VertexId};

/// More rounds than this are a slip of the hand.
const MOST_ROUNDS: u32 = 1000;

impl Work {
    pub(super) fn smooth(&mut self, vertices: &[VertexId], strength: f32, n_times: u32) -> Result<(), HairMeshError> {
        demand_any(vertices, "vertices")?;
        if !(0.0..=1.0).contains(&strength) {
            return Err(HairMeshError::OutOfRange { what: "the strength", min: "0", max: "1" });
        }
        if n_times > MOST_ROUNDS {
            return Err(HairMeshError::OutOfRange { what: "the number of rounds", min: "0", max: "1000" });
        }
        vertices.iter().try_for_each(|&id| self.demand_vertex(id))?;
        let neighbours: Vec<(VertexId, Vec<VertexId>)> = {
            let of_all = self.neighbours();
            let mut chosen: Vec<VertexId> = vertices.iter().copied().filter(|id| id.layer > 0).collect();
            chosen.sort_unstable();
            chosen.dedup();
            chosen.into_iter().map(|id| (id, of_all[id.layer][id.vertex as usize].clone())).collect()
        };
        for _ in 0..n_times {
            let position = |id: VertexId| self.layers[id.layer].position(id.vertex);
            let moved: Vec<Vec3> = neighbours
                .iter()
                .map(|(id, around)| {
                    let middle = around.iter().map(|&id| position(id)).sum::<Vec3>() / around.len().max(1) as f32;
                    position(*id).lerp(if around.is_empty() { position(*id) } else { middle }, strength)
                })
                .collect();
            for ((id, _), place) in neighbours.iter().zip(moved) {
                self.layers[id.layer].vertices[id.vertex as usize].position = place;
            }
        }
        Ok(())
    }

    /// Per layer and vertex: the vertices that an edge or a step between layers leads to, rising.
    fn neighbours(&self) -> Vec<Vec<Vec<VertexId>>> {
        let mut of_all: Vec<Vec<Vec<VertexId>>> =
            self.layers.iter().map(|layer| vec![Vec::new(); layer.vertices.len()]).collect();
        let mut join = |a: VertexId, b: VertexId| {
            of_all[a.layer][a.vertex as usize].push(b);
            of_all[b.layer][b.vertex as usize].push(a);
        };
        for (layer, faces) in self.layers.iter().enumerate() {
            for (bundle, face) in faces.bundles() {
                for [a, b] in edges(face) {
                    join(VertexId { layer, vertex: a }, VertexId { layer, vertex: b });
                }
                if let Some(below) = layer.checked_sub(1) {
                    for (&v, &on) in face.iter().zip(self.face(below, bundle).unwrap_or_default()) {
                        join(VertexId { layer, vertex: v }, VertexId { layer: below, vertex: on });
                    }
                }
            }
        }
        for neighbours in of_all.iter_mut().flatten() {
            neighbours.sort_unstable();
            neighbours.dedup();
        }
        of_all
    }
}
