//! Sculpt layers: what brushes did to a layer's hair, kept above its style so that nothing below forgets it.
//!
//! Brushes move *sculpt guides*: places that are spread evenly over the scalp when a layer is sculpted first,
//! the beginning of the layer's root sequence, and that stay in the document from then on ([`SculptRoots`]).
//! A guide holds what was done to the hair there ([`SculptGuide`]): offsets along the strand in the root's own
//! frame, and a few numbers. Every strand takes its share of the nearest guides ([`near`]). So density, count,
//! style and the hair mesh may change, its topology too, and the strokes stay where they were made.
//!
//! Rejected: offsets on the strands themselves (they are lost with the strand, and a stroke would upload
//! millions of points); guides found anew from the root sequence every time (another face in the hair mesh
//! shuffles the sequence, and every stroke with it).

pub mod brushes;
pub mod compose;
pub mod guides;
mod made_from;
pub mod near;
pub mod planted;
pub mod planting;
mod replay;
pub mod session;
pub mod solve;
pub mod stroke;
#[cfg(test)]
pub(crate) mod tests;
pub mod view;

use std::sync::Arc;

use bytemuck::Zeroable;
use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::groom::Layer;
use crate::maps::{MapKind, Maps};

pub use brushes::SculptBrush;
pub use compose::Composite;
pub use guides::GuidePaths;
pub use made_from::MadeFrom;
pub use near::SculptShares;
pub use session::{LiveStroke, SculptBase};
pub use stroke::{Stroke, StrokePoint};
pub use view::StrokeView;

/// Points of a sculpt guide, the root included. Point `k` lies at `k / (K - 1)` of the hair's path.
pub const K: usize = 16;
/// Sculpt guides of a layer when it is sculpted first: about 4 mm apart on a scalp of 600 square centimetres.
pub const N_GUIDES: usize = 4096;
/// Most sculpt guides of a layer, after its hair mesh has grown over more of the scalp.
pub const MOST_GUIDES: usize = 4 * N_GUIDES;

/// A groom layer's sculpt layers and the places that they hold on to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Sculpt {
    pub roots: Arc<SculptRoots>,
    /// Lowest first; their effects add up.
    pub layers: Vec<SculptLayer>,
}

/// Where the sculpt guides stand: guide `i` is `positions[i]`, and stays it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct SculptRoots {
    /// On the scalp, head space, centimetres.
    pub positions: Vec<Vec3>,
    /// Texture coordinates there, for masks; empty where the head has none.
    pub uvs: Vec<[f32; 2]>,
}

/// One sculpt layer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SculptLayer {
    pub name: String,
    pub on: bool,
    /// 0 is without effect, 1 as it was brushed.
    pub weight: f32,
    /// Where it acts.
    pub mask: SculptMask,
    pub strokes: Arc<SculptStrokes>,
}

/// Where a sculpt layer acts.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum SculptMask {
    #[default]
    Everywhere,
    /// Less where the mask brush painted.
    Painted,
    /// Only where the mask brush painted.
    Inverted,
    /// As much as a painted map of the groom layer says.
    Map(MapKind),
}

/// What a sculpt layer is called and how much of it acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SculptInfo {
    pub name: String,
    pub on: bool,
    pub weight: f32,
    pub mask: SculptMask,
}

/// What was brushed: only guides that a brush has touched are here.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SculptStrokes {
    /// Ascending.
    pub ids: Vec<u32>,
    /// As long as `ids`.
    pub guides: Vec<SculptGuide>,
}

/// What was done to the hair of one place.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable, Serialize, Deserialize)]
#[serde(default)]
#[repr(C)]
pub struct SculptGuide {
    /// Offsets of the guide's points in the root's frame, centimetres: x and y along the scalp, z out of it.
    pub offsets: [[f32; 3]; K],
    /// Length as a share of what the style gives; above 1 it has grown.
    pub length: f32,
    /// Share of the path that was not cut off, from the root; the shape below the cut stays.
    pub cut: f32,
    /// Share of the strands that is left: 0 bald, 1 all of them. Above 1, so many times as many grow: see
    /// [`planting`].
    pub keep: f32,
    /// 1 is left alone by every brush.
    pub frozen: f32,
    /// How much of the layer's effect is masked away, 0-1.
    pub masked: f32,
}

