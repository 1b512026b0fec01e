//! Everything that can be done to a hair mesh (Yuksel, Schaefer and Keyser 2009, sections 3.2 and 3.3), as
//! plain data that can be saved and replayed.
//!
//! Vertices, edges and bundles are named by their places; [`Report`] says where they went, so that a
//! selection survives an operation.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::symmetry::Side;
use super::work::{Work, edge_of};
use super::{Along, HairMesh, HairMeshError, Weld};

/// A vertex by its layer and its index there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct VertexId {
    pub layer: usize,
    pub vertex: u32,
}

/// An edge of a face within its layer, by the vertices at its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct EdgeId {
    pub layer: usize,
    /// The lower index first.
    pub ends: [u32; 2],
}

impl EdgeId {
    pub fn new(layer: usize, a: u32, b: u32) -> Self {
        Self { layer, ends: edge_of(a, b) }
    }

    pub fn vertices(self) -> [VertexId; 2] {
        self.ends.map(|vertex| VertexId { layer: self.layer, vertex })
    }
}

/// How a face is divided, with its whole bundle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaceCut {
    /// In two, from one corner of the face to another.
    Corners(usize, usize),
    /// In triangles around a vertex in the middle; neighbours stay as they are.
    Fan,
    /// In quads around a vertex in the middle; neighbours get a corner in the middle of the shared edge.
    Quads,
}

/// A subdivision scheme. All keep the root layer's vertices where they are, on the scalp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scheme {
    /// Every polygon in quads, smoothed (Catmull and Clark 1978).
    CatmullClark,
    /// Every triangle in four, smoothed (Loop 1987).
    Loop,
    /// Every polygon in quads, nothing moves.
    Linear,
}

/// One operation. Bundles, vertices and edges are lists in any order; lengths in centimetres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum MeshOp {
    /// Extrude the tip faces by `length_cm` in `n_layers` equal steps. Neighbours that are extruded
    /// together share vertices.
    Extrude { bundles: Vec<usize>, along: Along, length_cm: f32, n_layers: u32, weld: Weld },
    /// Delete the tip faces; at the root, the bundle.
    DeleteTips { bundles: Vec<usize> },
    /// Delete bundles from tip to root: no hair grows there, and their indices stay free.
    DeleteBundles { bundles: Vec<usize> },
    /// A new layer below `layer`, at the share `at` (0-1) of the way up from the layer before it, in all
    /// bundles that are connected with these in `layer`.
    InsertLayer { bundles: Vec<usize>, layer: usize, at: f32 },
    /// Remove `layer` from all bundles that are connected with these in it.
    RemoveLayer { bundles: Vec<usize>, layer: usize },
    /// Every face gets its own copy of each vertex, in its layer and above.
    SeparateVertices { vertices: Vec<VertexId> },
    /// Open the mesh along edges, in their layers and above.
    SeparateEdges { edges: Vec<EdgeId> },
    /// Join the vertices that stand on one root vertex, in their layers and below.
    WeldVertices { vertices: Vec<VertexId> },
    /// Join the edges that stand on one root edge, in their layers and below.
    WeldEdges { edges: Vec<EdgeId> },
    /// Divide a bundle's face in every layer.
    DivideFace { bundle: usize, cut: FaceCut },
    /// Put a vertex into an edge, at the share `at` (0-1) from its first end, in every layer and every
    /// face on the same root edge.
    DivideEdge { edge: EdgeId, at: f32 },
    /// Subdivide bundles, or all where the list is empty. Neighbours get corners on the shared edges.
    Subdivide { bundles: Vec<usize>, scheme: Scheme },
    /// Pinned vertices stay where they are when the inside is relaxed.
    SetPinned { vertices: Vec<VertexId>, pinned: bool },
    /// Place all inner vertices that are not pinned.
    Relax,
    /// Move vertices towards the middle of their neighbours by the share `strength` (0-1), `n_times`.
    /// The root layer stays.
    SmoothVertices { vertices: Vec<VertexId>, strength: f32, n_times: u32 },
    /// Make the other side of X = 0 the mirror image of `from`. What lies within `tolerance_cm` of the plane
    /// belongs to both sides.
    Mirror { from: Side, tolerance_cm: f32 },
}

/// A vertex that was not there before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NewVertex {
    pub id: VertexId,
    /// The vertex that it was copied or extruded from, in the numbers before the operation.
    pub copy_of: Option<VertexId>,
}

/// What an operation did to the places of things.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Report {
    /// In order of layer and index.
    pub new_vertices: Vec<NewVertex>,
    pub new_bundles: Vec<usize>,
    /// Per layer and vertex before the operation: where it is now. Bundles keep their numbers.
    pub renumbered: Vec<Vec<Option<VertexId>>>,
}

