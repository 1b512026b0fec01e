//! What the tool's commands do: operations on the hair mesh as edits, told where they are refused.

use std::sync::Arc;

use lorelei_core::edit::Edit;
use lorelei_core::groom::{Layer, Source};
use lorelei_core::hair_mesh::select::{FaceId, Links, soft_weights};
use lorelei_core::hair_mesh::symmetry::{MIRROR_TOLERANCE_CM, MirrorPairs, Side};
use lorelei_core::hair_mesh::{Along, FaceCut, HairMesh, MeshOp, OuterSurface, VertexDrag, VertexId, VertexMotion};
use lorelei_core::history::Merge;
use lorelei_core::style::presets::presets;

use super::commands::MeshCommand;
use super::grab::{Grab, GrabKind};
use super::selection::{Element, Join, MeshSelection, Picked};
use super::settings::Settings;
use super::{LastOp, MeshTool};
use crate::window::commands::Command;
use crate::window::desk::{Desk, Selection};

/// The hair mesh that the tool works on, and its layer: the selected layer's, or else the first one's.
pub fn target(desk: &Desk) -> Option<(usize, Arc<HairMesh>)> {
    let layers = &desk.document.groom.layers;
    let mesh_of = |layer_idx: usize| match &layers.get(layer_idx)?.source {
        Source::HairMesh(mesh) => Some((layer_idx, Arc::clone(mesh))),
        Source::Guides(_) | Source::Strands(_) => None,
    };
    match desk.selection {
        Selection::Layer(layer_idx) => mesh_of(layer_idx),
        Selection::Head | Selection::Light(_) | Selection::Collider(_) | Selection::Pin(_) | Selection::Wind(_) => None,
    }
    .or_else(|| (0..layers.len()).find_map(mesh_of))
}

impl MeshTool {
    /// Whether a command has something to work on.
    pub fn is_enabled(&self, desk: &Desk, command: MeshCommand) -> bool {
        let needs_selection = !matches!(
            command,
            MeshCommand::Vertices
                | MeshCommand::Edges
                | MeshCommand::Faces
                | MeshCommand::SelectAll
                | MeshCommand::SelectNone
                | MeshCommand::Invert
                | MeshCommand::Subdivide
                | MeshCommand::Relax
                | MeshCommand::Mirror
                | MeshCommand::ToggleSoft
                | MeshCommand::ToggleInside
                | MeshCommand::ToggleXRay
                | MeshCommand::PushBrush
        );
        target(desk).is_some() && (!needs_selection || !self.selection.is_empty())
    }

