//! What the solver compares with: every vertex at rest in head space, and how far from the head it rests.

use std::sync::Arc;

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::binding::Tie;
use lorelei_core::guides::GuideSet;
use lorelei_core::pin::Pin;
use lorelei_core::simulation::SimulationSettings;
use rayon::prelude::*;

use crate::bounded;
use crate::contact::Obstacles;
use crate::follow::Following;

/// Contacts begin this much closer than the rest distance, so that rounding makes none at rest, centimetres.
const SLACK: f32 = 1e-3;
/// Distance from the root at which hair feels half of the wind, cm: it lies in the lee of its neighbours there. Without, a
/// wind along the scalp folds the roots over at the parting.
const SHELTER: f32 = 4.0;
/// Times its length, where the hold has faded to a thousandth and ends.
const HOLD_ENDS: f32 = 7.0;
/// Longest edge that counts for the air, cm.
const LONGEST: f32 = 10.0;
/// How fast what is tied or pinned springs back to the style, Hz.
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

/// What holds hair to the style by the settings: the roots' hold, which falls off along the strand, and pins.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Stiffness over mass at the root, 1/s2.
    pub stiffness: f32,
    /// Distance over which it falls to 1/e, cm.
    pub length: f32,
    /// Those that can hold hair.
    pub pins: Vec<Pin>,
}

impl Hold {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let hold = std::f32::consts::TAU * bounded(settings.hold, default.hold, 0.0, 100.0);
        Self {
            stiffness: hold * hold,
            length: bounded(settings.hold_length, default.hold_length, 0.01, 1e4),
            pins: settings.pins.iter().filter(|pin| pin.is_usable()).cloned().collect(),
        }
    }

    /// With the share of it that a strand has along its whole length.
    fn at(&self, from_root: f32, painted: f32) -> f32 {
        let fading = if from_root > HOLD_ENDS * self.length { 0.0 } else { (-from_root / self.length).exp() };
        self.stiffness * fading.max(painted)
    }

    /// Stiffness over mass by which pins hold each vertex of a strand, 1/s2. A pin holds all of the strand with what lies in
    /// it, as stiffly as if the whole strand were tied: however little that is, the rest does not pull it out.
    pub fn of_pins(&self, strand: &[Vec3]) -> Vec<f32> {
        let mut stiffness = vec![0.0_f32; strand.len()];
        for pin in &self.pins {
            let shares = pin.shares(strand);
            if shares.iter().all(|share| *share == 0.0) {
                continue;
            }
            let lengths = lengths_at(strand);
            let held: f32 = shares.iter().zip(&lengths).map(|(share, length)| share * length).sum();
            let times = (lengths.iter().sum::<f32>() / held.max(1e-6)).clamp(1.0, MOST_TIMES);
            shares.iter().zip(&mut stiffness).for_each(|(share, k)| *k = k.max(share * times * TIED));
        }
        stiffness
    }
}

/// Length of a strand that each of its vertices stands for: half of the edges beside it, cm.
pub(crate) fn lengths_at(strand: &[Vec3]) -> Vec<f32> {
    let mut lengths = vec![0.0; strand.len()];
    for (k, ends) in strand.windows(2).enumerate() {
        let half = 0.5 * ends[0].distance(ends[1]);
        lengths[k] += half;
        lengths[k + 1] += half;
    }
    lengths
}

/// Stiffness over mass of what is tied, 1/s2.
const TIED: f32 = (std::f32::consts::TAU * TIE) * (std::f32::consts::TAU * TIE);
/// Times that at most, where a pin touches a strand but for a point.
const MOST_TIMES: f32 = 100.0;

/// Stiffness over mass of a tie up to the share `tied` of a strand of `length`, 1/s2.
fn tie_at(from_root: f32, tied: f32, length: f32) -> f32 {
    let past = from_root / length.max(1e-6) - tied;
    if tied <= 0.0 { 0.0 } else { TIED * (1.0 - past / TIE_ENDS).clamp(0.0, 1.0) }
}

/// Guides at rest. Vertex `k` of guide `g` is `vertices[g * n_vertices + k]`: xyz its position in head space,
/// w the distance from the obstacles at which it rests, less a slack; it is never pushed farther than that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rest {
    pub n_vertices: u32,
    pub vertices: Vec<Vec4>,
    /// Per guide; empty: nothing is tied.
    pub ties: Vec<Tie>,
    /// What follows them, where that is what pins hold.
    pub following: Option<Arc<Following>>,
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
        Self { n_vertices: guides.n_vertices, vertices, ties: Vec::new(), following: None }
    }

    /// What acts on each vertex for the place that it has on its strand.
    pub fn exposures(&self, hold: &Hold) -> Vec<Exposure> {
        let n = self.n_vertices.max(1) as usize;
        let of_following = self.following.as_ref().filter(|_| !hold.pins.is_empty());
        let pinned_curves = of_following.map(|following| following.pinned(hold, &self.vertices));
        let of_strand = |(guide_idx, places): (usize, &[Vec4])| -> Vec<Exposure> {
            let strand: Vec<Vec3> = places.iter().map(|place| place.xyz()).collect();
            let mut from_root = 0.0;
            let mut distances = vec![0.0; strand.len()];
            for k in 1..strand.len() {
                from_root += strand[k].distance(strand[k - 1]);
                distances[k] = from_root;
            }
            let tie = self.ties.get(guide_idx).copied().unwrap_or_default();
            let (tied, painted) = (tie.tied.clamp(0.0, 1.0), tie.hold.clamp(0.0, 1.0));
            let of = |(&at, pinned): (&f32, f32)| Exposure {
                hold: hold.at(at, painted) + tie_at(at, tied, from_root).max(pinned),
                wind: at / (at + SHELTER),
            };
            let pinned = match &pinned_curves {
                Some(pinned) => pinned[guide_idx * n..][..strand.len()].to_vec(),
                None => hold.of_pins(&strand),
            };
            distances.iter().zip(pinned).map(of).collect()
        };
        self.vertices.par_chunks(n).enumerate().flat_map_iter(of_strand).collect()
    }

    /// Mass of hair at each vertex of which the wind takes hold, g: what lies in the lee of its neighbours slows the air as
    /// little as it feels of it. `g_per_cm` is of all guides side by side, `shares` of each over that of the mean.
    pub fn windage(&self, g_per_cm: f32, shares: &[f32], hold: &Hold) -> Windage {
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
