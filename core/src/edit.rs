//! Everything that can happen to a groom, as plain data whose application returns its own inverse.
//!
//! Undo is [`Groom::apply`] of what `apply` returned, so it cannot drift from what was done. Whole values
//! (a look, a material, a layer) are replaced rather than single fields: the large parts are behind `Arc`,
//! the rest is a few hundred bytes, and one edit then serves every control of a panel. Closures and
//! snapshots of the whole groom were rejected: a closure cannot be saved or compared, and a snapshot
//! hides what changed from whoever wants to show it.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::groom::{Groom, HairMaterial, Head, Layer, Source};
use crate::hair_mesh::{HairMesh, HairMeshError, MeshOp, VertexId};
use crate::light::Light;
use crate::lod::LodSettings;
use crate::look::Look;
use crate::maps::paint::MapStroke;
use crate::maps::{MapError, MapKind, ScalpMap, Tile, TileChange};
use crate::sculpt::{self, Sculpt, SculptChange, SculptGuide, SculptInfo, SculptLayer, SculptRoots, Stroke};
use crate::simulation::SimulationSettings;
use crate::style::StyleOp;

/// One change of a groom. Layers are named by their place in [`Groom::layers`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Edit {
    SetName(String),
    SetHead(Option<Head>),
    SetLook(Box<Look>),
    SetLod(Box<LodSettings>),
    SetLights(Vec<Light>),
    SetSimulation(Box<SimulationSettings>),
    AddLayer {
        layer_idx: usize,
        layer: Box<Layer>,
    },
    RemoveLayer {
        layer_idx: usize,
    },
    /// Take the layer out and put it back so that it ends at `to`.
    MoveLayer {
        from: usize,
        to: usize,
    },
    /// Replace a layer: its source, counts and widths in one.
    SetLayer {
        layer_idx: usize,
        layer: Box<Layer>,
    },
    SetLayerName {
        layer_idx: usize,
        name: String,
    },
    SetLayerVisible {
        layer_idx: usize,
        visible: bool,
    },
    SetMaterial {
        layer_idx: usize,
        material: HairMaterial,
    },
    SetStyle {
        layer_idx: usize,
        style: Vec<StyleOp>,
    },
    /// Put tiles into a painted map. Where the layer has none of this kind it gets one of defaults first.
    PaintTiles {
        layer_idx: usize,
        kind: MapKind,
        tiles: Vec<TileChange>,
    },
    /// Paint a stroke into a map, on the scalp of the head: the same as the tiles that it changes.
    PaintStroke {
        layer_idx: usize,
        kind: MapKind,
        stroke: MapStroke,
    },
    /// Give a layer a painted map, or take it away.
    SetMap {
        layer_idx: usize,
        kind: MapKind,
        map: Option<Arc<ScalpMap>>,
    },
    /// Replace where a layer's strands come from.
    SetSource {
        layer_idx: usize,
        source: Source,
    },
    /// An operation on the layer's hair mesh.
    HairMesh {
        layer_idx: usize,
        op: MeshOp,
    },
    /// Put vertices of the layer's hair mesh at places in head space, in centimetres.
    MoveVertices {
        layer_idx: usize,
        moves: Vec<(VertexId, Vec3)>,
    },
    /// Set guides of a sculpt layer: what a stroke of a brush comes to.
    Sculpt {
        layer_idx: usize,
        sculpt_idx: usize,
        /// In ascending order of guides.
        changes: Vec<SculptChange>,
    },
    /// Where a layer's sculpt guides stand; its first stroke needs them.
    SetSculptRoots {
        layer_idx: usize,
        roots: Arc<SculptRoots>,
    },
    AddSculpt {
        layer_idx: usize,
        sculpt_idx: usize,
        sculpt: Box<SculptLayer>,
    },
    RemoveSculpt {
        layer_idx: usize,
        sculpt_idx: usize,
    },
    /// Take the sculpt layer out and put it back so that it ends at `to`.
    MoveSculpt {
        layer_idx: usize,
        from: usize,
        to: usize,
    },
    /// Name, weight, mask, and whether a sculpt layer is on; its strokes stay.
    SetSculptInfo {
        layer_idx: usize,
        sculpt_idx: usize,
        info: SculptInfo,
    },
    /// A stroke of a sculpt brush as it was made, to be replayed: it finds the guides itself, and makes the sculpt
    /// layer where `sculpt_idx` is one more than there are. Its inverse is a batch of the edits above.
    Stroke {
        layer_idx: usize,
        sculpt_idx: usize,
        stroke: Box<Stroke>,
    },
    /// One after the other, undone as one.
    Batch(Vec<Edit>),
}