    pub fn run(&mut self, desk: &mut Desk, command: MeshCommand) {
        let Some((layer_idx, mesh)) = target(desk) else { return };
        self.cage.update(&mesh);
        self.selection.keep_what_is_there(&mesh);
        let settings = &self.settings;
        let vertices = || self.selection.vertices.iter().copied().collect::<Vec<VertexId>>();
        let bundles = || self.selection.bundles(&mesh);
        let op = match command {
            MeshCommand::Vertices => return self.selection.take(Element::Vertices, &mesh),
            MeshCommand::Edges => return self.selection.take(Element::Edges, &mesh),
            MeshCommand::Faces => return self.selection.take(Element::Faces, &mesh),
            MeshCommand::SelectAll => {
                let all = self.cage.everything(self.selection.element);
                return self.selection.join(&mesh, &all, Join::Replace);
            }
            MeshCommand::SelectNone => return self.selection.clear(),
            MeshCommand::Invert => {
                let all = self.cage.everything(self.selection.element);
                return self.selection.join(&mesh, &all, Join::Toggle);
            }
            MeshCommand::Grow
            | MeshCommand::Shrink
            | MeshCommand::Loop
            | MeshCommand::Ring
            | MeshCommand::Bundle
            | MeshCommand::Layer
            | MeshCommand::Linked => {
                if let Err(why) = self.selection.spread(&mesh, command) {
                    self.refuse(why);
                }
                return;
            }
            MeshCommand::Move => return self.grab(&mesh, GrabKind::Move),
            MeshCommand::Rotate => return self.grab(&mesh, GrabKind::Rotate),
            MeshCommand::Scale => return self.grab(&mesh, GrabKind::Scale),
            MeshCommand::Slide => return self.grab(&mesh, GrabKind::Slide),
            MeshCommand::Extend => return self.grab(&mesh, GrabKind::Extend),
            MeshCommand::ToggleSoft => return self.settings.is_soft ^= true,
            MeshCommand::ToggleInside => return self.settings.display.shows_inside ^= true,
            MeshCommand::ToggleXRay => return self.settings.display.is_x_ray ^= true,
            MeshCommand::PushBrush => return self.settings.is_pushing ^= true,
            MeshCommand::SnapToHead => return self.snap(desk, layer_idx, &mesh),
            MeshCommand::Extrude | MeshCommand::ExtrudeDown => MeshOp::Extrude {
                bundles: bundles(),
                along: match command {
                    MeshCommand::ExtrudeDown => Along::Gravity { pull: settings.pull },
                    _ => settings.along(),
                },
                length_cm: settings.length,
                n_layers: settings.n_layers,
                weld: settings.weld,
            },
            MeshCommand::DeleteTips => MeshOp::DeleteTips { bundles: bundles() },
            MeshCommand::DeleteBundles => MeshOp::DeleteBundles { bundles: bundles() },
            MeshCommand::InsertLayer => {
                let layer = self.selection.layer().unwrap_or(0);
                MeshOp::InsertLayer { bundles: self.bundles_in(&mesh, layer), layer, at: settings.at }
            }
            MeshCommand::RemoveLayer => {
                let layer = self.selection.layer().unwrap_or(0);
                MeshOp::RemoveLayer { bundles: self.bundles_in(&mesh, layer), layer }
            }
            MeshCommand::Separate => match self.selection.element {
                Element::Vertices => MeshOp::SeparateVertices { vertices: vertices() },
                Element::Edges | Element::Faces => MeshOp::SeparateEdges { edges: self.selection.edges_within(&mesh) },
            },
            MeshCommand::Weld => match self.selection.element {
                Element::Vertices => MeshOp::WeldVertices { vertices: vertices() },
                Element::Edges | Element::Faces => MeshOp::WeldEdges { edges: self.selection.edges_within(&mesh) },
            },
            MeshCommand::DivideFace => self.division(&mesh),
            MeshCommand::DivideEdge => match self.selection.edges_within(&mesh).first() {
                Some(&edge) => MeshOp::DivideEdge { edge, at: settings.at },
                None => return self.refuse("an edge within a layer must be selected: take edges (2) and click one"),
            },
            MeshCommand::Subdivide => MeshOp::Subdivide { bundles: bundles(), scheme: settings.scheme },
            MeshCommand::Relax => MeshOp::Relax,
            MeshCommand::Smooth => {
                MeshOp::SmoothVertices { vertices: vertices(), strength: settings.smoothing, n_times: 1 }
            }
            MeshCommand::Pin => MeshOp::SetPinned { vertices: vertices(), pinned: true },
            MeshCommand::Unpin => MeshOp::SetPinned { vertices: vertices(), pinned: false },
            MeshCommand::Mirror => MeshOp::Mirror { from: Side::PlusX, tolerance_cm: MIRROR_TOLERANCE_CM },
        };
        let is_extrusion = matches!(op, MeshOp::Extrude { .. });
        self.do_op(desk, layer_idx, Command::Mesh(command).row().label, op);
        if is_extrusion
            && self.refusal.is_none()
            && let Some((_, mesh)) = target(desk)
        {
            self.cage.update(&mesh);
            self.grab(&mesh, GrabKind::Extend);
        }
    }

    /// Do an operation as a step of its own, or say why not.
    pub fn do_op(&mut self, desk: &mut Desk, layer_idx: usize, label: &str, op: MeshOp) {
        self.refusal = None;
        let Some(Source::HairMesh(mesh)) = desk.document.groom.layers.get(layer_idx).map(|layer| &layer.source) else {
            return;
        };
        let ops = if self.settings.is_symmetric {
            MirrorPairs::of(mesh, MIRROR_TOLERANCE_CM).with_mirror(&op)
        } else {
            vec![op.clone()]
        };
        let selects_new = matches!(
            op,
            MeshOp::Extrude { .. } | MeshOp::InsertLayer { .. } | MeshOp::DivideFace { .. } | MeshOp::DivideEdge { .. }
        );
        // Tried on a copy first: what is refused must not leave half of it done.
        let mut changed = HairMesh::clone(mesh);
        let mut selection = self.selection.clone();
        for op in &ops {
            match changed.apply(op) {
                Ok(report) => selection.follow(&changed, &report, selects_new),
                Err(why) => return self.refuse(&why.to_string()),
            }
        }
        let mut edits: Vec<Edit> = ops.into_iter().map(|op| Edit::HairMesh { layer_idx, op }).collect();
        let edit = if edits.len() == 1 { edits.remove(0) } else { Edit::Batch(edits) };
        desk.document.edit(label, edit, Merge::New);
        let before = std::mem::replace(&mut self.selection, selection);
        self.last = Some(LastOp { layer_idx, label: label.to_owned(), op, before, state: desk.document.state() });
    }

    /// Do the last operation again with other numbers.
    pub fn redo_last(&mut self, desk: &mut Desk, op: MeshOp) {
        let Some(last) = self.last.take().filter(|last| last.state == desk.document.state()) else { return };
        desk.document.undo();
        self.selection = last.before;
        self.do_op(desk, last.layer_idx, &last.label, op);
    }

    /// Show a reason beside the pointer.
    pub fn refuse(&mut self, why: &str) {
        self.refusal = Some((why.to_owned(), std::time::Instant::now()));
    }

    fn bundles_in(&self, mesh: &HairMesh, layer: usize) -> Vec<usize> {
        let mut bundles: Vec<usize> = self
            .selection
            .vertices
            .iter()
            .filter(|id| id.layer == layer)
            .flat_map(|&id| mesh.faces_at(id).map(|(bundle, _)| bundle))
            .collect();
        bundles.sort_unstable();
        bundles.dedup();
        bundles
    }

