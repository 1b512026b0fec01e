//! One layer of guides under the law that moves it: what is fixed at bind time, and the state. CPU and GPU solver keep the
//! same numbers in the same order, so that either goes on from the other's.

use std::sync::Arc;

use glam::{Vec3, Vec4, Vec4Swizzles};
use lorelei_core::binding::Tie;
use lorelei_core::guides::GuideSet;
use lorelei_core::io::Watch;
use lorelei_core::moved::{Follow, MovedHair};
use lorelei_core::simulation::{Moved, RestShape, SimulationSettings, Solver};
use rayon::prelude::*;

use crate::air::Air;
use crate::chain::{self, ChainParams, ChainRest, ChainVertex, step_chain};
use crate::clock::Frame;
use crate::contact::Obstacles;
use crate::follow::Following;
use crate::lanes::Lanes;
use crate::pose::Pose;
use crate::pull::PullParams;
use crate::rest::{Exposure, Hold, Rest, Windage};
use crate::rod::{self, Eliminated, N_PINNED, RodParams, RodVertex, step_rod};
use crate::rod_rest::{self, RodRest};
use crate::volume::shares_of;

/// Of all layers, cm.
pub(crate) fn longest_edge<'a>(layers: impl Iterator<Item = &'a SimulatedLayer>) -> f32 {
    layers.map(|layer| layer.longest_edge).fold(0.0, f32::max)
}

/// Guides, and how they move.
#[derive(Debug, Clone)]
pub struct SimulatedLayer {
    guides: GuideSet,
    pub rest: Rest,
    /// Between two vertices at rest, cm.
    longest_edge: f32,
    hold: Hold,
    law: Law,
    /// What the picture shows: vertex `k` of guide `g` at `g * n_vertices + k`.
    pub shown: Vec<Vec4>,
}

#[derive(Debug, Clone)]
enum Law {
    Rods { params: RodParams, is_weightless: bool, rest: Vec<RodRest>, state: Vec<RodVertex> },
    Chains { params: ChainParams, is_weightless: bool, rest: Vec<ChainRest>, state: Vec<ChainVertex> },
}

impl SimulatedLayer {
    /// At rest on a head at `pose`.
    pub fn new(hair: &MovedHair, obstacles: Obstacles<'_>, settings: &SimulationSettings, pose: Pose) -> Self {
        Self::new_watched(hair, obstacles, settings, pose, Watch::default()).expect(NOT_CANCELLED)
    }

    /// `None` where it was cancelled.
    pub fn new_watched(
        hair: &MovedHair,
        obstacles: Obstacles<'_>,
        settings: &SimulationSettings,
        pose: Pose,
        watch: Watch<'_>,
    ) -> Option<Self> {
        let following = match &hair.follow {
            Follow::Spline(spline) => Some(Arc::new(Following::new(spline, &hair.curves))),
            Follow::Guides | Follow::Strands => None,
        };
        let rest = Rest { ties: hair.ties.clone(), following, ..Rest::new(&hair.curves, obstacles) };
        Self::of_rest(&hair.curves, rest, settings, pose, watch)
    }

    fn of_rest(
        guides: &GuideSet,
        rest: Rest,
        settings: &SimulationSettings,
        pose: Pose,
        watch: Watch<'_>,
    ) -> Option<Self> {
        let law = Law::new(&rest, settings, pose, watch)?;
        let hold = Hold::new(settings);
        let n = rest.n_vertices.max(1) as usize;
        let edges = rest.vertices.chunks(n).flat_map(|strand| strand.windows(2));
        let longest_edge = edges.map(|edge| edge[0].xyz().distance(edge[1].xyz())).fold(0.0, f32::max);
        let mut layer = Self { guides: guides.clone(), rest, longest_edge, hold, law, shown: Vec::new() };
        layer.reset(pose);
        Some(layer)
    }

