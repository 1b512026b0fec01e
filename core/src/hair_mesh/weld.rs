//! Closing what was separated (paper 3.2: Edge and Vertex Weld).
//!
//! Only vertices that stand on one root vertex may become one, and all that they stand on become one
//! with them. A welded vertex lies in the middle of those it was.

use std::collections::{BTreeMap, HashSet};

use super::op::demand_any;
use super::separate::root_edge;
use super::work::{Origin, Work};
use super::{EdgeId, HairMeshError, VertexId};

/// Disjoint sets of the vertices of one layer; the lowest index stands for a set.
struct Sets(Vec<u32>);

impl Sets {
    fn of(&self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            v = self.0[v as usize];
        }
        v
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

impl Work {
    pub(super) fn weld_vertices(&mut self, vertices: &[VertexId]) -> Result<(), HairMeshError> {
        demand_any(vertices, "vertices")?;
        let roots: Vec<Vec<u32>> = (0..self.layers.len()).map(|layer| self.roots(layer)).collect();
        // Twins by layer and root vertex, in a fixed order.
        let mut twins: BTreeMap<(usize, u32), Vec<u32>> = BTreeMap::new();
        for &id @ VertexId { layer, vertex } in vertices {
            self.demand_vertex(id)?;
            let of_root = twins.entry((layer, roots[layer][vertex as usize])).or_default();
            if !of_root.contains(&vertex) {
                of_root.push(vertex);
            }
        }
        let groups: Vec<(usize, Vec<u32>)> =
            twins.into_iter().filter(|(_, v)| v.len() > 1).map(|((layer, _), v)| (layer, v)).collect();
        if groups.is_empty() {
            let VertexId { layer, vertex } = vertices[0];
            return Err(HairMeshError::NoTwinVertex { layer, vertex });
        }
        self.weld(&groups);
        Ok(())
    }

    pub(super) fn weld_edges(&mut self, selected: &[EdgeId]) -> Result<(), HairMeshError> {
        demand_any(selected, "edges")?;
        let bundles_of = self.bundles_of_edges();
        let roots: Vec<Vec<u32>> = (0..self.layers.len()).map(|layer| self.roots(layer)).collect();
        let mut twins: BTreeMap<(usize, [u32; 2]), Vec<EdgeId>> = BTreeMap::new();
        for edge in selected {
            let edge @ EdgeId { layer, ends: [a, b] } = EdgeId::new(edge.layer, edge.ends[0], edge.ends[1]);
            if !bundles_of.contains_key(&edge) {
                return Err(HairMeshError::NoEdge { layer, a, b });
            }
            let of_root = twins.entry((layer, root_edge(&roots[layer], edge.ends))).or_default();
            if !of_root.contains(&edge) {
                of_root.push(edge);
            }
        }
        let mut groups: Vec<(usize, Vec<u32>)> = Vec::new();
        for ((layer, root_ends), edges) in twins.into_iter().filter(|(_, edges)| edges.len() > 1) {
            for root in root_ends {
                let ends = edges.iter().flat_map(|edge| edge.ends);
                groups.push((layer, ends.filter(|&v| roots[layer][v as usize] == root).collect()));
            }
        }
        if groups.is_empty() {
            let EdgeId { layer, ends: [a, b] } = selected[0];
            return Err(HairMeshError::NoTwinEdge { layer, a, b });
        }
        self.weld(&groups);
        Ok(())
    }

    /// Weld groups of vertices, each with its layer, and what they stand on.
    fn weld(&mut self, groups: &[(usize, Vec<u32>)]) {
        let mut sets: Vec<Sets> =
            self.layers.iter().map(|layer| Sets((0..layer.vertices.len() as u32).collect())).collect();
        for (layer, vertices) in groups {
            for &v in vertices {
                sets[*layer].unite(vertices[0], v);
            }
        }
        for layer in (1..self.layers.len()).rev() {
            let parents = self.parents(layer);
            let (below, above) = sets.split_at_mut(layer);
            for v in 0..parents.len() as u32 {
                let (on, on_too) = (parents[v as usize], parents[above[0].of(v) as usize]);
                if on != u32::MAX && on_too != u32::MAX {
                    below[layer - 1].unite(on, on_too);
                }
            }
        }
        for (layer_idx, layer) in self.layers.iter_mut().enumerate() {
            let mut members: BTreeMap<u32, HashSet<u32>> = BTreeMap::new();
            for v in 0..layer.vertices.len() as u32 {
                let set = sets[layer_idx].of(v);
                if set != v {
                    members.entry(set).or_default().extend([v, set]);
                }
            }
            for (set, members) in members {
                let mut members: Vec<u32> = members.into_iter().collect();
                members.sort_unstable();
                let first = layer.position(set);
                // Differences from one of them: coincident vertices stay exactly where they are.
                let shift = members.iter().map(|&v| layer.position(v) - first).sum::<glam::Vec3>();
                layer.vertices[set as usize].position = first + shift / members.len() as f32;
                for v in members {
                    let member = layer.vertices[v as usize];
                    layer.vertices[set as usize].pinned |= member.pinned;
                    if let (true, Origin::Kept(was)) = (v != set, member.origin) {
                        self.merged.push((was, VertexId { layer: layer_idx, vertex: set }));
                    }
                }
            }
            layer.faces.iter_mut().flatten().flatten().for_each(|v| *v = sets[layer_idx].of(*v));
        }
    }
}
