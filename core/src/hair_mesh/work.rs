//! The bench that topological operations work on: a copy of the hair mesh whose vertices remember where
//! they come from, so that indices stay valid until the operation ends and the [`Report`] writes itself.
//!
//! Changing the mesh in place was rejected: every operation would need a way back from half of itself.

use std::collections::HashMap;

use glam::Vec3;

use super::{HairMesh, HairMeshError, HairMeshLayer, NewVertex, Report, VertexId};

/// Where a vertex of the bench comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Origin {
    Kept(VertexId),
    CopyOf(VertexId),
    New,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub position: Vec3,
    pub pinned: bool,
    pub origin: Origin,
}

impl Vertex {
    /// A copy, as a vertex of its own.
    pub fn copy(self) -> Self {
        let origin = match self.origin {
            Origin::Kept(id) | Origin::CopyOf(id) => Origin::CopyOf(id),
            Origin::New => Origin::New,
        };
        Self { origin, ..self }
    }

    pub fn new(position: Vec3) -> Self {
        Self { position, pinned: false, origin: Origin::New }
    }
}

#[derive(Debug, Clone, Default)]
pub(super) struct WorkLayer {
    pub vertices: Vec<Vertex>,
    /// As in [`HairMeshLayer`].
    pub faces: Vec<Option<Vec<u32>>>,
}

impl WorkLayer {
    pub fn push(&mut self, vertex: Vertex) -> u32 {
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }

    pub fn position(&self, vertex: u32) -> Vec3 {
        self.vertices[vertex as usize].position
    }

    /// Faces with their bundles.
    pub fn bundles(&self) -> impl Iterator<Item = (usize, &[u32])> {
        self.faces.iter().enumerate().filter_map(|(bundle, face)| Some((bundle, face.as_deref()?)))
    }

    /// Bundles around each vertex, rising.
    pub fn bundles_of_vertex(&self) -> Vec<Vec<usize>> {
        let mut bundles_of = vec![Vec::new(); self.vertices.len()];
        for (bundle, face) in self.bundles() {
            for &v in face {
                bundles_of[v as usize].push(bundle);
            }
        }
        bundles_of
    }
}

#[derive(Debug, Clone)]
pub(super) struct Work {
    pub layers: Vec<WorkLayer>,
    /// Old vertices that were welded away, and the vertex they became.
    pub merged: Vec<(VertexId, VertexId)>,
    /// Vertices of each layer and bundles when the work began.
    n_vertices_before: Vec<usize>,
    n_bundles_before: usize,
}

impl Work {
    pub fn on(mesh: &HairMesh) -> Self {
        let layers = mesh.layers.iter().enumerate().map(|(layer, HairMeshLayer { positions, faces, pinned })| {
            let kept = |vertex: usize| Origin::Kept(VertexId { layer, vertex: vertex as u32 });
            let vertices = positions.iter().enumerate();
            let mut vertices: Vec<Vertex> =
                vertices.map(|(v, &position)| Vertex { position, pinned: false, origin: kept(v) }).collect();
            for &v in pinned {
                vertices[v as usize].pinned = true;
            }
            WorkLayer { vertices, faces: faces.clone() }
        });
        Self {
            layers: layers.collect(),
            merged: Vec::new(),
            n_vertices_before: mesh.layers.iter().map(|layer| layer.positions.len()).collect(),
            n_bundles_before: mesh.n_bundles(),
        }
    }

    pub fn n_bundles(&self) -> usize {
        self.layers.first().map_or(0, |root| root.faces.len())
    }

    pub fn face(&self, layer: usize, bundle: usize) -> Option<&[u32]> {
        self.layers.get(layer)?.faces.get(bundle)?.as_deref()
    }

    /// The bundle's topmost layer.
    pub fn tip_layer(&self, bundle: usize) -> Result<usize, HairMeshError> {
        let tip = (0..self.layers.len()).take_while(|&layer| self.face(layer, bundle).is_some()).last();
        tip.ok_or(HairMeshError::NoBundle { bundle })
    }