    /// The movement goes on with other settings; true where what is fixed is another: what [`SimulatedLayer::rest_vec4s`]
    /// and the state hold. With `are_moved` the obstacles are not where they were.
    pub fn set_settings(
        &mut self,
        obstacles: Obstacles<'_>,
        are_moved: bool,
        settings: &SimulationSettings,
        pose: Pose,
    ) -> bool {
        let is_same_law = match &mut self.law {
            Law::Rods { params, is_weightless, .. } => {
                let new = RodParams::new(settings);
                let is_same = settings.solver == Solver::Rods
                    && *is_weightless == is_weightless_in(settings)
                    && params.bend == new.bend
                    && params.gravity == new.gravity;
                *params = new;
                is_same
            }
            Law::Chains { params, is_weightless, .. } => {
                let new = ChainParams::new(settings);
                let is_same = settings.solver == Solver::Chains
                    && *is_weightless == is_weightless_in(settings)
                    && params.step_secs == new.step_secs
                    && params.gravity_step == new.gravity_step;
                *params = new;
                is_same
            }
        };
        if is_same_law && !are_moved && self.hold == Hold::new(settings) {
            return false;
        }
        self.rest = self.rest_among(obstacles);
        self.hold = Hold::new(settings);
        self.rebind(settings, pose);
        true
    }

    /// Tie guides to the style: see [`Rest::ties`]. The movement goes on; false where they are tied so already.
    pub fn set_ties(&mut self, ties: &[Tie], settings: &SimulationSettings, pose: Pose) -> bool {
        if self.rest.ties == ties {
            return false;
        }
        self.rest.ties = ties.to_vec();
        self.rebind(settings, pose);
        true
    }

    /// What is fixed, anew; the state stays.
    fn rebind(&mut self, settings: &SimulationSettings, pose: Pose) {
        let law = Law::new(&self.rest, settings, pose, Watch::default()).expect(NOT_CANCELLED);
        let before = std::mem::replace(&mut self.law, law);
        match (&mut self.law, before) {
            (Law::Rods { state, .. }, Law::Rods { state: before, .. }) => *state = before,
            (Law::Chains { state, .. }, Law::Chains { state: before, .. }) => *state = before,
            (Law::Rods { .. }, Law::Chains { state: before, .. }) => {
                let of = |x: fn(&ChainVertex) -> Vec4| before.iter().map(|v| x(v).xyz()).collect::<Vec<_>>();
                self.put(&of(|v| v.x), &of(|v| v.prev));
            }
            (Law::Chains { .. }, Law::Rods { state: before, .. }) => {
                let of = |x: fn(&RodVertex) -> Vec3| before.iter().map(x).collect::<Vec<_>>();
                self.put(&of(|v| v.x), &of(|v| v.prev));
            }
        }
    }

    /// The same guides at rest under another law.
    pub fn under(&self, obstacles: Obstacles<'_>, settings: &SimulationSettings, pose: Pose) -> Self {
        let rest = self.rest_among(obstacles);
        Self::of_rest(&self.guides, rest, settings, pose, Watch::default()).expect(NOT_CANCELLED)
    }

    /// The same hair at rest among other obstacles.
    fn rest_among(&self, obstacles: Obstacles<'_>) -> Rest {
        let (ties, following) = (self.rest.ties.clone(), self.rest.following.clone());
        Rest { ties, following, ..Rest::new(&self.guides, obstacles) }
    }

    /// Back to rest on a head at `pose`.
    pub fn reset(&mut self, pose: Pose) {
        match &mut self.law {
            Law::Rods { rest, state, .. } => *state = rest.iter().map(|rest| rod_rest::at_rest(rest, pose)).collect(),
            Law::Chains { rest, state, .. } => {
                *state = rest.iter().map(|rest| chain::at_rest(rest, pose)).collect();
            }
        }
        self.shown = self.rest.vertices.iter().map(|place| pose.apply(place.xyz()).extend(0.0)).collect();
    }

