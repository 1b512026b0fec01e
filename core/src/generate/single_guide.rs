//! Interpolated strands that go through the head while it moves, switched to one guide.
//!
//! Guides keep out of the head; a blend of several need not, where they part around it. Before strands are made, each
//! is looked along for the first control point that is deeper in the head than it rests (Tariq and Bavoil 2008, as the
//! SIGGRAPH 2010 course on real-time hair tells it). From there to the tip the strand goes with its strongest guide
//! alone, at the offset from it that it has at rest; over a few control points before, the one passes into the other.
//! Changing only the points that are inside would leave the rest of the strand where it hung, with a kink between.
//!
//! What is switched grows with the depth, and where it begins is found between two control points: a strand does not
//! jump when it begins to touch.

use glam::{Affine3A, Vec3};
use rayon::prelude::*;

use super::{Pose, smoothstep};
use crate::binding::LayerBinding;
use crate::simulation::Interpolated;

/// Control points over which a blend of guides passes into one.
pub const BLENDING_ZONE: f32 = 4.0;
/// Deeper than this, centimetres, a strand is in the head and not only on it.
pub const TOUCHING: f32 = 0.01;
/// Depth at which a strand is switched fully, centimetres.
pub const FULL_DEPTH: f32 = 0.2;

/// Where and how far a strand goes with one guide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Control point where it enters the head, with its fraction.
    pub first: f32,
    /// How far it is switched from there on: 0 not at all, 1 fully.
    pub amount: f32,
    /// Its strongest guide.
    pub guide_idx: u32,
}

impl Hit {
    pub const NONE: Self = Self { first: 0.0, amount: 0.0, guide_idx: 0 };

    /// How far control point `i` goes with the one guide.
    pub fn share(&self, i: u32) -> f32 {
        self.amount * ((i as f32 - self.first) / BLENDING_ZONE + 1.0).clamp(0.0, 1.0)
    }
}

/// Every strand's hit; empty where none is asked for, or where there is no head to hit.
pub(super) fn first_hits(binding: &LayerBinding, guide_positions: &[Vec3], pose: &Pose<'_>) -> Vec<Hit> {
    if pose.interpolated != Some(Interpolated::SingleGuide) || pose.field.is_none() {
        return Vec::new();
    }
    let head_from_world = pose.world_from_head.inverse();
    let hit = |strand_idx: usize| first_hit(binding, guide_positions, pose, &head_from_world, strand_idx);
    (0..binding.n_strands()).into_par_iter().map(hit).collect()
}

fn first_hit(
    binding: &LayerBinding,
    guide_positions: &[Vec3],
    pose: &Pose<'_>,
    head_from_world: &Affine3A,
    strand_idx: usize,
) -> Hit {
    let Some(field) = pose.field else { return Hit::NONE };
    let n = binding.guides.n_vertices;
    let mut strongest = Hit::NONE;
    let mut most = f32::NEG_INFINITY;
    for influence in binding.influences(strand_idx) {
        if influence.weight > most {
            most = influence.weight;
            strongest.guide_idx = influence.guide_idx;
        }
    }
    let mut deepest = 0.0_f32;
    let mut before = 0.0;
    let mut is_hit = false;
    for i in 0..n {
        let left = 1.0 - smoothstep(0.0, 1.0, i as f32 / (n - 1) as f32) * (1.0 - binding.offset_at_tip);
        let offset = left * binding.root_offsets[strand_idx];
        let (mut p, mut at_rest) = (Vec3::ZERO, Vec3::ZERO);
        for influence in binding.influences(strand_idx) {
            let at = (influence.guide_idx * n + i) as usize;
            p += influence.weight * guide_positions[at];
            at_rest += influence.weight * binding.guides.positions[at];
        }
        let mut clearance = field.sample(head_from_world.transform_point3(p) + offset);
        if clearance < 0.0 {
            clearance -= field.sample(at_rest + offset).min(0.0);
        }
        clearance += TOUCHING;
        if clearance < 0.0 {
            if !is_hit {
                is_hit = true;
                let above = if before > 0.0 { before / (before - clearance) } else { 1.0 };
                strongest.first = i as f32 - 1.0 + above;
            }
            deepest = deepest.max(-clearance);
        }
        before = clearance;
    }
    strongest.amount = smoothstep(0.0, FULL_DEPTH, deepest);
    strongest
}
