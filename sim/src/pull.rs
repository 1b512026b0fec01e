//! A hand that holds hair while it moves: a spring from a vertex to the hand. Twin of `sim_pull.wgsl`.
//!
//! Of every strand one vertex is held, as far along it as the one that was grabbed: the strand turns freely about it, as
//! a lock does between two fingers. Strands that rest beside the grabbed one follow as far beside the hand as they rest,
//! the less the farther away. So which hair is held follows from how it rests alone: there is nothing to keep for each
//! vertex, and a solver that is made anew in the middle of a pull goes on with it.
//!
//! A pull is no part of the state and none of the document: it acts for as long as it is set.

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::guides::GuideSet;

use crate::bounded;
use crate::pose::{Pose, rotate};
use crate::rod::N_PINNED;

/// A pull over a longer way is no stronger, cm.
const FARTHEST: f32 = 5.0;
/// Farther away nobody's hand is, cm.
const MOST: f32 = 1e4;

/// A hand that holds hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// Where the held vertex rests, head space.
    pub rest: Vec3,
    /// Where along its strand it is, 0 root to 1 tip.
    pub along: f32,
    /// Root of its strand, head space.
    pub root: Vec3,
    /// Hair between the two, cm: a hand farther away holds it stretched.
    pub reach: f32,
    /// How far around it hair follows at rest, cm.
    pub radius: f32,
    /// World.
    pub hand: Vec3,
    /// Force over the mass of a strand and the way to the hand, 1/s2.
    pub strength: f32,
}

impl Pull {
    /// The hand on a vertex of guides at rest; `None` where there is none, or where it goes with the head.
    pub fn of_vertex(guides: &GuideSet, vertex_idx: usize) -> Option<Self> {
        let n = guides.n_vertices as usize;
        let k = vertex_idx.checked_rem(n)?;
        let strand = guides.positions.get(vertex_idx - k..=vertex_idx)?;
        if k < N_PINNED {
            return None;
        }
        Some(Self {
            rest: strand[k],
            along: k as f32 / (n - 1) as f32,
            root: strand[0],
            reach: strand.windows(2).map(|edge| edge[0].distance(edge[1])).sum(),
            radius: 2.0,
            hand: strand[k],
            strength: 2000.0,
        })
    }
}

/// A [`Pull`] made ready for a frame. Layout of `Pull` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PullParams {
    /// xyz where the held vertex rests, head space; w how far around it hair follows, cm.
    pub rest: Vec4,
    /// xyz where the hand is, world; w how strongly it pulls a whole strand, 1/s2: 0 while it is open.
    pub hand: Vec4,
    pub along: f32,
    pub pad: [f32; 3],
}

impl PullParams {
    /// With the head at `pose`. What is not finite holds nothing.
    pub fn new(pull: Option<&Pull>, pose: Pose) -> Self {
        let Some(pull) = pull else { return Self::default() };
        let numbers = [pull.along, pull.reach, pull.radius, pull.strength];
        let places = [pull.rest, pull.root, pull.hand];
        if !numbers.iter().all(|number| number.is_finite())
            || !places.iter().all(|place| place.abs().max_element() < MOST)
        {
            return Self::default();
        }
        let root = pose.apply(pull.root);
        let hand = root + (pull.hand - root).clamp_length_max(pull.reach.max(0.0));
        Self {
            rest: pull.rest.extend(bounded(pull.radius, 2.0, 0.01, 1e3)),
            hand: hand.extend(bounded(pull.strength, 0.0, 0.0, 1e5)),
            along: pull.along.clamp(0.0, 1.0),
            pad: [0.0; 3],
        }
    }

    /// How vertex `k`, which rests at `place` and is at `x`, is pulled: which way and how far, and how strongly, 1/s2.
    pub fn on(&self, k: usize, n_vertices: usize, place: Vec3, x: Vec3, after: Pose) -> (Vec3, f32) {
        let n_edges = (n_vertices - 1) as f32;
        if self.hand.w == 0.0 || k != (self.along * n_edges + 0.5) as usize {
            return (Vec3::ZERO, 0.0);
        }
        let aside = place - self.rest.xyz();
        let falloff = 1.0 - aside.length_squared() / (self.rest.w * self.rest.w);
        if falloff <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let way = self.hand.xyz() + rotate(after.rotation, aside) - x;
        // One vertex carries its whole strand.
        let strength = self.hand.w * falloff * falloff * n_edges;
        (way * (FARTHEST / way.length().max(1e-9)).min(1.0), strength)
    }
}
