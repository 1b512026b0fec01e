//! What edits hold: heads, which are written down by their names, and memory that they share with the groom.

use std::sync::Arc;

use super::Edit;
use crate::groom::{Head, Source};
use crate::maps::Tile;
use crate::sculpt::SculptGuide;

impl Edit {
    /// The edit as it is written down: a head that is embedded in the studio by its name, without its mesh.
    /// Whoever reads it puts the mesh back with [`Edit::visit_heads`].
    pub fn with_named_heads(mut self) -> Self {
        self.visit_heads(&mut |head| {
            if head.embedded.is_some() {
                head.mesh = Arc::default();
            }
        });
        self
    }

    /// Call `visit` with every head that the edit puts on.
    pub fn visit_heads(&mut self, visit: &mut dyn FnMut(&mut Head)) {
        if let Self::SetHead(Some(head)) = self {
            visit(head);
        } else if let Self::Batch(edits) = self {
            for edit in edits {
                edit.visit_heads(visit);
            }
        }
    }

    /// Call `visit` with the address and the bytes of everything large that the edit keeps alive.
    pub fn visit_shared(&self, visit: &mut dyn FnMut(usize, usize)) {
        match self {
            Self::SetHead(Some(head)) => {
                let mesh = &head.mesh;
                let n_bytes = mesh.positions.len() * 24 + mesh.uvs.len() * 8 + mesh.triangles.len() * 16;
                visit(Arc::as_ptr(mesh) as usize, n_bytes);
            }
            Self::AddLayer { layer, .. } | Self::SetLayer { layer, .. } => {
                visit_source(&layer.source, visit);
                layer.maps.values().for_each(|map| map.visit_shared(visit));
                visit(Arc::as_ptr(&layer.sculpt.roots) as usize, layer.sculpt.roots.n_bytes());
                for sculpt in &layer.sculpt.layers {
                    visit(Arc::as_ptr(&sculpt.strokes) as usize, sculpt.strokes.n_bytes());
                }
            }
            Self::Sculpt { changes, .. } => {
                for guide in changes.iter().filter_map(|change| change.to.as_ref()) {
                    visit(std::ptr::from_ref(&**guide) as usize, size_of::<SculptGuide>());
                }
            }
            Self::SetSculptRoots { roots, .. } => visit(Arc::as_ptr(roots) as usize, roots.n_bytes()),
            Self::AddSculpt { sculpt, .. } => {
                visit(Arc::as_ptr(&sculpt.strokes) as usize, sculpt.strokes.n_bytes());
            }
            Self::Stroke { stroke, .. } => {
                visit(std::ptr::from_ref(&**stroke) as usize, size_of_val(stroke.points.as_slice()));
            }
            Self::PaintTiles { tiles, .. } => {
                for change in tiles {
                    visit(Arc::as_ptr(&change.tile) as usize, Tile::N_BYTES);
                }
            }
            Self::SetPanorama(Some(panorama)) => visit(Arc::as_ptr(panorama) as usize, panorama.texels.len() * 4),
            Self::SetMap { map: Some(map), .. } => map.visit_shared(visit),
            Self::SetSource { source, .. } => visit_source(source, visit),
            Self::Batch(edits) => edits.iter().for_each(|edit| edit.visit_shared(visit)),
            Self::SetName(_)
            | Self::SetHead(None)
            | Self::SetLook(_)
            | Self::SetPanorama(None)
            | Self::SetLod(_)
            | Self::SetLights(_)
            | Self::SetSimulation(_)
            | Self::SetColliders(_)
            | Self::SetPins(_)
            | Self::SetMovement(_)
            | Self::RemoveLayer { .. }
            | Self::MoveLayer { .. }
            | Self::SetLayerName { .. }
            | Self::SetLayerVisible { .. }
            | Self::SetMaterial { .. }
            | Self::SetStyle { .. }
            | Self::PaintStroke { .. }
            | Self::SetMap { map: None, .. }
            | Self::RemoveSculpt { .. }
            | Self::MoveSculpt { .. }
            | Self::SetSculptInfo { .. }
            | Self::HairMesh { .. }
            | Self::MoveVertices { .. } => {}
        }
    }
}

fn visit_source(source: &Source, visit: &mut dyn FnMut(usize, usize)) {
    match source {
        Source::HairMesh(hair_mesh) => {
            let n_bytes = hair_mesh.layers.iter().map(|l| l.positions.len() * 12 + l.faces.len() * 48);
            visit(Arc::as_ptr(hair_mesh) as usize, n_bytes.sum());
        }
        Source::Guides(strands) | Source::Strands(strands) => {
            visit(Arc::as_ptr(strands) as usize, strands.n_bytes());
        }
    }
}
