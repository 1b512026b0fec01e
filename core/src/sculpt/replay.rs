//! A stroke that was recorded, or written by hand, as the edits that it comes to.

use std::sync::Arc;

use super::{LiveStroke, SculptBase, SculptChange, SculptLayer, SculptRoots, Stroke};
use crate::distance_field::{COLLISION_RESOLUTION, DistanceField};
use crate::edit::{Edit, EditError};
use crate::groom::{Groom, Layer};

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
        let mut roots = Arc::clone(&layer.sculpt.roots);
        if roots.positions.is_empty() {
            roots = Arc::new(SculptRoots::of_layer(layer, groom.head.as_ref()));
            edits.push(Edit::SetSculptRoots { layer_idx, roots: Arc::clone(&roots) });
        }
        if roots.positions.is_empty() {
            return Err(EditError::Sculpt { layer_idx, why: "it has no hair".to_owned() });
        }
        if sculpt_idx == n_sculpts {
            let sculpt = Box::new(SculptLayer::new(&format!("Sculpt {}", n_sculpts + 1)));
            edits.push(Edit::AddSculpt { layer_idx, sculpt_idx, sculpt });
        }
        let field =
            groom.head.as_ref().and_then(|head| DistanceField::from_mesh(&head.mesh, COLLISION_RESOLUTION).ok());
        let base = SculptBase::new(layer, groom.head.as_ref(), roots, field.map(Arc::new));
        let changes = self.changes(Arc::new(base), layer, sculpt_idx);
        edits.push(Edit::Sculpt { layer_idx, sculpt_idx, changes });
        Ok(edits)
    }

    /// What the stroke makes of a layer's guides.
    pub fn changes(&self, base: Arc<SculptBase>, layer: &Layer, sculpt_idx: usize) -> Vec<SculptChange> {
        let mut live = LiveStroke::begin(base, layer, sculpt_idx, self);
        let mut all = Vec::new();
        for point in &self.points {
            let mut later = live.extend(*point);
            // The later state of a guide is the one that counts.
            super::join_changes(&mut later, &all);
            all = later;
        }
        all
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