    /// Between two selected corners of one face, or of whole faces into quads.
    fn division(&self, mesh: &HairMesh) -> MeshOp {
        let selected: Vec<VertexId> = self.selection.vertices.iter().copied().collect();
        if let [a, b] = selected[..]
            && self.selection.element == Element::Vertices
        {
            let of_b: Vec<(usize, usize)> = mesh.faces_at(b).collect();
            let both = mesh.faces_at(a).filter(|_| a.layer == b.layer);
            let found =
                both.filter_map(|(bundle, i)| Some((bundle, i, of_b.iter().find(|(other, _)| *other == bundle)?.1)));
            if let Some((bundle, i, j)) = found.into_iter().next() {
                return MeshOp::DivideFace { bundle, cut: FaceCut::Corners(i, j) };
            }
        }
        let bundles = self.selection.bundles(mesh);
        match bundles[..] {
            [bundle] => MeshOp::DivideFace { bundle, cut: FaceCut::Quads },
            _ => MeshOp::Subdivide { bundles, scheme: lorelei_core::hair_mesh::Scheme::Linear },
        }
    }

    fn snap(&mut self, desk: &mut Desk, layer_idx: usize, mesh: &Arc<HairMesh>) {
        let Some(head) = self.head.clone() else { return self.refuse("there is no head to snap to") };
        let mut drag = self.drag_of(mesh, false);
        let places = drag.onto(&head, self.settings.clearance, self.settings.relaxes);
        desk.document.edit("Snap to the head", Edit::MoveVertices { layer_idx, moves: places }, Merge::New);
    }

    /// Take hold of what is selected.
    pub fn drag_of(&self, mesh: &Arc<HairMesh>, is_soft: bool) -> VertexDrag {
        let selected: Vec<VertexId> = self.selection.vertices.iter().copied().collect();
        // The inside follows by being placed anew.
        let soft = is_soft.then(|| {
            let Settings { soft_radius, soft_falloff, soft_reach, .. } = self.settings;
            let links = Links::of(mesh);
            let mut all = soft_weights(mesh, &links, &self.selection.vertices, soft_radius, soft_falloff, soft_reach);
            all.retain(|id, _| self.cage.outer.vertices.binary_search(id).is_ok());
            all
        });
        let pairs = self.settings.is_symmetric.then(|| MirrorPairs::of(mesh, MIRROR_TOLERANCE_CM));
        VertexDrag::new(mesh, &selected, soft.into_iter().flatten(), |id| pairs.as_ref()?.vertex(id))
    }

    pub fn grab(&mut self, mesh: &Arc<HairMesh>, kind: GrabKind) {
        let drag = self.drag_of(mesh, self.settings.is_soft);
        if !drag.is_empty() {
            self.n_grabs += 1;
            self.grab = Some(Grab::new(kind, drag));
        }
    }

    /// Show where a grab takes everything, as one growing step.
    pub fn move_to(&mut self, desk: &mut Desk, layer_idx: usize, motion: VertexMotion) {
        let Some(mut grab) = self.grab.take() else { return };
        let moves = grab.drag.places(motion, self.limits());
        let label = format!("{} {} vertices", grab.kind.label(), grab.drag.weights().len());
        // All of a drag's steps move the same vertices, so that they join.
        let merge = Merge::Drag(DRAGS + self.n_grabs);
        desk.document.edit(&label, Edit::MoveVertices { layer_idx, moves }, merge);
        self.has_moved = true;
        self.grab = Some(grab);
    }
}

/// Numbers of this tool's drags, away from those of panels.
pub const DRAGS: u64 = 1 << 40;

/// A new layer whose hair mesh stands on the scalp; its root faces are selected.
pub fn new_on_scalp(tool: &mut MeshTool, desk: &mut Desk) {
    let Some(head) = desk.document.groom.head.clone() else {
        return tool.refuse("there is no head: import one, or use the mannequin");
    };
    match HairMesh::on_scalp(&head.mesh, &head.mesh.scalp_triangles(), tool.settings.new_spacing) {
        Ok(mesh) => {
            let layer_idx = desk.document.groom.layers.len();
            let mut layer = Layer::new("Hair mesh", Source::HairMesh(Arc::new(mesh.clone())));
            // Hair without any style looks like plastic; the artist goes on from here.
            if let Some(plain) = presets().first() {
                layer.style = plain.for_strands(layer.n_strands);
            }
            let edit = Edit::AddLayer { layer_idx, layer: Box::new(layer) };
            desk.document.edit("New hair mesh", edit, Merge::New);
            desk.selection = Selection::Layer(layer_idx);
            tool.selection = MeshSelection { element: Element::Faces, ..MeshSelection::default() };
            let roots = OuterSurface::of(&mesh).faces.into_iter();
            let roots: Vec<Picked> =
                roots.map(|face| Picked::Face(FaceId { layer: face.layer, bundle: face.bundle })).collect();
            tool.selection.join(&mesh, &roots, Join::Replace);
        }
        Err(why) => tool.refuse(&why.to_string()),
    }
}