impl Default for SculptGuide {
    fn default() -> Self {
        Self { length: 1.0, cut: 1.0, keep: 1.0, ..Self::zeroed() }
    }
}

impl SculptGuide {
    /// Nothing was done.
    pub fn is_untouched(&self) -> bool {
        *self == Self::default()
    }

    pub fn is_finite(&self) -> bool {
        self.offsets
            .as_flattened()
            .iter()
            .chain([&self.length, &self.cut, &self.keep, &self.frozen, &self.masked])
            .all(|v| v.is_finite())
    }
}

/// A guide's new state in a sculpt layer; `None` is as it was before any brush.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SculptChange {
    pub guide: u32,
    pub to: Option<Box<SculptGuide>>,
}

impl SculptRoots {
    pub fn n_bytes(&self) -> usize {
        size_of_val(self.positions.as_slice()) + size_of_val(self.uvs.as_slice())
    }
}

/// Why changes cannot be made to a sculpt layer with so many guides, in words.
pub fn refuses(changes: &[SculptChange], n_guides: usize) -> Option<String> {
    if !changes.is_sorted_by(|a, b| a.guide < b.guide) {
        return Some("the guides of a change are in ascending order, each once".to_owned());
    }
    if let Some(beyond) = changes.iter().find(|change| change.guide as usize >= n_guides) {
        return Some(format!("there is no sculpt guide {}: the layer has {n_guides}", beyond.guide));
    }
    let is_finite = |change: &SculptChange| change.to.as_ref().is_none_or(|guide| guide.is_finite());
    let bad = changes.iter().find(|change| !is_finite(change))?;
    Some(format!("sculpt guide {} would be at no place", bad.guide))
}

/// Add to changes that undo the beginning of a stroke those that undo its end: what the beginning knows stays.
pub fn join_changes(before: &mut Vec<SculptChange>, later: &[SculptChange]) {
    let mut known = std::mem::take(before).into_iter().peekable();
    for change in later {
        while let Some(first) = known.next_if(|first| first.guide < change.guide) {
            before.push(first);
        }
        before.push(known.next_if(|first| first.guide == change.guide).unwrap_or_else(|| change.clone()));
    }
    before.extend(known);
}

impl Layer {
    /// Whether brushes did the same to two layers, without looking into large parts: false may be wrong.
    pub fn has_same_sculpt(&self, other: &Self) -> bool {
        let has_same_map = |layer: &SculptLayer| match &layer.mask {
            SculptMask::Map(kind) => match (self.maps.get(kind), other.maps.get(kind)) {
                (Some(a), Some(b)) => Arc::ptr_eq(a, b),
                (a, b) => a.is_none() && b.is_none(),
            },
            SculptMask::Everywhere | SculptMask::Painted | SculptMask::Inverted => true,
        };
        self.sculpt.is_same(&other.sculpt) && self.sculpt.layers.iter().all(has_same_map)
    }
}

impl Default for SculptLayer {
    fn default() -> Self {
        Self::new("Sculpt")
    }
}

impl SculptLayer {
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), on: true, weight: 1.0, mask: SculptMask::Everywhere, strokes: Arc::default() }
    }

    pub fn info(&self) -> SculptInfo {
        SculptInfo { name: self.name.clone(), on: self.on, weight: self.weight, mask: self.mask.clone() }
    }

    /// Replace all but the strokes; returns what was there.
    pub fn set_info(&mut self, info: SculptInfo) -> SculptInfo {
        let before = self.info();
        (self.name, self.on, self.weight, self.mask) = (info.name, info.on, info.weight, info.mask);
        before
    }

    pub fn is_active(&self) -> bool {
        self.on && self.weight != 0.0 && !self.strokes.ids.is_empty()
    }
}

impl SculptStrokes {
    /// What was done to a guide, where anything was.
    pub fn get(&self, guide: u32) -> Option<&SculptGuide> {
        self.ids.binary_search(&guide).ok().map(|at| &self.guides[at])
    }