/// Why an edit does not fit the groom that it was applied to. The groom is then as it was.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    #[error("there is no layer {layer_idx}: the groom has {n_layers}")]
    NoSuchLayer { layer_idx: usize, n_layers: usize },
    #[error("there is no head to paint on: import one, or put the mannequin on")]
    NoHead,
    #[error("the map {kind}: {problem}")]
    Map { kind: MapKind, problem: MapError },
    #[error("layer {layer_idx} is not made of a hair mesh: choose one that is")]
    NotHairMesh { layer_idx: usize },
    #[error("hair mesh of layer {layer_idx}: {error}")]
    HairMesh { layer_idx: usize, error: HairMeshError },
    #[error("there is no sculpt layer {sculpt_idx} in layer {layer_idx}, which has {n_sculpts}")]
    NoSuchSculpt { layer_idx: usize, sculpt_idx: usize, n_sculpts: usize },
    #[error("layer {layer_idx} cannot be sculpted so: {why}")]
    Sculpt { layer_idx: usize, why: String },
}

impl Groom {
    /// Change the groom and return the edit that changes it back. On an error nothing has changed.
    pub fn apply(&mut self, edit: Edit) -> Result<Edit, EditError> {
        use std::mem::replace;
        Ok(match edit {
            Edit::SetName(name) => Edit::SetName(replace(&mut self.name, name)),
            Edit::SetHead(head) => Edit::SetHead(replace(&mut self.head, head)),
            Edit::SetLook(look) => Edit::SetLook(Box::new(replace(&mut self.look, *look))),
            Edit::SetLod(lod) => Edit::SetLod(Box::new(replace(&mut self.lod, *lod))),
            Edit::SetLights(lights) => Edit::SetLights(replace(&mut self.lights, lights)),
            Edit::SetSimulation(settings) => Edit::SetSimulation(Box::new(replace(&mut self.simulation, *settings))),
            Edit::AddLayer { layer_idx, layer } => {
                let n_layers = self.layers.len();
                if layer_idx > n_layers {
                    return Err(EditError::NoSuchLayer { layer_idx, n_layers });
                }
                self.layers.insert(layer_idx, *layer);
                Edit::RemoveLayer { layer_idx }
            }
            Edit::RemoveLayer { layer_idx } => {
                self.layer_mut(layer_idx)?;
                let layer = Box::new(self.layers.remove(layer_idx));
                Edit::AddLayer { layer_idx, layer }
            }
            Edit::MoveLayer { from, to } => {
                self.layer_mut(from)?;
                self.layer_mut(to)?;
                let layer = self.layers.remove(from);
                self.layers.insert(to, layer);
                Edit::MoveLayer { from: to, to: from }
            }
            Edit::SetLayer { layer_idx, layer } => {
                let layer = Box::new(replace(self.layer_mut(layer_idx)?, *layer));
                Edit::SetLayer { layer_idx, layer }
            }
            Edit::SetLayerName { layer_idx, name } => {
                let name = replace(&mut self.layer_mut(layer_idx)?.name, name);
                Edit::SetLayerName { layer_idx, name }
            }
            Edit::SetLayerVisible { layer_idx, visible } => {
                let visible = replace(&mut self.layer_mut(layer_idx)?.visible, visible);
                Edit::SetLayerVisible { layer_idx, visible }
            }
            Edit::SetMaterial { layer_idx, material } => {
                let material = replace(&mut self.layer_mut(layer_idx)?.material, material);
                Edit::SetMaterial { layer_idx, material }
            }
            Edit::SetStyle { layer_idx, style } => {
                let style = replace(&mut self.layer_mut(layer_idx)?.style, style);
                Edit::SetStyle { layer_idx, style }
            }
            Edit::PaintTiles { layer_idx, kind, tiles } => {
                self.layer_mut(layer_idx)?.paint_tiles(layer_idx, kind, tiles)?
            }
            Edit::PaintStroke { layer_idx, kind, stroke } => {
                let mesh = self.head.as_ref().map(|head| Arc::clone(&head.mesh)).ok_or(EditError::NoHead)?;
                let layer = self.layer_mut(layer_idx)?;
                let tiles = stroke.replay(&mesh, &layer.maps, &kind);
                layer.paint_tiles(layer_idx, kind, tiles)?
            }
            Edit::SetMap { layer_idx, kind, map } => {
                let maps = &mut self.layer_mut(layer_idx)?.maps;
                let map = match map {
                    Some(map) => maps.insert(kind.clone(), map),
                    None => maps.remove(&kind),
                };
                Edit::SetMap { layer_idx, kind, map }
            }
            Edit::SetSource { layer_idx, source } => {
                let source = replace(&mut self.layer_mut(layer_idx)?.source, source);
                Edit::SetSource { layer_idx, source }
            }
            Edit::HairMesh { layer_idx, op } => {
                let before = Arc::clone(self.hair_mesh_mut(layer_idx)?);
                let mut changed = HairMesh::clone(&before);
                changed.apply(&op).map_err(|error| EditError::HairMesh { layer_idx, error })?;
                let sharing = self.share_hair_mesh(&before, &Arc::new(changed));
                let back = |layer_idx| Edit::SetSource { layer_idx, source: Source::HairMesh(Arc::clone(&before)) };
                match sharing[..] {
                    [alone] => back(alone),
                    _ => Edit::Batch(sharing.into_iter().map(back).collect()),
                }
            }
            Edit::MoveVertices { layer_idx, moves } => {
                let hair_mesh = self.hair_mesh_mut(layer_idx)?;
                // Held only where another layer has it too: alone, it is changed in place.
                let before = (Arc::strong_count(hair_mesh) > 1).then(|| Arc::clone(hair_mesh));
                let moves = HairMesh::put_vertices(hair_mesh, moves)
                    .map_err(|error| EditError::HairMesh { layer_idx, error })?;
                let after = Arc::clone(hair_mesh);
                if let Some(before) = before {
                    self.share_hair_mesh(&before, &after);
                }
                Edit::MoveVertices { layer_idx, moves }
            }
            Edit::Sculpt { layer_idx, sculpt_idx, changes } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                let n_guides = sculpt.roots.positions.len();
                let layer = sculpt_mut(sculpt, layer_idx, sculpt_idx)?;
                if let Some(why) = sculpt::refuses(&changes, n_guides) {
                    return Err(EditError::Sculpt { layer_idx, why });
                }
                let changes = Arc::make_mut(&mut layer.strokes).apply(&changes);
                Edit::Sculpt { layer_idx, sculpt_idx, changes }
            }
            Edit::SetSculptRoots { layer_idx, roots } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                let before = replace(&mut sculpt.roots, roots);
                if let Err(why) = sculpt.check() {
                    sculpt.roots = before;
                    return Err(EditError::Sculpt { layer_idx, why });
                }
                Edit::SetSculptRoots { layer_idx, roots: before }
            }
            Edit::AddSculpt { layer_idx, sculpt_idx, sculpt: added } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                let n_sculpts = sculpt.layers.len();
                if sculpt_idx > n_sculpts {
                    return Err(EditError::NoSuchSculpt { layer_idx, sculpt_idx, n_sculpts });
                }
                if let Err(why) = added.strokes.check(sculpt.roots.positions.len()) {
                    return Err(EditError::Sculpt { layer_idx, why });
                }
                sculpt.layers.insert(sculpt_idx, *added);
                Edit::RemoveSculpt { layer_idx, sculpt_idx }
            }
            Edit::RemoveSculpt { layer_idx, sculpt_idx } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                sculpt_mut(sculpt, layer_idx, sculpt_idx)?;
                let sculpt = Box::new(sculpt.layers.remove(sculpt_idx));
                Edit::AddSculpt { layer_idx, sculpt_idx, sculpt }
            }
            Edit::MoveSculpt { layer_idx, from, to } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                sculpt_mut(sculpt, layer_idx, from)?;
                sculpt_mut(sculpt, layer_idx, to)?;
                let moved = sculpt.layers.remove(from);
                sculpt.layers.insert(to, moved);
                Edit::MoveSculpt { layer_idx, from: to, to: from }
            }
            Edit::SetSculptInfo { layer_idx, sculpt_idx, info } => {
                let sculpt = &mut self.layer_mut(layer_idx)?.sculpt;
                if !info.weight.is_finite() {
                    return Err(EditError::Sculpt { layer_idx, why: "the weight is no number".to_owned() });
                }
                let info = sculpt_mut(sculpt, layer_idx, sculpt_idx)?.set_info(info);
                Edit::SetSculptInfo { layer_idx, sculpt_idx, info }
            }
            Edit::Stroke { layer_idx, sculpt_idx, stroke } => {
                self.layer_mut(layer_idx)?;
                let edits = stroke.edits(self, layer_idx, sculpt_idx)?;
                self.apply_batch(edits)?
            }
            Edit::Batch(edits) => self.apply_batch(edits)?,
        })
    }

    fn apply_batch(&mut self, edits: Vec<Edit>) -> Result<Edit, EditError> {
        let mut inverses = Vec::with_capacity(edits.len());
        for edit in edits {
            match self.apply(edit) {
                Ok(inverse) => inverses.push(inverse),
                Err(error) => {
                    for inverse in inverses.into_iter().rev() {
                        self.apply(inverse).expect("an inverse fits the groom that it came from");
                    }
                    return Err(error);
                }
            }
        }
        inverses.reverse();
        Ok(Edit::Batch(inverses))
    }

    /// Several layers may trace one hair mesh: let all of them trace `after` that trace `before`. Returns which, and
    /// those that trace `after` already.
    fn share_hair_mesh(&mut self, before: &Arc<HairMesh>, after: &Arc<HairMesh>) -> Vec<usize> {
        let mut sharing = Vec::new();
        for (layer_idx, layer) in self.layers.iter_mut().enumerate() {
            if let Source::HairMesh(mesh) = &mut layer.source
                && (Arc::ptr_eq(mesh, before) || Arc::ptr_eq(mesh, after))
            {
                *mesh = Arc::clone(after);
                sharing.push(layer_idx);
            }
        }
        sharing
    }

    fn hair_mesh_mut(&mut self, layer_idx: usize) -> Result<&mut Arc<HairMesh>, EditError> {
        match &mut self.layer_mut(layer_idx)?.source {
            Source::HairMesh(hair_mesh) => Ok(hair_mesh),
            Source::Guides(_) | Source::Strands(_) => Err(EditError::NotHairMesh { layer_idx }),
        }
    }

    fn layer_mut(&mut self, layer_idx: usize) -> Result<&mut Layer, EditError> {
        let n_layers = self.layers.len();
        self.layers.get_mut(layer_idx).ok_or(EditError::NoSuchLayer { layer_idx, n_layers })
    }
}