    /// Set the state: positions now and one step ago, world.
    pub fn put(&mut self, x: &[Vec3], prev: &[Vec3]) {
        let n = self.rest.n_vertices.max(1) as usize;
        match &mut self.law {
            Law::Rods { rest, state, .. } => {
                let strands = state.chunks_mut(n).zip(rest.chunks(n)).zip(x.chunks(n).zip(prev.chunks(n)));
                strands.for_each(|((s, rest), (x, prev))| rod_rest::put(s, rest, x, prev));
            }
            Law::Chains { state, .. } => {
                for (vertex, (x, prev)) in state.iter_mut().zip(x.iter().zip(prev)) {
                    let prev = prev.extend(0.0);
                    *vertex = ChainVertex { x: x.extend(0.0), prev, begun: prev };
                }
            }
        }
        self.shown = x.iter().map(|x| x.extend(0.0)).collect();
    }

    /// Where vertices are after the last step, and where they were before it.
    pub fn places(&self) -> (Vec<Vec4>, Vec<Vec4>) {
        match &self.law {
            Law::Rods { state, .. } => state.iter().map(|v| (v.x.extend(0.0), v.begun().extend(0.0))).unzip(),
            Law::Chains { state, .. } => state.iter().map(|v| (v.x, v.begun)).unzip(),
        }
    }

    /// At rest, head space.
    pub fn guides(&self) -> &GuideSet {
        &self.guides
    }

    pub fn n_guides(&self) -> usize {
        self.rest.n_guides()
    }

    /// What the air takes hold of: see [`Rest::windage`]. A strand stands for itself, a guide for the hair around it.
    pub(crate) fn windage(&self, g_per_cm: f32, moved: Moved) -> Windage {
        let shares = match moved {
            Moved::Guides | Moved::Mesh | Moved::Rope => shares_of(&self.rest),
            Moved::Strands => vec![1.0; self.n_guides()],
        };
        self.rest.windage(g_per_cm, &shares, &self.hold)
    }

    pub(crate) fn is_of_rods(&self) -> bool {
        matches!(self.law, Law::Rods { .. })
    }

    /// Seconds a step.
    pub fn step_secs(settings: &SimulationSettings) -> f32 {
        RodParams::new(settings).step_secs
    }

    /// Bytes of the parameters, of what is fixed, and of the state, as the GPU reads them.
    pub(crate) fn params_bytes(&self) -> Vec<u8> {
        match &self.law {
            Law::Rods { params, .. } => bytemuck::bytes_of(params).to_vec(),
            Law::Chains { params, .. } => bytemuck::bytes_of(params).to_vec(),
        }
    }

    pub(crate) fn rest_vec4s(&self) -> &[Vec4] {
        match &self.law {
            Law::Rods { rest, .. } => bytemuck::cast_slice(rest),
            Law::Chains { rest, .. } => bytemuck::cast_slice(rest),
        }
    }

    pub(crate) fn state_vec4s(&self) -> &[Vec4] {
        match &self.law {
            Law::Rods { state, .. } => bytemuck::cast_slice(state),
            Law::Chains { state, .. } => bytemuck::cast_slice(state),
        }
    }

    pub(crate) fn state_vec4s_mut(&mut self) -> &mut [Vec4] {
        match &mut self.law {
            Law::Rods { state, .. } => bytemuck::cast_slice_mut(state),
            Law::Chains { state, .. } => bytemuck::cast_slice_mut(state),
        }
    }

    /// How many of the numbers of [`SimulatedLayer::state_vec4s`] are one vertex's: its place, where it was a step ago, and
    /// what else its law keeps.
    pub(crate) fn vec4s_a_vertex(&self) -> usize {
        match &self.law {
            Law::Rods { .. } => size_of::<RodVertex>() / size_of::<Vec4>(),
            Law::Chains { .. } => size_of::<ChainVertex>() / size_of::<Vec4>(),
        }
    }

    /// How the GPU keeps the state, and in front of it what is fixed.
    pub(crate) fn lanes(&self) -> [Lanes; 2] {
        let vertices = self.rest.n_vertices;
        let lanes = |n_lanes: usize, of_rest: usize, of_state: usize| {
            [of_rest, of_state].map(|bytes| Lanes {
                side_by_side: n_lanes as u32,
                vertices,
                numbers: (bytes / size_of::<Vec4>()) as u32,
            })
        };
        match &self.law {
            Law::Rods { .. } => lanes(rod::LANES, size_of::<RodRest>(), size_of::<RodVertex>()),
            Law::Chains { .. } => lanes(1, size_of::<ChainRest>(), size_of::<ChainVertex>()),
        }
    }

