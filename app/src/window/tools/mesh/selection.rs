//! What is selected of a hair mesh: vertices, edges or faces, and how one becomes the other.

use std::collections::BTreeSet;

use lorelei_core::hair_mesh::select::{self, FaceId, Links, all_faces, corners};
use lorelei_core::hair_mesh::{EdgeId, HairMesh, Report, VertexId};

use super::commands::MeshCommand;

/// What a click takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Element {
    #[default]
    Vertices,
    Edges,
    Faces,
}

impl Element {
    pub const ALL: [Self; 3] = [Self::Vertices, Self::Edges, Self::Faces];

    pub fn label(self) -> &'static str {
        match self {
            Self::Vertices => "Vertices",
            Self::Edges => "Edges",
            Self::Faces => "Faces",
        }
    }
}

/// How what is clicked joins what is selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Join {
    Replace,
    Add,
    Remove,
    /// Out where it is in, in where it is out.
    Toggle,
}

/// The selection. Vertices are always those of the selected edges and faces too.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshSelection {
    pub element: Element,
    pub vertices: BTreeSet<VertexId>,
    /// Pairs of vertices, the lower first: within a layer or from one to the next.
    pub edges: BTreeSet<[VertexId; 2]>,
    pub faces: BTreeSet<FaceId>,
}

/// Something under the pointer or in a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Picked {
    Vertex(VertexId),
    Edge([VertexId; 2]),
    Face(FaceId),
}

impl MeshSelection {
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    pub fn clear(&mut self) {
        *self = Self { element: self.element, ..Self::default() };
    }

    /// Take other elements; what is selected stays as far as they have it wholly.
    pub fn take(&mut self, element: Element, mesh: &HairMesh) {
        let vertices = std::mem::take(&mut self.vertices);
        *self = Self { element, ..Self::default() };
        self.select_vertices(mesh, vertices);
    }

    /// Select what lies wholly within a set of vertices.
    pub fn select_vertices(&mut self, mesh: &HairMesh, vertices: BTreeSet<VertexId>) {
        self.edges.clear();
        self.faces.clear();
        match self.element {
            Element::Vertices => self.vertices = vertices,
            Element::Edges => {
                let has_both = |edge: &[VertexId; 2]| edge.iter().all(|end| vertices.contains(end));
                self.edges = all_edges(mesh).filter(has_both).collect();
                self.update_vertices(mesh);
            }
            Element::Faces => {
                let is_whole = |face: &FaceId| corners(mesh, *face).all(|corner| vertices.contains(&corner));
                self.faces = all_faces(mesh).filter(is_whole).collect();
                self.update_vertices(mesh);
            }
        }
    }

    /// Join what was picked.
    pub fn join(&mut self, mesh: &HairMesh, picked: &[Picked], join: Join) {
        if join == Join::Replace {
            self.clear();
        }
        for &one in picked {
            match one {
                Picked::Vertex(id) => put(&mut self.vertices, id, join),
                Picked::Edge(edge) => put(&mut self.edges, edge, join),
                Picked::Face(face) => put(&mut self.faces, face, join),
            }
        }
        self.update_vertices(mesh);
    }

    fn update_vertices(&mut self, mesh: &HairMesh) {
        match self.element {
            Element::Vertices => {}
            Element::Edges => self.vertices = self.edges.iter().flatten().copied().collect(),
            Element::Faces => {
                self.vertices = self.faces.iter().flat_map(|&face| corners(mesh, face)).collect();
            }
        }
    }

    /// Forget what the mesh does not have (any more).
    pub fn keep_what_is_there(&mut self, mesh: &HairMesh) {
        let is_there = |id: &VertexId| mesh.position(*id).is_some();
        if self.vertices.iter().all(is_there)
            && self.faces.iter().all(|face| mesh.face(face.layer, face.bundle).is_some())
        {
            return;
        }
        self.vertices.retain(is_there);
        self.edges.retain(|edge| edge.iter().all(is_there));
        self.faces.retain(|face| mesh.face(face.layer, face.bundle).is_some());
        self.update_vertices(mesh);
    }

    /// Go along with an operation: what it made is selected, or else what was selected before.
    pub fn follow(&mut self, mesh: &HairMesh, report: &Report, selects_new: bool) {
        let new: BTreeSet<VertexId> = report.new_vertices.iter().map(|new| new.id).collect();
        if selects_new && !new.is_empty() {
            self.select_vertices(mesh, new);
            return;
        }
        let kept: BTreeSet<VertexId> = self.vertices.iter().filter_map(|&id| report.now(id)).collect();
        let faces: BTreeSet<FaceId> =
            self.faces.iter().copied().filter(|face| mesh.face(face.layer, face.bundle).is_some()).collect();
        self.select_vertices(mesh, kept);
        if self.element == Element::Faces && self.faces.is_empty() {
            self.faces = faces;
            self.update_vertices(mesh);
        }
    }

