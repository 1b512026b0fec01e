//! What all sculpt layers together do to every guide: what strands are made from, here and on the GPU.
//!
//! Offsets add up by the layers' weights, lengths multiply, the shortest cut and the thinnest hair win, and where
//! none is thinned, the densest. The
//! result is as plain as the GPU reads it: [`K`] times four numbers a guide, whose fourth numbers are the
//! guide's length, cut and keep.

use rayon::prelude::*;

use super::{K, Sculpt, SculptGuide, SculptMask};
use crate::groom::Layer;
use crate::maps::Maps;

/// A guide as generation reads it: points `k` as `[x, y, z, w]`; `w` of the first three is the guide's length,
/// cut and keep.
pub type Composed = [[f32; 4]; K];

/// The hair as its style makes it.
pub const UNTOUCHED: Composed = {
    let mut guide = [[0.0; 4]; K];
    guide[0][3] = 1.0;
    guide[1][3] = 1.0;
    guide[2][3] = 1.0;
    guide
};

/// Every guide's state under all layers; empty where nothing is sculpted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Composite {
    pub guides: Vec<Composed>,
}

impl Sculpt {
    /// How much of a sculpt layer acts on a guide, whose state in the layer is `guide`.
    pub fn share(&self, maps: &Maps, sculpt_idx: usize, id: u32, guide: &SculptGuide) -> f32 {
        let layer = &self.layers[sculpt_idx];
        layer.weight
            * match &layer.mask {
                SculptMask::Everywhere => 1.0,
                SculptMask::Painted => 1.0 - guide.masked,
                SculptMask::Inverted => guide.masked,
                SculptMask::Map(kind) => match self.roots.uvs.get(id as usize) {
                    Some(&uv) => kind.sample(maps, uv).min(1.0),
                    None => 1.0,
                },
            }
    }

    /// A guide's state under those sculpt layers that `takes_part` names.
    pub(super) fn guide_of(&self, maps: &Maps, takes_part: impl Fn(usize) -> bool, id: u32) -> SculptGuide {
        let mut all = SculptGuide::default();
        for (sculpt_idx, layer) in self.layers.iter().enumerate() {
            if layer.is_active()
                && takes_part(sculpt_idx)
                && let Some(guide) = layer.strokes.get(id)
            {
                add(&mut all, guide, self.share(maps, sculpt_idx, id, guide));
            }
        }
        all
    }
}

fn add(all: &mut SculptGuide, guide: &SculptGuide, share: f32) {
    for (sum, offset) in all.offsets.iter_mut().zip(&guide.offsets) {
        for (sum, offset) in sum.iter_mut().zip(offset) {
            *sum += share * offset;
        }
    }
    let at = |value: f32| 1.0 + share * (value - 1.0);
    all.length = (all.length * at(guide.length)).max(0.0);
    all.cut = all.cut.min(at(guide.cut)).max(0.0);
    let keep = at(guide.keep).max(0.0);
    all.keep = if all.keep < 1.0 || keep < 1.0 { all.keep.min(keep) } else { all.keep.max(keep) };
}

impl Composite {
    /// Compose all layers; 4096 guides take less than a millisecond.
    pub fn of(layer: &Layer) -> Self {
        let sculpt = &layer.sculpt;
        if !sculpt.is_active() {
            return Self::default();
        }
        let mut all = vec![SculptGuide::default(); sculpt.roots.positions.len()];
        for (sculpt_idx, of) in sculpt.layers.iter().enumerate().filter(|(_, of)| of.is_active()) {
            for (&id, guide) in of.strokes.ids.iter().zip(&of.strokes.guides) {
                if let Some(sum) = all.get_mut(id as usize) {
                    add(sum, guide, sculpt.share(&layer.maps, sculpt_idx, id, guide));
                }
            }
        }
        Self { guides: all.par_iter().map(composed).collect() }
    }

    /// Ranges of guides in which two composites of one length differ; near ones are joined.
    pub fn changed_since(&self, before: &Self) -> Vec<std::ops::Range<usize>> {
        /// Guides between two changes that are not worth another copy.
        const GAP: usize = 8;
        let mut ranges: Vec<std::ops::Range<usize>> = Vec::new();
        for (i, (a, b)) in self.guides.iter().zip(&before.guides).enumerate() {
            if a != b {
                match ranges.last_mut().filter(|last| i <= last.end + GAP) {
                    Some(last) => last.end = i + 1,
                    None => ranges.push(i..i + 1),
                }
            }
        }
        ranges
    }
}

/// As generation reads it.
pub fn composed(guide: &SculptGuide) -> Composed {
    let mut out = [[0.0; 4]; K];
    for (out, offset) in out.iter_mut().zip(&guide.offsets) {
        out[..3].copy_from_slice(offset);
    }
    (out[0][3], out[1][3], out[2][3]) = (guide.length, guide.cut, guide.keep);
    out
}