    /// Set guides and return the changes that set them back. `changes` are in ascending order of guides.
    pub fn apply(&mut self, changes: &[SculptChange]) -> Vec<SculptChange> {
        let before = changes
            .iter()
            .map(|change| SculptChange { guide: change.guide, to: self.get(change.guide).copied().map(Box::new) })
            .collect();
        let is_all_known = changes.iter().all(|change| change.to.is_some() && self.get(change.guide).is_some());
        if is_all_known {
            for change in changes {
                if let (Ok(at), Some(to)) = (self.ids.binary_search(&change.guide), &change.to) {
                    self.guides[at] = **to;
                }
            }
            return before;
        }
        let (ids, guides) = (std::mem::take(&mut self.ids), std::mem::take(&mut self.guides));
        let mut old = ids.into_iter().zip(guides).peekable();
        let mut put = |id: u32, guide: SculptGuide| {
            self.ids.push(id);
            self.guides.push(guide);
        };
        for change in changes {
            while let Some((id, guide)) = old.next_if(|(id, _)| *id < change.guide) {
                put(id, guide);
            }
            old.next_if(|(id, _)| *id == change.guide);
            if let Some(to) = &change.to {
                put(change.guide, **to);
            }
        }
        old.for_each(|(id, guide)| put(id, guide));
        before
    }

    pub fn n_bytes(&self) -> usize {
        size_of_val(self.ids.as_slice()) + size_of_val(self.guides.as_slice())
    }

    /// The first problem, in words, or nothing.
    pub fn check(&self, n_guides: usize) -> Result<(), String> {
        if self.ids.len() != self.guides.len() {
            return Err(format!("{} numbers of sculpt guides for {} guides", self.ids.len(), self.guides.len()));
        }
        if !self.ids.is_sorted_by(|a, b| a < b) || self.ids.last().is_some_and(|&id| id as usize >= n_guides) {
            return Err(format!("sculpt guides out of order or beyond the {n_guides} there are"));
        }
        match self.guides.iter().position(|guide| !guide.is_finite()) {
            Some(bad) => Err(format!("sculpt guide {} is at no place", self.ids[bad])),
            None => Ok(()),
        }
    }
}

impl Sculpt {
    /// Whether any strand is other than its style makes it.
    pub fn is_active(&self) -> bool {
        self.layers.iter().any(SculptLayer::is_active)
    }

    /// Whether two sculpts are the same without looking into large parts: false may be wrong, true is not.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.roots, &other.roots)
            && self.layers.len() == other.layers.len()
            && self.layers.iter().zip(&other.layers).all(|(a, b)| {
                (a.on, a.weight, &a.mask) == (b.on, b.weight, &b.mask) && Arc::ptr_eq(&a.strokes, &b.strokes)
            })
    }

    /// The layer `sculpt_idx` taken down into the one below, so that the hair stays as it is; `None` where there
    /// is none below or one of the two is off. Returns what the lower layer becomes.
    pub fn merged_down(&self, maps: &Maps, sculpt_idx: usize) -> Option<SculptLayer> {
        let below_idx = sculpt_idx.checked_sub(1)?;
        let (upper, below) = (self.layers.get(sculpt_idx)?, self.layers.get(below_idx)?);
        if !upper.on || !below.on {
            return None;
        }
        let mut merged = SculptLayer::new(&below.name);
        let strokes = Arc::make_mut(&mut merged.strokes);
        let mut ids: Vec<u32> = upper.strokes.ids.iter().chain(&below.strokes.ids).copied().collect();
        ids.sort_unstable();
        ids.dedup();
        for id in ids {
            let mut guide = self.guide_of(maps, |idx| idx == below_idx || idx == sculpt_idx, id);
            let of = |layer: &SculptLayer| layer.strokes.get(id).copied().unwrap_or_default();
            guide.frozen = of(upper).frozen.max(of(below).frozen);
            strokes.ids.push(id);
            strokes.guides.push(guide);
        }
        Some(merged)
    }

    /// The first problem, in words, or nothing.
    pub fn check(&self) -> Result<(), String> {
        let n_guides = self.roots.positions.len();
        if !self.roots.uvs.is_empty() && self.roots.uvs.len() != n_guides {
            return Err(format!("{} texture coordinates for {n_guides} sculpt guides", self.roots.uvs.len()));
        }
        if let Some(bad) = self.roots.positions.iter().position(|p| !p.is_finite()) {
            return Err(format!("sculpt guide {bad} stands at no place"));
        }
        for layer in &self.layers {
            let checked = layer.strokes.check(n_guides);
            checked.map_err(|problem| format!("sculpt layer `{}`: {problem}", layer.name))?;
            if !layer.weight.is_finite() {
                return Err(format!("sculpt layer `{}` has no weight", layer.name));
            }
        }
        Ok(())
    }
}