impl Report {
    /// Where a vertex from before the operation is now; `None` where it is gone.
    pub fn now(&self, was: VertexId) -> Option<VertexId> {
        *self.renumbered.get(was.layer)?.get(was.vertex as usize)?
    }
}

impl HairMesh {
    /// Do one operation. On an error the mesh is as it was.
    pub fn apply(&mut self, op: &MeshOp) -> Result<Report, HairMeshError> {
        debug_assert_eq!(self.check(), Ok(()), "an operation begins with a hair mesh");
        let mut work = Work::on(self);
        match op {
            MeshOp::Extrude { bundles, along, length_cm, n_layers, weld } => {
                work.extrude_along(bundles, along, *length_cm, *n_layers, *weld)?;
            }
            MeshOp::DeleteTips { bundles } => work.delete_tips(bundles)?,
            MeshOp::DeleteBundles { bundles } => work.delete_bundles(bundles)?,
            MeshOp::InsertLayer { bundles, layer, at } => work.insert_layer(bundles, *layer, *at)?,
            MeshOp::RemoveLayer { bundles, layer } => work.remove_layer(bundles, *layer)?,
            MeshOp::SeparateVertices { vertices } => work.separate_vertices(vertices)?,
            MeshOp::SeparateEdges { edges } => work.separate_edges(edges)?,
            MeshOp::WeldVertices { vertices } => work.weld_vertices(vertices)?,
            MeshOp::WeldEdges { edges } => work.weld_edges(edges)?,
            MeshOp::DivideFace { bundle, cut } => work.divide_face(*bundle, *cut)?,
            MeshOp::DivideEdge { edge, at } => work.divide_edge(*edge, *at)?,
            MeshOp::Subdivide { bundles, scheme } => work.subdivide(bundles, *scheme)?,
            MeshOp::SetPinned { vertices, pinned } => {
                demand_any(vertices, "vertices")?;
                for &id in vertices {
                    work.demand_vertex(id)?;
                    work.layers[id.layer].vertices[id.vertex as usize].pinned = *pinned;
                }
            }
            MeshOp::Relax => {
                let mut relaxed = self.clone();
                relaxed.relax_inside();
                for (layer, relaxed) in work.layers.iter_mut().zip(&relaxed.layers) {
                    layer.vertices.iter_mut().zip(&relaxed.positions).for_each(|(v, &p)| v.position = p);
                }
            }
            MeshOp::SmoothVertices { vertices, strength, n_times } => {
                work.smooth(vertices, *strength, *n_times)?;
            }
            MeshOp::Mirror { from, tolerance_cm } => work.mirror(*from, *tolerance_cm)?,
        }
        let (mesh, report) = work.finish()?;
        *self = mesh;
        Ok(report)
    }

    /// Put vertices at places and return the moves that put them back. On an error nothing has moved.
    pub fn put_vertices(
        mesh: &mut Arc<Self>,
        moves: Vec<(VertexId, Vec3)>,
    ) -> Result<Vec<(VertexId, Vec3)>, HairMeshError> {
        for &(id @ VertexId { layer, vertex }, place) in &moves {
            if mesh.position(id).is_none() {
                return Err(HairMeshError::NoVertex { layer, vertex });
            }
            if !place.is_finite() {
                return Err(HairMeshError::NotFinite { layer, vertex });
            }
        }
        let mesh = Arc::make_mut(mesh);
        let mut back = Vec::with_capacity(moves.len());
        for (id, place) in moves {
            let position = &mut mesh.layers[id.layer].positions[id.vertex as usize];
            back.push((id, std::mem::replace(position, place)));
        }
        // A vertex that is named twice goes back to its first place last.
        back.reverse();
        Ok(back)
    }

    pub fn position(&self, VertexId { layer, vertex }: VertexId) -> Option<Vec3> {
        self.layers.get(layer)?.positions.get(vertex as usize).copied()
    }

    pub fn is_pinned(&self, VertexId { layer, vertex }: VertexId) -> bool {
        self.layers.get(layer).is_some_and(|layer| layer.pinned.binary_search(&vertex).is_ok())
    }
}

/// `needed` in the plural, for the message.
pub(super) fn demand_any<T>(selected: &[T], needed: &'static str) -> Result<(), HairMeshError> {
    if selected.is_empty() { Err(HairMeshError::NothingSelected { needed }) } else { Ok(()) }
}

/// A share from 0 to 1 without its ends.
pub(super) fn demand_share(at: f32) -> Result<(), HairMeshError> {
    if at > 0.0 && at < 1.0 {
        Ok(())
    } else {
        Err(HairMeshError::OutOfRange { what: "the share of the way", min: "0", max: "1" })
    }
}
