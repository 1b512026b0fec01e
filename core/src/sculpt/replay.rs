//! A stroke that was recorded, or written by hand, as the edits that it comes to.
//!
//! A journal may hold a day of strokes, and preparing hair for brushes takes longer than a stroke: what was prepared
//! last is kept on the thread that replays, as long as the hair below the brushes is the same.

use std::cell::RefCell;
use std::sync::Arc;

use super::{LiveStroke, MadeFrom, SculptBase, SculptChange, SculptLayer, Stroke};
use crate::edit::{Edit, EditError};
use crate::groom::{Groom, Head, Layer};

/// Layers that are kept prepared: a macro goes to and fro between main hair and fly-aways.
const MOST_KEPT: usize = 3;

thread_local! {
    /// The latest last.
    static KEPT: RefCell<Vec<(MadeFrom, Arc<SculptBase>)>> = const { RefCell::new(Vec::new()) };
}

/// A layer made ready for strokes, as it was made ready for the stroke before where nothing has changed.
fn base_of(layer: &Layer, head: Option<&Head>) -> Arc<SculptBase> {
    KEPT.with_borrow_mut(|kept| {
        if let Some(at) = kept.iter().position(|(of, _)| of.holds_for(layer, head)) {
            let latest = kept.remove(at);
            let base = Arc::clone(&latest.1);
            kept.push(latest);
            return base;
        }
        let field = kept.iter().find(|(of, _)| of.is_of_head(head)).map(|(_, base)| base.field.clone());
        let base = Arc::new(SculptBase::prepare(layer, head, field));
        kept.push((MadeFrom::new(layer, head, &base.roots), Arc::clone(&base)));
        if kept.len() > MOST_KEPT {
            kept.remove(0);
        }
        base
    })
}

/// Points of a stroke, at most: an hour of a fast pen.
const MOST_POINTS: usize = 1_000_000;

impl Stroke {
    /// What the stroke does to a layer of a groom; the same groom and the same stroke give the same edits. A
    /// sculpt layer is made where `sculpt_idx` is one more than there are.
    pub fn edits(&self, groom: &Groom, layer_idx: usize, sculpt_idx: usize) -> Result<Vec<Edit>, EditError> {
        let n_layers = groom.layers.len();
        let layer = groom.layers.get(layer_idx).ok_or(EditError::NoSuchLayer { layer_idx, n_layers })?;
        let n_sculpts = layer.sculpt.layers.len();
        if sculpt_idx > n_sculpts {
            return Err(EditError::NoSuchSculpt { layer_idx, sculpt_idx, n_sculpts });
        }
        if let Some(why) = self.problem() {
            return Err(EditError::Sculpt { layer_idx, why });
        }
        let mut edits = Vec::new();
        let base = base_of(layer, groom.head.as_ref());
        if let Some(why) = base.problem(self.kind) {
            return Err(EditError::Sculpt { layer_idx, why: why.to_owned() });
        }
        if !Arc::ptr_eq(&layer.sculpt.roots, &base.roots) {
            edits.push(Edit::SetSculptRoots { layer_idx, roots: Arc::clone(&base.roots) });
        }
        if sculpt_idx == n_sculpts {
            let sculpt = Box::new(SculptLayer::new(&format!("Sculpt {}", n_sculpts + 1)));
            edits.push(Edit::AddSculpt { layer_idx, sculpt_idx, sculpt });
        }
        let mut live = LiveStroke::begin(base, layer, sculpt_idx, self);
        let changes = live.extend_all(&self.points);
        edits.push(Edit::Sculpt { layer_idx, sculpt_idx, changes });
        let planted = live.planted(&layer.source);
        edits.extend(planted.map(|source| Edit::SetSource { layer_idx, source }));
        Ok(edits)
    }

    /// What the stroke makes of a layer's guides.
    pub fn changes(&self, base: Arc<SculptBase>, layer: &Layer, sculpt_idx: usize) -> Vec<SculptChange> {
        LiveStroke::begin(base, layer, sculpt_idx, self).extend_all(&self.points)
    }

    /// Why it cannot be made, in words.
    fn problem(&self) -> Option<String> {
        let is_finite =
            self.points.iter().all(|p| p.at.iter().chain([&p.pressure]).all(|v| v.is_finite() && v.abs() < 1e5));
        let view = &self.view;
        let numbers = [view.camera.azimuth_deg, view.camera.elevation_deg, view.camera.distance, view.camera.fov_y_deg];
        let has_view = numbers.iter().all(|v| v.is_finite())
            && view.camera.target.is_finite()
            && view.camera.distance > 0.0
            && (1.0..170.0).contains(&view.camera.fov_y_deg)
            && view.size.iter().all(|side| (1.0..1e5).contains(side))
            && view.world_from_head.is_finite()
            && view.world_from_head.matrix3.determinant().abs() > 1e-6;
        let brush = &self.brush;
        let has_brush = brush.strength.is_finite()
            && [brush.radius_cm, brush.radius_points].iter().all(|radius| radius.is_finite() && *radius > 0.0);
        if self.points.len() > MOST_POINTS {
            Some(format!("a stroke has {MOST_POINTS} points at most, this one {}", self.points.len()))
        } else if !is_finite {
            Some("a point of the stroke is nowhere".to_owned())
        } else if !has_view {
            Some("the camera of the stroke sees nothing".to_owned())
        } else {
            (!has_brush).then(|| "the brush has no size or no strength".to_owned())
        }
    }
}
