//! Which edits of one drag become one step.

use super::Edit;
use crate::sculpt;

impl Edit {
    /// Whether `self` overwrites all that `other` wrote, so that a drag can drop the steps in between.
    pub fn overwrites(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::SetName(_), Self::SetName(_))
            | (Self::SetHead(_), Self::SetHead(_))
            | (Self::SetLook(_), Self::SetLook(_))
            | (Self::SetPanorama(_), Self::SetPanorama(_))
            | (Self::SetLod(_), Self::SetLod(_))
            | (Self::SetLights(_), Self::SetLights(_))
            | (Self::SetSimulation(_), Self::SetSimulation(_) | Self::SetColliders(_) | Self::SetPins(_))
            | (Self::SetColliders(_), Self::SetColliders(_))
            | (Self::SetPins(_), Self::SetPins(_))
            | (Self::SetMovement(_), Self::SetMovement(_)) => true,
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
}