    /// Grow, shrink or follow the mesh from what is selected; says why where that has no meaning.
    pub fn spread(&mut self, mesh: &HairMesh, command: MeshCommand) -> Result<(), &'static str> {
        let links = Links::of(mesh);
        let is_faces = self.element == Element::Faces;
        let vertices = match command {
            MeshCommand::Grow if is_faces => select::vertices_of_faces(mesh, &select::grow_faces(mesh, &self.faces)),
            MeshCommand::Shrink if is_faces => {
                self.faces = select::shrink_faces(mesh, &self.faces);
                self.update_vertices(mesh);
                return Ok(());
            }
            MeshCommand::Grow => links.grow(&self.vertices),
            MeshCommand::Shrink => links.shrink(&self.vertices),
            MeshCommand::Linked => links.linked(&self.vertices),
            MeshCommand::Bundle => {
                let bundles: BTreeSet<usize> =
                    self.vertices.iter().flat_map(|&id| mesh.faces_at(id).map(|(bundle, _)| bundle)).collect();
                let bundles = if is_faces { self.faces.iter().map(|face| face.bundle).collect() } else { bundles };
                select::vertices_of_faces(mesh, &select::faces_of_bundles(mesh, &bundles))
            }
            MeshCommand::Layer => {
                let layers: BTreeSet<usize> = self.vertices.iter().map(|id| id.layer).collect();
                let faces = layers.iter().flat_map(|&layer| select::faces_of_layer(mesh, layer)).collect();
                select::vertices_of_faces(mesh, &faces)
            }
            MeshCommand::Loop | MeshCommand::Ring => return self.follow_edges(mesh, &links, command),
            _ => return Ok(()),
        };
        self.select_vertices(mesh, vertices);
        Ok(())
    }

    /// The loops or rings of the selected edges; without an edge, the hair through each selected vertex.
    fn follow_edges(&mut self, mesh: &HairMesh, links: &Links, command: MeshCommand) -> Result<(), &'static str> {
        if self.element == Element::Faces {
            return Err("loops and rings are of edges: take edges (2) or vertices (1) first");
        }
        let within: Vec<EdgeId> = self.edges_within(mesh);
        let mut vertices = self.vertices.clone();
        if command == MeshCommand::Ring {
            let ring: BTreeSet<EdgeId> = within.iter().flat_map(|&edge| links.edge_ring(mesh, edge)).collect();
            vertices.extend(ring.iter().flat_map(|edge| edge.vertices()));
            if self.element == Element::Edges {
                self.edges.extend(ring.iter().map(|edge| edge.vertices()));
                self.update_vertices(mesh);
                return Ok(());
            }
        } else if within.is_empty() {
            vertices.extend(self.vertices.iter().flat_map(|&id| links.chain(id)));
        } else {
            let along: BTreeSet<EdgeId> = within.iter().flat_map(|&edge| links.edge_loop(edge)).collect();
            vertices.extend(along.iter().flat_map(|edge| edge.vertices()));
        }
        self.select_vertices(mesh, vertices);
        Ok(())
    }

    /// Bundles that have a selected face, or all their tip's corners selected; rising.
    pub fn bundles(&self, mesh: &HairMesh) -> Vec<usize> {
        let mut bundles: Vec<usize> = match self.element {
            Element::Faces => self.faces.iter().map(|face| face.bundle).collect(),
            Element::Vertices | Element::Edges => all_faces(mesh)
                .filter(|face| corners(mesh, *face).all(|corner| self.vertices.contains(&corner)))
                .map(|face| face.bundle)
                .collect(),
        };
        bundles.sort_unstable();
        bundles.dedup();
        bundles
    }

    /// The topmost layer that has something selected.
    pub fn layer(&self) -> Option<usize> {
        self.vertices.iter().map(|id| id.layer).max()
    }

    /// Selected edges within layers.
    pub fn edges_within(&self, mesh: &HairMesh) -> Vec<EdgeId> {
        let edge = |[a, b]: [VertexId; 2]| (a.layer == b.layer).then(|| EdgeId::new(a.layer, a.vertex, b.vertex));
        match self.element {
            Element::Edges => self.edges.iter().filter_map(|&ends| edge(ends)).collect(),
            Element::Vertices | Element::Faces => all_edges(mesh)
                .filter(|ends| ends.iter().all(|end| self.vertices.contains(end)))
                .filter_map(edge)
                .collect(),
        }
    }
}

fn put<T: Ord + Copy>(set: &mut BTreeSet<T>, one: T, join: Join) {
    match join {
        Join::Replace | Join::Add => {
            set.insert(one);
        }
        Join::Remove => {
            set.remove(&one);
        }
        Join::Toggle => {
            if !set.remove(&one) {
                set.insert(one);
            }
        }
    }
}

/// Every edge, some of them more than once.
fn all_edges(mesh: &HairMesh) -> impl Iterator<Item = [VertexId; 2]> {
    all_faces(mesh).flat_map(move |face| {
        let above: Vec<VertexId> = corners(mesh, face).collect();
        let below: Vec<VertexId> = match face.layer.checked_sub(1) {
            Some(layer) => corners(mesh, FaceId { layer, ..face }).collect(),
            None => Vec::new(),
        };
        let n = above.len();
        let within: Vec<[VertexId; 2]> =
            (0..n).map(|i| [above[i].min(above[(i + 1) % n]), above[i].max(above[(i + 1) % n])]).collect();
        let between: Vec<[VertexId; 2]> = below.into_iter().zip(above).map(|(a, b)| [a, b]).collect();
        within.into_iter().chain(between)
    })
}