    /// The vertex of the layer below that each vertex stands on; `u32::MAX` for vertices without a face.
    pub fn parents(&self, layer: usize) -> Vec<u32> {
        let mut parents = vec![u32::MAX; self.layers[layer].vertices.len()];
        for (bundle, face) in self.layers[layer].bundles() {
            if let Some(below) = layer.checked_sub(1).and_then(|below| self.face(below, bundle)) {
                face.iter().zip(below).for_each(|(&v, &on)| parents[v as usize] = on);
            }
        }
        parents
    }

    /// The root vertex that each vertex of a layer stands on; `u32::MAX` for vertices without a face.
    pub fn roots(&self, layer: usize) -> Vec<u32> {
        let mut roots = vec![u32::MAX; self.layers[layer].vertices.len()];
        for (bundle, face) in self.layers[layer].bundles() {
            if let Some(root) = self.face(0, bundle) {
                face.iter().zip(root).for_each(|(&v, &on)| roots[v as usize] = on);
            }
        }
        roots
    }

    pub fn demand_vertex(&self, VertexId { layer, vertex }: VertexId) -> Result<(), HairMeshError> {
        let there = self.layers.get(layer).is_some_and(|l| (vertex as usize) < l.vertices.len());
        if there { Ok(()) } else { Err(HairMeshError::NoVertex { layer, vertex }) }
    }

    /// Append a bundle without faces.
    pub fn push_bundle(&mut self) -> usize {
        self.layers.iter_mut().for_each(|layer| layer.faces.push(None));
        self.n_bundles() - 1
    }

    /// Append a layer without faces.
    pub fn push_layer(&mut self) {
        let faces = vec![None; self.n_bundles()];
        self.layers.push(WorkLayer { vertices: Vec::new(), faces });
    }

    /// The hair mesh again, without vertices that no face uses and without empty layers, checked.
    pub fn finish(mut self) -> Result<(HairMesh, Report), HairMeshError> {
        while self.layers.len() > 1 && self.layers.last().is_some_and(|layer| layer.faces.iter().all(Option::is_none)) {
            self.layers.pop();
        }
        let mut report = Report {
            new_vertices: Vec::new(),
            new_bundles: (self.n_bundles_before..self.n_bundles()).collect(),
            renumbered: self.n_vertices_before.iter().map(|&n| vec![None; n]).collect(),
        };
        let mut mesh = HairMesh { layers: Vec::with_capacity(self.layers.len()) };
        let mut now: HashMap<VertexId, VertexId> = HashMap::new();
        for (layer, WorkLayer { vertices, mut faces }) in self.layers.into_iter().enumerate() {
            let mut used = vec![false; vertices.len()];
            faces.iter().flatten().flatten().for_each(|&v| used[v as usize] = true);
            let mut new_index = vec![u32::MAX; vertices.len()];
            let mut positions = Vec::with_capacity(vertices.len());
            let mut pinned = Vec::new();
            for (old, vertex) in vertices.iter().enumerate().filter(|(old, _)| used[*old]) {
                let id = VertexId { layer, vertex: positions.len() as u32 };
                new_index[old] = id.vertex;
                positions.push(vertex.position);
                pinned.extend(vertex.pinned.then_some(id.vertex));
                match vertex.origin {
                    Origin::Kept(was) => report.renumbered[was.layer][was.vertex as usize] = Some(id),
                    Origin::CopyOf(was) => report.new_vertices.push(NewVertex { id, copy_of: Some(was) }),
                    Origin::New => report.new_vertices.push(NewVertex { id, copy_of: None }),
                }
                if !self.merged.is_empty() {
                    now.insert(VertexId { layer, vertex: old as u32 }, id);
                }
            }
            faces.iter_mut().flatten().flatten().for_each(|v| *v = new_index[*v as usize]);
            mesh.layers.push(HairMeshLayer { positions, faces, pinned });
        }
        for (was, became) in self.merged {
            report.renumbered[was.layer][was.vertex as usize] = now.get(&became).copied();
        }
        mesh.check()?;
        Ok((mesh, report))
    }
}

/// An edge of a layer, with its lower end first.
pub(super) fn edge_of(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The edges around a face, each from corner `i` to the next.
pub(super) fn edges(face: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    (0..face.len()).map(|i| [face[i], face[(i + 1) % face.len()]])
}