    /// Take over a state of [`SimulatedLayer::state_vec4s`]' length.
    pub(crate) fn set_state_vec4s(&mut self, numbers: &[Vec4]) {
        match &mut self.law {
            Law::Rods { state, .. } => state.copy_from_slice(bytemuck::cast_slice(numbers)),
            Law::Chains { state, .. } => state.copy_from_slice(bytemuck::cast_slice(numbers)),
        }
    }

    /// All of a frame's steps. Twin of the entry points of `sim_rod.wgsl` and `sim_chain.wgsl`.
    pub(crate) fn run(&mut self, air: &Air, obstacles: Obstacles<'_>, pull: &PullParams, frame: &Frame) {
        let n = self.rest.n_vertices as usize;
        if n < N_PINNED {
            return;
        }
        let places = self.rest.vertices.par_chunks_exact(n);
        let shown = self.shown.par_chunks_exact_mut(n);
        match &mut self.law {
            Law::Rods { params, rest, state, .. } => {
                let strands = state.par_chunks_exact_mut(n).zip(rest.par_chunks_exact(n)).zip(places.zip(shown));
                strands.for_each_init(
                    || vec![Eliminated::default(); n],
                    |eliminated, ((s, rest), (places, shown))| {
                        if let Some(by) = frame.carry {
                            rod::carry(s, by);
                        }
                        for kept in eliminated.iter_mut() {
                            kept.room = 0.0;
                        }
                        for (step, poses) in frame.poses.windows(2).enumerate() {
                            let obstacles = obstacles.at_step(step, frame.n_steps());
                            if step + 1 == frame.n_steps() {
                                for vertex in s.iter_mut() {
                                    vertex.set_begun(vertex.x);
                                }
                            }
                            step_rod(s, rest, params, air, obstacles, pull, poses[0], poses[1], eliminated);
                        }
                        rod::recover(s, rest, frame.poses[frame.n_steps()]);
                        show(shown, places, frame, |k| (s[k].x, s[k].begun()));
                    },
                );
            }
            Law::Chains { params, rest, state, .. } => {
                let strands = state.par_chunks_exact_mut(n).zip(rest.par_chunks_exact(n)).zip(places.zip(shown));
                let move_strand = |rooms: &mut Vec<f32>, ((s, rest), (places, shown)): ChainStrand<'_>| {
                    if let Some(by) = frame.carry {
                        chain::carry(s, by);
                    }
                    rooms.fill(0.0);
                    for (step, poses) in frame.poses.windows(2).enumerate() {
                        let obstacles = obstacles.at_step(step, frame.n_steps());
                        for vertex in s.iter_mut() {
                            vertex.begun = vertex.x;
                        }
                        step_chain(s, rest, params, air, obstacles, pull, poses[0], poses[1], rooms);
                    }
                    chain::recover(s, rest, frame.poses[frame.n_steps()]);
                    show(shown, places, frame, |k| (s[k].x.xyz(), s[k].begun.xyz()));
                };
                strands.for_each_init(|| vec![0.0; n], move_strand);
            }
        }
    }
}

/// Strands that are made ready between two looks whether it is cancelled: a few milliseconds.
const STRANDS_AT_ONCE: usize = 2048;
const NOT_CANCELLED: &str = "nobody can cancel what is not watched";

/// What is fixed of every strand of `n` vertices, a run of strands at a time; `None` where it was cancelled.
fn of_strands<R: Send>(
    places: &[Vec4],
    exposures: &[Exposure],
    n: usize,
    of: impl Fn(&[Vec4], &[Exposure]) -> Vec<R> + Sync,
    watch: Watch<'_>,
) -> Option<Vec<R>> {
    let run = n * STRANDS_AT_ONCE;
    let mut fixed = Vec::with_capacity(places.len());
    for (places_of_run, exposures_of_run) in places.chunks(run).zip(exposures.chunks(run)) {
        watch.progress(fixed.len() as f32 / places.len() as f32);
        if watch.cancelled() {
            return None;
        }
        let strands = places_of_run.par_chunks(n).zip(exposures_of_run.par_chunks(n));
        fixed.par_extend(strands.flat_map_iter(|(places, exposures)| of(places, exposures)));
    }
    Some(fixed)
}

