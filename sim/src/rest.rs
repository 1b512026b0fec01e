//! What the solver compares with: every vertex at rest in head space, and how far from the head it rests.

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::SimulationSettings;
use rayon::prelude::*;

use crate::bounded;
use crate::contact::Obstacles;

/// Contacts begin this much closer than the rest distance, so that rounding makes none at rest, centimetres.
const SLACK: f32 = 1e-3;
/// Distance from the root at which hair feels half of the wind, cm: it lies in the lee of its neighbours there. Without, a
/// wind along the scalp folds the roots over at the parting.
const SHELTER: f32 = 4.0;
/// Times its length, where the hold has faded to a thousandth and ends.
const HOLD_ENDS: f32 = 7.0;
/// Longest edge that counts for the air, cm.
const LONGEST: f32 = 10.0;
/// How fast what is tied springs back to the style, Hz.
const TIE: f32 = 12.0;
/// Share of a strand over which a tie ends.
const TIE_ENDS: f32 = 0.08;

/// What acts on a vertex for the place that it has on its strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Stiffness over mass by which it is held to the style, 1/s2.
    pub hold: f32,
    /// Share of the wind that it feels.
    pub wind: f32,
}

/// Hair of which the wind takes hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Windage {
    /// Mass at each vertex, g.
    pub of_vertices: Vec<f32>,
    /// Of all of them.
    pub g: f32,
}

/// The hold of the roots to the style: it falls off along the strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// Stiffness over mass at the root, 1/s2.
    pub stiffness: f32,
    /// Distance over which it falls to 1/e, cm.
    pub length: f32,
}

impl Hold {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let hold = std::f32::consts::TAU * bounded(settings.hold, default.hold, 0.0, 100.0);
        Self { stiffness: hold * hold, length: bounded(settings.hold_length, default.hold_length, 0.01, 1e4) }
    }

    fn at(self, from_root: f32) -> f32 {
        if from_root > HOLD_ENDS * self.length { 0.0 } else { self.stiffness * (-from_root / self.length).exp() }
    }
}

/// Stiffness over mass of a tie up to the share `tied` of a strand of `length`, 1/s2.
fn tie_at(from_root: f32, tied: f32, length: f32) -> f32 {
    let past = from_root / length.max(1e-6) - tied;
    let stiffness = (std::f32::consts::TAU * TIE).powi(2);
    if tied <= 0.0 { 0.0 } else { stiffness * (1.0 - past / TIE_ENDS).clamp(0.0, 1.0) }
}

/// Guides at rest. Vertex `k` of guide `g` is `vertices[g * n_vertices + k]`: xyz its position in head space,
/// w the distance from the obstacles at which it rests, less a slack; it is never pushed farther than that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rest {
    pub n_vertices: u32,
    pub vertices: Vec<Vec4>,
    /// Per guide: share of it, from the root, that is tied, 0-1; empty: nothing is.
    pub ties: Vec<f32>,
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
        Self { n_vertices: guides.n_vertices, vertices, ties: Vec::new() }
    }

    /// What acts on each vertex for the place that it has on its strand.
    pub fn exposures(&self, hold: Hold) -> Vec<Exposure> {
        let n = self.n_vertices.max(1) as usize;
        let of_strand = |(guide_idx, places): (usize, &[Vec4])| -> Vec<Exposure> {
            let mut from_root = 0.0;
            let mut distances = vec![0.0; places.len()];
            for k in 1..places.len() {
                from_root += places[k].xyz().distance(places[k - 1].xyz());
                distances[k] = from_root;
            }
            let tied = self.ties.get(guide_idx).map_or(0.0, |tied| tied.clamp(0.0, 1.0));
            let of = |at: f32| Exposure { hold: hold.at(at) + tie_at(at, tied, from_root), wind: at / (at + SHELTER) };
            distances.into_iter().map(of).collect()
        };
        self.vertices.par_chunks(n).enumerate().flat_map_iter(of_strand).collect()
    }

    /// Mass of hair at each vertex of which the wind takes hold, g: what lies in the lee of its neighbours slows the air as
    /// little as it feels of it. `g_per_cm` is of all guides side by side, `shares` of each over that of the mean.
    pub fn windage(&self, g_per_cm: f32, shares: &[f32], hold: Hold) -> Windage {
        let n = self.n_vertices.max(1) as usize;
        let g_per_cm = bounded(g_per_cm, 0.0, 0.0, 1e6) / self.n_guides().max(1) as f32;
        let edge = |a: usize, b: usize| self.vertices[a].xyz().distance(self.vertices[b].xyz()).min(LONGEST);
        let mass = |(idx, exposure): (usize, Exposure)| {
            let below = if idx % n > 0 { edge(idx - 1, idx) } else { 0.0 };
            let above = if idx % n + 1 < n { edge(idx, idx + 1) } else { 0.0 };
            g_per_cm * shares[idx / n] * exposure.wind * 0.5 * (below + above)
        };
        let of_vertices: Vec<f32> = self.exposures(hold).into_iter().enumerate().map(mass).collect();
        Windage { g: of_vertices.iter().sum(), of_vertices }
    }

    pub fn n_guides(&self) -> usize {
        self.vertices.len().checked_div(self.n_vertices as usize).unwrap_or(0)
    }
}
