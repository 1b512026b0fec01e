//! What the solver compares with: every vertex at rest in head space, and how far from the head it rests.

use glam::{Vec3, Vec4};
use lorelei_core::guides::GuideSet;
use rayon::prelude::*;

use crate::contact::Obstacles;

/// Contacts begin this much closer than the rest distance, so that rounding makes none at rest, centimetres.
const SLACK: f32 = 1e-3;
/// Guides at rest. Vertex `k` of guide `g` is `vertices[g * n_vertices + k]`: xyz its position in head space,
/// w the distance from the obstacles at which it rests, less a slack; it is never pushed farther than that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rest {
    pub n_vertices: u32,
    pub vertices: Vec<Vec4>,
}

impl Rest {
    /// Positions that are not finite become the origin: the solver cannot fail.
    pub fn new(guides: &GuideSet, obstacles: Obstacles<'_>) -> Self {
        let vertices = guides
            .positions
            .par_iter()
            .map(|&p| {
                let p = if p.is_finite() { p } else { Vec3::ZERO };
                p.extend(obstacles.rest_distance(p) - SLACK)
            })
            .collect();
        Self { n_vertices: guides.n_vertices, vertices }
    }

    pub fn n_guides(&self) -> usize {
        self.vertices.len().checked_div(self.n_vertices as usize).unwrap_or(0)
    }
}