impl Law {
    /// At rest; `None` where it was cancelled.
    fn new(rest: &Rest, settings: &SimulationSettings, pose: Pose, watch: Watch<'_>) -> Option<Self> {
        let n = rest.n_vertices.max(1) as usize;
        let exposures = rest.exposures(&Hold::new(settings));
        let is_weightless = is_weightless_in(settings);
        Some(match settings.solver {
            Solver::Rods => {
                let params = RodParams::new(settings);
                let of =
                    |places: &[Vec4], exposures: &[_]| rod_rest::rest_of(places, exposures, &params, is_weightless);
                let rest: Vec<RodRest> = of_strands(&rest.vertices, &exposures, n, of, watch)?;
                let state = rest.iter().map(|rest| rod_rest::at_rest(rest, pose)).collect();
                Self::Rods { params, is_weightless, rest, state }
            }
            Solver::Chains => {
                let params = ChainParams::new(settings);
                let of = |places: &[Vec4], exposures: &[_]| chain::rest_of(places, exposures, &params, is_weightless);
                let rest: Vec<ChainRest> = of_strands(&rest.vertices, &exposures, n, of, watch)?;
                let state = rest.iter().map(|rest| chain::at_rest(rest, pose)).collect();
                Self::Chains { params, is_weightless, rest, state }
            }
        })
    }
}

/// The style is the shape of the hair without weight.
fn is_weightless_in(settings: &SimulationSettings) -> bool {
    settings.rest_shape == RestShape::Weightless
}

/// What a thread moves at a time: state and rest of a chain, and where it rests and is shown.
type ChainStrand<'a> = ((&'a mut [ChainVertex], &'a [ChainRest]), (&'a [Vec4], &'a mut [Vec4]));

/// The picture is up to a step ahead of the last step: go on at the present velocity, roots with the head.
fn show(shown: &mut [Vec4], places: &[Vec4], frame: &Frame, at: impl Fn(usize) -> (Vec3, Vec3)) {
    for (k, shown) in shown.iter_mut().enumerate() {
        let (x, begun) = at(k);
        let ahead = x + frame.ahead * (x - begun);
        *shown = if k < N_PINNED { frame.shown.apply(places[k].xyz()) } else { ahead }.extend(0.0);
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn while_strands_are_made_ready_it_is_told_how_far_that_is_and_a_cancel_ends_it() {
        let n_strands = 3 * STRANDS_AT_ONCE;
        let strand = |i: usize| (0..4).map(move |k| Vec3::new(0.01 * i as f32, -(k as f32), 6.0));
        let guides = GuideSet { n_vertices: 4, positions: (0..n_strands).flat_map(strand).collect() };
        let hair = MovedHair::of_guides(&[&guides]).remove(0);
        for solver in [Solver::Rods, Solver::Chains] {
            let settings = SimulationSettings { solver, ..SimulationSettings::default() };
            let obstacles = Obstacles::new(None, &[], &settings);
            let make = |watch| SimulatedLayer::new_watched(&hair, obstacles, &settings, Pose::IDENTITY, watch);
            let (told, cancel) = (RefCell::new(Vec::new()), AtomicBool::new(false));
            let tell = |share: f32| told.borrow_mut().push(share);
            let made = make(Watch::new(&tell, &cancel)).unwrap();
            assert_eq!(made.shown.len(), 4 * n_strands);
            let expected = [0.0, 1.0 / 3.0, 2.0 / 3.0];
            assert!(told.take().iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6));
            let at_half = |share: f32| cancel.store(share > 0.5, Ordering::Relaxed);
            assert!(make(Watch::new(&at_half, &cancel)).is_none());
        }
    }
}
