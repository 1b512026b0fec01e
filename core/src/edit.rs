//! Everything that can happen to a groom, as plain data whose application returns its own inverse.
//!
//! Undo is [`Groom::apply`] of what `apply` returned, so it cannot drift from what was done. Whole values
//! (a look, a material, a layer) are replaced rather than single fields: the large parts are behind `Arc`,
//! the rest is a few hundred bytes, and one edit then serves every control of a panel. Closures and
//! snapshots of the whole groom were rejected: a closure cannot be saved or compared, and a snapshot
//! hides what changed from whoever wants to show it.

mod join;
mod visit;

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::collider::Collider;
use crate::groom::{Groom, HairMaterial, Head, Layer, Source};
use crate::hair_mesh::{HairMesh, HairMeshError, MeshOp, VertexId};
use crate::light::Light;
use crate::lod::LodSettings;
use crate::look::Look;
use crate::maps::paint::MapStroke;
use crate::maps::{MapError, MapKind, ScalpMap, TileChange};
use crate::motion::Movement;
use crate::panorama::Panorama;
use crate::pin::Pin;
use crate::sculpt::{self, Sculpt, SculptChange, SculptInfo, SculptLayer, SculptRoots, Stroke};
use crate::simulation::SimulationSettings;
use crate::style::StyleOp;

/// One change of a groom. Layers are named by their place in [`Groom::layers`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Edit {
    SetName(String),
    SetHead(Option<Head>),
    SetLook(Box<Look>),
    /// The picture of what is all around that was loaded from a file.
    SetPanorama(Option<Arc<Panorama>>),
    SetLod(Box<LodSettings>),
    SetLights(Vec<Light>),
    SetSimulation(Box<SimulationSettings>),
    /// What hair keeps out of beside the head: a part of the settings of movement.
    SetColliders(Vec<Collider>),
    /// What holds hair to its place on the head: a part of the settings of movement.
    SetPins(Vec<Pin>),
    /// What happens on the timeline: motion, range, frames a second.
    SetMovement(Box<Movement>),
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
    #[error("the picture of the environment: {0}")]
    Panorama(String),
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
            Edit::SetPanorama(panorama) => {
                panorama.as_ref().map_or(Ok(()), |panorama| panorama.check()).map_err(EditError::Panorama)?;
                Edit::SetPanorama(replace(&mut self.panorama, panorama))
            }
            Edit::SetLod(lod) => Edit::SetLod(Box::new(replace(&mut self.lod, *lod))),
            Edit::SetLights(lights) => Edit::SetLights(replace(&mut self.lights, lights)),
            Edit::SetSimulation(settings) => Edit::SetSimulation(Box::new(replace(&mut self.simulation, *settings))),
            Edit::SetColliders(colliders) => Edit::SetColliders(replace(&mut self.simulation.colliders, colliders)),
            Edit::SetPins(pins) => Edit::SetPins(replace(&mut self.simulation.pins, pins)),
            Edit::SetMovement(movement) => Edit::SetMovement(Box::new(replace(&mut self.movement, *movement))),
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

#[cfg(test)]
pub(crate) mod tests;