impl Layer {
    fn paint_tiles(&mut self, layer_idx: usize, kind: MapKind, tiles: Vec<TileChange>) -> Result<Edit, EditError> {
        let bad = |problem| EditError::Map { kind: kind.clone(), problem };
        if let Some(map) = self.maps.get_mut(&kind) {
            let tiles = Arc::make_mut(map).replace_tiles(tiles).map_err(bad)?;
            return Ok(Edit::PaintTiles { layer_idx, kind, tiles });
        }
        let mut map = kind.empty_map();
        map.replace_tiles(tiles).map_err(bad)?;
        self.maps.insert(kind.clone(), Arc::new(map));
        Ok(Edit::SetMap { layer_idx, kind, map: None })
    }
}

fn sculpt_mut(sculpt: &mut Sculpt, layer_idx: usize, sculpt_idx: usize) -> Result<&mut SculptLayer, EditError> {
    let n_sculpts = sculpt.layers.len();
    sculpt.layers.get_mut(sculpt_idx).ok_or(EditError::NoSuchSculpt { layer_idx, sculpt_idx, n_sculpts })
}

impl Edit {
    /// Whether `self` overwrites all that `other` wrote, so that a drag can drop the steps in between.
    pub fn overwrites(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::SetName(_), Self::SetName(_))
            | (Self::SetHead(_), Self::SetHead(_))
            | (Self::SetLook(_), Self::SetLook(_))
            | (Self::SetLod(_), Self::SetLod(_))
            | (Self::SetLights(_), Self::SetLights(_))
            | (Self::SetSimulation(_), Self::SetSimulation(_)) => true,
            (
                Self::SetLayer { layer_idx: a, .. },
                Self::SetLayer { layer_idx: b, .. }
                | Self::PaintTiles { layer_idx: b, .. }
                | Self::SetMap { layer_idx: b, .. },
            )
            | (Self::SetLayerName { layer_idx: a, .. }, Self::SetLayerName { layer_idx: b, .. })
            | (Self::SetLayerVisible { layer_idx: a, .. }, Self::SetLayerVisible { layer_idx: b, .. })
            | (Self::SetMaterial { layer_idx: a, .. }, Self::SetMaterial { layer_idx: b, .. })
            | (Self::SetStyle { layer_idx: a, .. }, Self::SetStyle { layer_idx: b, .. })
            | (
                Self::SetSource { layer_idx: a, .. },
                Self::SetSource { layer_idx: b, .. } | Self::MoveVertices { layer_idx: b, .. },
            ) => a == b,
            (Self::MoveVertices { layer_idx: a, moves }, Self::MoveVertices { layer_idx: b, moves: others }) => {
                a == b && moves.len() == others.len() && moves.iter().zip(others).all(|(m, o)| m.0 == o.0)
            }
            (
                Self::PaintTiles { layer_idx: a, kind: kind_a, tiles: of_a },
                Self::PaintTiles { layer_idx: b, kind: kind_b, tiles: of_b },
            ) => {
                let writes = |tile_idx: u32| of_a.iter().any(|change| change.tile_idx == tile_idx);
                (a, kind_a) == (b, kind_b) && of_b.iter().all(|change| writes(change.tile_idx))
            }
            (
                Self::SetMap { layer_idx: a, kind: kind_a, .. },
                Self::PaintTiles { layer_idx: b, kind: kind_b, .. } | Self::SetMap { layer_idx: b, kind: kind_b, .. },
            ) => (a, kind_a) == (b, kind_b),
            (
                Self::SetSculptInfo { layer_idx: a, sculpt_idx: at_a, .. },
                Self::SetSculptInfo { layer_idx: b, sculpt_idx: at_b, .. },
            )
            // Taking a sculpt layer away undoes every stroke on it.
            | (
                Self::RemoveSculpt { layer_idx: a, sculpt_idx: at_a },
                Self::Sculpt { layer_idx: b, sculpt_idx: at_b, .. },
            ) => (a, at_a) == (b, at_b),
            (Self::Batch(a), Self::Sculpt { .. }) => a.first().is_some_and(|first| first.overwrites(other)),
            (Self::Batch(a), Self::Batch(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.overwrites(b)),
            _ => false,
        }
    }

    /// Where `self` undoes a beginning of a drag and `later` what came after, make `self` undo both; `false`
    /// where that needs two steps. A stroke touches more and more tiles, each of which is kept once.
    pub fn join(&mut self, later: &Self) -> bool {
        match (self, later) {
            (
                Self::PaintTiles { layer_idx: a, kind: kind_a, tiles: before },
                Self::PaintTiles { layer_idx: b, kind: kind_b, tiles },
            ) if (&*a, &*kind_a) == (b, kind_b) => {
                for change in tiles {
                    if before.iter().all(|known| known.tile_idx != change.tile_idx) {
                        before.push(change.clone());
                    }
                }
                true
            }
            (
                Self::Sculpt { layer_idx: a, sculpt_idx: at_a, changes: before },
                Self::Sculpt { layer_idx: b, sculpt_idx: at_b, changes },
            ) if (&*a, &*at_a) == (b, at_b) => {
                sculpt::join_changes(before, changes);
                true
            }
            (first, later) => first.overwrites(later),
        }
    }

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
            Self::SetMap { map: Some(map), .. } => map.visit_shared(visit),
            Self::SetSource { source, .. } => visit_source(source, visit),
            Self::Batch(edits) => edits.iter().for_each(|edit| edit.visit_shared(visit)),
            Self::SetName(_)
            | Self::SetHead(None)
            | Self::SetLook(_)
            | Self::SetLod(_)
            | Self::SetLights(_)
            | Self::SetSimulation(_)
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

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::hair_mesh::{Along, FaceCut, Weld};
    use crate::lod::LodChoice;
    use crate::look::{Scattering, Shadowing};
    use crate::maps::paint::StrokePoint;
    use crate::maps::tests::any_kind;
    use crate::mesh::TriMesh;
    use crate::sculpt::SculptMask;
    use crate::strands::Strands;
    use crate::style::{Profile, StyleKind};

    fn layer_named(name: &str) -> Layer {
        let mut strands = Strands::default();
        strands.push(&[Vec3::ZERO, Vec3::new(0.0, -0.1, name.len() as f32)]);
        Layer::from_strands(name, strands)
    }

    fn any_leaf() -> impl Strategy<Value = Edit> {
        let layer_idx = || 0_usize..5;
        prop_oneof![
            "[a-z]{0,6}".prop_map(Edit::SetName),
            any::<bool>()
                .prop_map(|with_head| { Edit::SetHead(with_head.then(|| Head::new("head", TriMesh::default()))) }),
            (-2.0..2.0_f32, any::<bool>()).prop_map(|(exposure, kk)| {
                let scattering = if kk { Scattering::KajiyaKay } else { Scattering::Marschner };
                Edit::SetLook(Box::new(Look { exposure, scattering, shadowing: Shadowing::Off, ..Look::default() }))
            }),
            (0.0..3.0_f32).prop_map(|level| {
                Edit::SetLod(Box::new(LodSettings { choice: LodChoice::Level(level), ..LodSettings::default() }))
            }),
            (0_usize..4).prop_map(|n| Edit::SetLights(vec![Light::directional("l", 1.0, 2.0, 3.0, [1.0; 3]); n])),
            (0.0..500.0_f32).prop_map(|wind_speed| {
                Edit::SetSimulation(Box::new(SimulationSettings { wind_speed, ..SimulationSettings::default() }))
            }),
            (layer_idx(), "[a-z]{1,4}")
                .prop_map(|(layer_idx, name)| Edit::AddLayer { layer_idx, layer: Box::new(layer_named(&name)) }),
            layer_idx().prop_map(|layer_idx| Edit::RemoveLayer { layer_idx }),
            (layer_idx(), layer_idx()).prop_map(|(from, to)| Edit::MoveLayer { from, to }),
            (layer_idx(), "[a-z]{1,4}")
                .prop_map(|(layer_idx, name)| Edit::SetLayer { layer_idx, layer: Box::new(layer_named(&name)) }),
            (layer_idx(), "[a-z]{1,4}").prop_map(|(layer_idx, name)| Edit::SetLayerName { layer_idx, name }),
            (layer_idx(), any::<bool>()).prop_map(|(layer_idx, visible)| Edit::SetLayerVisible { layer_idx, visible }),
            (layer_idx(), 0.0..8.0_f32).prop_map(|(layer_idx, eumelanin)| Edit::SetMaterial {
                layer_idx,
                material: HairMaterial { eumelanin, ..HairMaterial::default() }
            }),
            (layer_idx(), 0_u32..4).prop_map(|(layer_idx, seed)| {
                let kind = StyleKind::Clump { strands_per_clump: 50.0, flare: 0.0, stray: 0.0 };
                let curve = Profile::of_ramp(seed as f32);
                let op = StyleOp { strength: 0.5, solo: seed == 2, curve, seed, ..StyleOp::new(kind) };
                Edit::SetStyle { layer_idx, style: vec![op; seed as usize] }
            }),
            (layer_idx(), any_kind(), proptest::collection::vec((0_u32..20, any::<u8>()), 0..4)).prop_map(
                |(layer_idx, kind, tiles)| {
                    let change = |(tile_idx, texel)| TileChange { tile_idx, tile: Arc::new(Tile::filled(texel)) };
                    Edit::PaintTiles { layer_idx, kind, tiles: tiles.into_iter().map(change).collect() }
                }
            ),
            (layer_idx(), any_kind(), -1.0..1.0_f32).prop_map(|(layer_idx, kind, x)| {
                let points = [x, x + 0.5].map(|x| StrokePoint { position: Vec3::new(x, 0.0, 0.0), pressure: 1.0 });
                let stroke = MapStroke { points: points.to_vec(), value: 0.25, ..MapStroke::default() };
                Edit::PaintStroke { layer_idx, kind, stroke }
            }),
            (layer_idx(), 0_usize..3, sculpt_changes()).prop_map(|(layer_idx, sculpt_idx, changes)| Edit::Sculpt {
                layer_idx,
                sculpt_idx,
                changes
            }),
            (layer_idx(), 0_usize..9).prop_map(|(layer_idx, n)| {
                let positions = (0..n).map(|i| Vec3::X * i as f32).collect();
                Edit::SetSculptRoots { layer_idx, roots: Arc::new(SculptRoots { positions, uvs: Vec::new() }) }
            }),
            (layer_idx(), 0_usize..3, sculpt_changes()).prop_map(|(layer_idx, sculpt_idx, changes)| {
                let mut sculpt = Box::new(SculptLayer::new("added"));
                Arc::make_mut(&mut sculpt.strokes).apply(&changes);
                Edit::AddSculpt { layer_idx, sculpt_idx, sculpt }
            }),
            (layer_idx(), 0_usize..3).prop_map(|(layer_idx, sculpt_idx)| Edit::RemoveSculpt { layer_idx, sculpt_idx }),
            (layer_idx(), 0_usize..3, 0_usize..3).prop_map(|(layer_idx, from, to)| Edit::MoveSculpt {
                layer_idx,
                from,
                to
            }),
            (layer_idx(), 0_usize..3, "[a-z]{0,4}", -1.0..2.0_f32).prop_map(|(layer_idx, sculpt_idx, name, weight)| {
                let info = SculptInfo { name, on: weight > 0.0, weight, mask: SculptMask::Inverted };
                Edit::SetSculptInfo { layer_idx, sculpt_idx, info }
            }),
            (layer_idx(), any_kind(), proptest::option::of((1_u32..300, any::<u8>()))).prop_map(
                |(layer_idx, kind, map)| {
                    let map = map.map(|(side, texel)| Arc::new(ScalpMap::filled(side, 70, texel)));
                    Edit::SetMap { layer_idx, kind, map }
                }
            ),
        ]
    }

    /// A quad with two layers above it, one vertex moved by `bend`.
    fn hair_mesh_source(bend: f32) -> Source {
        let positions = vec![Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X];
        let mut mesh = HairMesh::from_polygons(positions, vec![vec![0, 1, 2, 3]]).unwrap();
        for _ in 0..2 {
            mesh.extrude(&[0], Weld::Neighbours, |v| v.position + Vec3::new(bend, 1.0, 0.0)).unwrap();
        }
        Source::HairMesh(Arc::new(mesh))
    }

    fn any_hair_mesh_edit() -> impl Strategy<Value = Edit> {
        let layer_idx = || 0_usize..3;
        let vertex = || (0_usize..4, 0_u32..6).prop_map(|(layer, vertex)| VertexId { layer, vertex });
        let op = prop_oneof![
            (0_usize..3, 0.5..3.0_f32).prop_map(|(bundle, length_cm)| MeshOp::Extrude {
                bundles: vec![bundle],
                along: Along::Onward,
                length_cm,
                n_layers: 1,
                weld: Weld::Neighbours
            }),
            (0_usize..3).prop_map(|bundle| MeshOp::DeleteTips { bundles: vec![bundle] }),
            (0_usize..2).prop_map(|bundle| MeshOp::DivideFace { bundle, cut: FaceCut::Corners(0, 2) }),
            (vertex(), any::<bool>()).prop_map(|(id, pinned)| MeshOp::SetPinned { vertices: vec![id], pinned }),
            vertex().prop_map(|id| MeshOp::SeparateVertices { vertices: vec![id] }),
        ];
        prop_oneof![
            (layer_idx(), 0.0..1.0_f32)
                .prop_map(|(layer_idx, bend)| Edit::SetSource { layer_idx, source: hair_mesh_source(bend) }),
            (layer_idx(), op).prop_map(|(layer_idx, op)| Edit::HairMesh { layer_idx, op }),
            (layer_idx(), proptest::collection::vec((vertex(), -2.0..2.0_f32), 0..4)).prop_map(|(layer_idx, moves)| {
                let moves = moves.into_iter().map(|(id, x)| (id, Vec3::new(x, 1.0, -x))).collect();
                Edit::MoveVertices { layer_idx, moves }
            }),
        ]
    }

    /// Of few guides, some of them out of range.
    fn sculpt_changes() -> impl Strategy<Value = Vec<SculptChange>> {
        proptest::collection::btree_map(0_u32..10, proptest::option::of(-2.0..2.0_f32), 0..5).prop_map(|changes| {
            let guide =
                |x: f32| Box::new(SculptGuide { length: x, offsets: [[x; 3]; sculpt::K], ..Default::default() });
            changes.into_iter().map(|(at, x)| SculptChange { guide: at, to: x.map(guide) }).collect()
        })
    }

    pub(crate) fn any_edit() -> impl Strategy<Value = Edit> {
        prop_oneof![4 => any_leaf(), 2 => any_hair_mesh_edit(), 1 => proptest::collection::vec(any_leaf(), 0..4).prop_map(Edit::Batch)]
    }

    pub(crate) fn small_groom() -> Groom {
        let top = Layer::new("top", hair_mesh_source(0.2));
        Groom { layers: vec![layer_named("fringe"), top, layer_named("back")], ..Groom::default() }
    }

    proptest! {
        #[test]
        fn undoing_every_edit_gives_the_first_groom(edits in proptest::collection::vec(any_edit(), 0..40)) {
            let first = small_groom();
            let first_text = ron::to_string(&first).unwrap();
            let mut groom = first.clone();
            let mut inverses = Vec::new();
            for edit in edits {
                let before = groom.clone();
                if let Ok(inverse) = groom.apply(edit) {
                    inverses.push(inverse);
                } else {
                    prop_assert_eq!(&groom, &before, "a refused edit changes nothing");
                }
            }
            for inverse in inverses.into_iter().rev() {
                groom.apply(inverse).unwrap();
            }
            prop_assert_eq!(&groom, &first);
            prop_assert_eq!(ron::to_string(&groom).unwrap(), first_text);
        }
    }

    #[test]
    fn layers_that_share_a_hair_mesh_go_on_sharing_it() {
        let mut groom = small_groom();
        let mut frizz = groom.layers[1].clone();
        frizz.name = "frizz".to_owned();
        groom.layers.push(frizz);
        let before = groom.clone();
        let mesh_of = |groom: &Groom, layer_idx: usize| match &groom.layers[layer_idx].source {
            Source::HairMesh(mesh) => Arc::clone(mesh),
            Source::Guides(_) | Source::Strands(_) => panic!("made of a hair mesh"),
        };
        let id = VertexId { layer: 1, vertex: 0 };
        let moves = vec![(id, Vec3::new(1.0, 2.0, 3.0))];
        let mut undo = vec![groom.apply(Edit::MoveVertices { layer_idx: 3, moves }).unwrap()];
        assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)));
        assert_eq!(mesh_of(&groom, 1).position(id), Some(Vec3::new(1.0, 2.0, 3.0)));
        undo.push(groom.apply(Edit::HairMesh { layer_idx: 1, op: MeshOp::DeleteTips { bundles: vec![0] } }).unwrap());
        assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)));
        for edit in undo.into_iter().rev() {
            groom.apply(edit).unwrap();
        }
        assert_eq!(groom, before);
        assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)), "undo keeps them together");
    }

    #[test]
    fn a_batch_that_fails_in_the_middle_changes_nothing() {
        let mut groom = small_groom();
        let before = groom.clone();
        let batch = Edit::Batch(vec![Edit::SetName("other".into()), Edit::RemoveLayer { layer_idx: 9 }]);
        assert_eq!(groom.apply(batch), Err(EditError::NoSuchLayer { layer_idx: 9, n_layers: 3 }));
        assert_eq!(groom, before);
    }
}
