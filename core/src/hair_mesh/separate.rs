//! Opening a hair mesh at vertices and along edges (paper 3.2: Edge and Vertex Separate).
//!
//! In the layer itself the faces around a vertex fall into groups, each with its own copy. Above, a
//! vertex is copied for each of the copies that it now stands on: one pass does both.

use std::collections::{HashMap, HashSet};

use super::op::demand_any;
use super::work::{Work, WorkLayer, edge_of, edges};
use super::{EdgeId, HairMesh, HairMeshError, VertexId};

/// Which group of faces around a cut vertex a bundle belongs to, by (layer, vertex, bundle).
type Groups = HashMap<(usize, u32, usize), usize>;

impl HairMesh {
    /// Layers whose faces stand on each other but whose vertices may stand on several of the layer below:
    /// those are separated. Also how many vertices that added.
    pub fn with_one_below_each(&self) -> Result<(Self, usize), HairMeshError> {
        let mut work = Work::on(self);
        work.separate(&Groups::new());
        let (mesh, report) = work.finish()?;
        Ok((mesh, report.new_vertices.len()))
    }
}

impl Work {
    pub(super) fn separate_vertices(&mut self, vertices: &[VertexId]) -> Result<(), HairMeshError> {
        demand_any(vertices, "vertices")?;
        let mut groups = Groups::new();
        let mut n_shared = 0;
        let bundles_of: Vec<_> = self.layers.iter().map(WorkLayer::bundles_of_vertex).collect();
        for &id in vertices {
            self.demand_vertex(id)?;
            if id.layer == 0 {
                return Err(HairMeshError::RootLayer { done: "separated" });
            }
            let bundles = &bundles_of[id.layer][id.vertex as usize];
            n_shared += usize::from(bundles.len() > 1);
            groups.extend(bundles.iter().enumerate().map(|(i, &bundle)| ((id.layer, id.vertex, bundle), i)));
        }
        if n_shared == 0 {
            let VertexId { layer, vertex } = vertices[0];
            return Err(HairMeshError::VertexOfOneFace { layer, vertex });
        }
        self.separate(&groups);
        Ok(())
    }

    pub(super) fn separate_edges(&mut self, cut: &[EdgeId]) -> Result<(), HairMeshError> {
        demand_any(cut, "edges")?;
        let cut: Vec<EdgeId> = cut.iter().map(|e| EdgeId::new(e.layer, e.ends[0], e.ends[1])).collect();
        let is_cut: HashSet<EdgeId> = cut.iter().copied().collect();
        let bundles_of = self.bundles_of_edges();
        let mut n_shared = 0;
        for &edge @ EdgeId { layer, ends: [a, b] } in &cut {
            if layer == 0 {
                return Err(HairMeshError::RootLayer { done: "separated" });
            }
            let n = bundles_of.get(&edge).ok_or(HairMeshError::NoEdge { layer, a, b })?.len();
            n_shared += usize::from(n > 1);
        }
        if n_shared == 0 {
            let EdgeId { layer, ends: [a, b] } = cut[0];
            return Err(HairMeshError::EdgeOfOneFace { layer, a, b });
        }
        let ends: HashSet<VertexId> = cut.iter().flat_map(|edge| edge.vertices()).collect();
        let mut groups = Groups::new();
        for &VertexId { layer, vertex } in &ends {
            for (group, bundles) in self.fans(layer, vertex, &is_cut).into_iter().enumerate() {
                groups.extend(bundles.into_iter().map(|bundle| ((layer, vertex, bundle), group)));
            }
        }
        for EdgeId { layer, ends: [a, b] } in cut {
            let bundles = &bundles_of[&EdgeId { layer, ends: [a, b] }];
            let sides = |v: u32| bundles.iter().map(|&bundle| groups[&(layer, v, bundle)]).collect::<HashSet<_>>();
            if bundles.len() > 1 && sides(a).len() == 1 && sides(b).len() == 1 {
                return Err(HairMeshError::EdgeStaysClosed { layer, a, b });
            }
        }
        self.separate(&groups);
        Ok(())
    }

    /// Bundles that have each edge, in every layer.
    pub(super) fn bundles_of_edges(&self) -> HashMap<EdgeId, Vec<usize>> {
        let mut bundles_of: HashMap<EdgeId, Vec<usize>> = HashMap::new();
        for (layer, faces) in self.layers.iter().enumerate() {
            for (bundle, face) in faces.bundles() {
                for [a, b] in edges(face) {
                    bundles_of.entry(EdgeId::new(layer, a, b)).or_default().push(bundle);
                }
            }
        }
        bundles_of
    }

    /// The bundles around a vertex in groups that hold together by edges that are not cut; the group with
    /// the lowest bundle first.
    fn fans(&self, layer: usize, vertex: u32, is_cut: &HashSet<EdgeId>) -> Vec<Vec<usize>> {
        // Bundles with the other ends of their two edges at the vertex.
        let around = self.layers[layer].bundles().filter_map(|(bundle, face)| {
            let i = face.iter().position(|&v| v == vertex)?;
            Some((bundle, [face[(i + 1) % face.len()], face[(i + face.len() - 1) % face.len()]]))
        });
        let mut around: Vec<(usize, [u32; 2])> = around.collect();
        let mut fans = Vec::new();
        while !around.is_empty() {
            let (first, ends) = around.remove(0);
            let mut fan = vec![first];
            let mut open = ends.to_vec();
            while let Some(end) = open.pop() {
                if is_cut.contains(&EdgeId::new(layer, vertex, end)) {
                    continue;
                }
                while let Some(i) = around.iter().position(|(_, ends)| ends.contains(&end)) {
                    let (bundle, ends) = around.remove(i);
                    fan.push(bundle);
                    open.extend(ends.into_iter().filter(|&other| other != end));
                }
            }
            fans.push(fan);
        }
        fans
    }

    fn separate(&mut self, groups: &Groups) {
        for layer in 1..self.layers.len() {
            let (below, above) = self.layers.split_at_mut(layer);
            let (below, above) = (&below[layer - 1], &mut above[0]);
            let mut copy_of: HashMap<(u32, u32, usize), u32> = HashMap::new();
            let mut taken = vec![false; above.vertices.len()];
            for bundle in 0..above.faces.len() {
                let (Some(face), Some(on)) = (&above.faces[bundle], &below.faces[bundle]) else { continue };
                let new_face: Vec<u32> = face
                    .iter()
                    .zip(on)
                    .map(|(&v, &on)| {
                        let group = groups.get(&(layer, v, bundle)).copied().unwrap_or(0);
                        *copy_of.entry((v, on, group)).or_insert_with(|| {
                            // The first to ask keeps the vertex itself.
                            if !std::mem::replace(&mut taken[v as usize], true) {
                                return v;
                            }
                            above.vertices.push(above.vertices[v as usize].copy());
                            above.vertices.len() as u32 - 1
                        })
                    })
                    .collect();
                above.faces[bundle] = Some(new_face);
            }
        }
    }
}

/// Root edges of edges of any layer; `roots` of that layer.
pub(super) fn root_edge(roots: &[u32], [a, b]: [u32; 2]) -> [u32; 2] {
    edge_of(roots[a as usize], roots[b as usize])
}
