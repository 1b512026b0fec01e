//! Strands as a structure of arrays: what importers return, exporters take and generation makes.
//!
//! A vector of strand objects was rejected: 100,000 allocations, and nothing that the GPU can copy.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Curves from root to tip. Strand `i` owns `points[offsets[i]..offsets[i + 1]]`.
///
/// Optional attributes are either empty or as long as what they belong to (points or strands).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Strands {
    /// Positions in centimetres, all strands appended, each from root to tip.
    pub points: Vec<Vec3>,
    /// `n_strands + 1` offsets into `points`; starts at 0, ends at `points.len()`, never decreases.
    pub offsets: Vec<u32>,
    /// Per strand: an id that stays with the strand under every edit. Empty: the index is the id.
    pub ids: Vec<u32>,
    /// Per point: radius in micrometres. Empty: the layer's own width applies.
    pub radii_um: Vec<f32>,
    /// Per point: linear RGB. Empty: the layer's own material applies.
    pub colours: Vec<[f32; 3]>,
    /// Per point: opacity 0-1 (1 opaque). Empty: opaque.
    pub opacities: Vec<f32>,
    /// Per strand: texture coordinates of the root on the scalp. Empty: unknown.
    pub root_uvs: Vec<[f32; 2]>,
}

impl Default for Strands {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            offsets: vec![0],
            ids: Vec::new(),
            radii_um: Vec::new(),
            colours: Vec::new(),
            opacities: Vec::new(),
            root_uvs: Vec::new(),
        }
    }
}

impl Strands {
    pub fn n_strands(&self) -> usize {
        self.offsets.len() - 1
    }

    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// The point range of one strand.
    pub fn range(&self, strand_idx: usize) -> std::ops::Range<usize> {
        self.offsets[strand_idx] as usize..self.offsets[strand_idx + 1] as usize
    }

    /// The points of one strand, root first.
    pub fn strand(&self, strand_idx: usize) -> &[Vec3] {
        &self.points[self.range(strand_idx)]
    }

    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[Vec3]> {
        (0..self.n_strands()).map(|strand_idx| self.strand(strand_idx))
    }

    /// Append one strand; for attributes use the fields.
    pub fn push(&mut self, points: &[Vec3]) {
        self.points.extend_from_slice(points);
        self.offsets.push(self.points.len() as u32);
    }

    /// The stable id of a strand: its own, or its index where none were given.
    pub fn id(&self, strand_idx: usize) -> u32 {
        self.ids.get(strand_idx).copied().unwrap_or(strand_idx as u32)
    }

    /// Only the strands of which `is_kept` says so, in their order.
    pub fn retain(&mut self, is_kept: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.n_strands()).filter(|&strand_idx| is_kept(strand_idx)).collect();
        if kept.len() == self.n_strands() {
            return;
        }
        let ranges: Vec<_> = kept.iter().map(|&strand_idx| self.range(strand_idx)).collect();
        fn of_points<T: Copy>(values: &mut Vec<T>, ranges: &[std::ops::Range<usize>]) {
            if !values.is_empty() {
                *values = ranges.iter().flat_map(|range| values[range.clone()].iter().copied()).collect();
            }
        }
        fn of_strands<T: Copy>(values: &mut Vec<T>, kept: &[usize]) {
            if !values.is_empty() {
                *values = kept.iter().map(|&strand_idx| values[strand_idx]).collect();
            }
        }
        of_points(&mut self.points, &ranges);
        of_points(&mut self.radii_um, &ranges);
        of_points(&mut self.colours, &ranges);
        of_points(&mut self.opacities, &ranges);
        of_strands(&mut self.ids, &kept);
        of_strands(&mut self.root_uvs, &kept);
        self.offsets.truncate(1);
        for range in &ranges {
            self.offsets.push(self.offsets[self.offsets.len() - 1] + range.len() as u32);
        }
    }

    /// Smallest box around all points as (min, max); `None` where there are no points.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p))))
    }

    /// Bytes held by the arrays.
    pub fn n_bytes(&self) -> usize {
        self.points.len() * 12
            + self.offsets.len() * 4
            + self.ids.len() * 4
            + self.radii_um.len() * 4
            + self.colours.len() * 12
            + self.opacities.len() * 4
            + self.root_uvs.len() * 8
    }
}

/// Length of a polyline in its own unit.
pub fn polyline_length(points: &[Vec3]) -> f32 {
    points.windows(2).map(|p| p[0].distance(p[1])).sum()
}
