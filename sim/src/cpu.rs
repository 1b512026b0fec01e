//! The reference solver: every guide on the CPU, in parallel. The GPU solver is tested against it.

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::SimulationSettings;
use rayon::prelude::*;

use crate::air::Air;
use crate::clock::{Clock, Frame};
use crate::contact::{Capsule, Obstacles, arrive, capsules_of, come_from};
use crate::measure::{Measure, measure};
use crate::pose::Pose;
use crate::rest::Rest;
use crate::state::SolverState;
use crate::strand::{StepParams, Strand, step_strand};

struct Layer {
    guides: GuideSet,
    rest: Rest,
    x: Vec<Vec4>,
    prev: Vec<Vec4>,
    /// Where the last step began: what `prev` is, were it not moved by contacts and lengths.
    begun: Vec<Vec4>,
    shown: Vec<Vec4>,
}

/// Rest state in, positions out. Cannot fail.
pub struct CpuSolver {
    layers: Vec<Layer>,
    field: Option<DistanceField>,
    capsules: Vec<Capsule>,
    settings: SimulationSettings,
    params: StepParams,
    clock: Clock,
    pose: Pose,
}

impl CpuSolver {
    /// At rest at the identity pose.
    pub fn new(guides: &[&GuideSet], field: Option<&DistanceField>, settings: &SimulationSettings) -> Self {
        let capsules = capsules_of(settings);
        let obstacles = Obstacles::new(field, &capsules, settings);
        let layers = guides
            .iter()
            .map(|&guides| {
                let rest = Rest::new(guides, obstacles);
                Layer {
                    guides: guides.clone(),
                    rest,
                    x: Vec::new(),
                    prev: Vec::new(),
                    begun: Vec::new(),
                    shown: Vec::new(),
                }
            })
            .collect();
        let mut solver = Self {
            layers,
            field: field.cloned(),
            capsules,
            params: StepParams::new(settings),
            settings: settings.clone(),
            clock: Clock::new(Pose::IDENTITY),
            pose: Pose::IDENTITY,
        };
        solver.reset();
        solver
    }

    /// The movement goes on with other settings.
    pub fn set_settings(&mut self, settings: &SimulationSettings) {
        if self.settings.colliders != settings.colliders {
            let mut capsules = capsules_of(settings);
            come_from(&mut capsules, &self.capsules);
            let obstacles = Obstacles::new(self.field.as_ref(), &capsules, settings);
            if capsules.iter().chain(&self.capsules).any(|capsule| capsule.keeps_rest == 1) {
                for layer in &mut self.layers {
                    layer.rest = Rest::new(&layer.guides, obstacles);
                }
            }
            self.capsules = capsules;
        }
        self.settings = settings.clone();
        self.params = StepParams::new(settings);
    }

    /// Where the head is at the end of the next [`CpuSolver::advance`] or [`CpuSolver::step_once`].
    pub fn set_head_pose(&mut self, world_from_head: &Affine3A) {
        self.pose = Pose::new(world_from_head);
    }

    /// Let time pass; returns the steps taken.
    pub fn advance(&mut self, frame_secs: f32) -> usize {
        let frame = self.clock.advance(frame_secs, f64::from(self.params.step_secs), self.pose);
        self.run(&frame);
        if frame.n_steps() > 0 {
            arrive(&mut self.capsules);
        }
        frame.n_steps()
    }

    /// Take one step, however long the frame.
    pub fn step_once(&mut self) {
        let frame = self.clock.step_once(self.pose);
        self.run(&frame);
        arrive(&mut self.capsules);
    }

    /// Back to rest at the present pose.
    pub fn reset(&mut self) {
        self.clock = Clock::new(self.pose);
        for layer in &mut self.layers {
            layer.x = layer.rest.vertices.iter().map(|v| self.pose.apply(v.xyz()).extend(0.0)).collect();
            layer.prev = layer.x.clone();
            layer.begun = layer.x.clone();
            layer.shown = layer.x.clone();
        }
    }

    /// World positions of a layer's guides as the picture shows them, vertex `k` of guide `g` at `g * n_vertices + k`.
    pub fn positions(&self, layer_idx: usize) -> &[Vec4] {
        &self.layers[layer_idx].shown
    }

    /// Set the state: positions now and one step ago, world.
    pub fn set_state(&mut self, layer_idx: usize, x: &[Vec3], prev: &[Vec3]) {
        let layer = &mut self.layers[layer_idx];
        layer.x = x.iter().map(|p| p.extend(0.0)).collect();
        layer.prev = prev.iter().map(|p| p.extend(0.0)).collect();
        layer.begun = layer.prev.clone();
        layer.shown = layer.x.clone();
    }

    /// Everything that the solver goes on from.
    pub fn read_state(&self) -> SolverState {
        let arrays = self.layers.iter().flat_map(|layer| [&layer.x, &layer.prev, &layer.begun, &layer.shown]);
        SolverState { clock: self.clock.clone(), pose: self.pose, arrays: arrays.cloned().collect() }
    }

    /// Go on from a state of the same guides; false, and nothing changes, where it is of others.
    pub fn write_state(&mut self, state: &SolverState) -> bool {
        if !state.fits(self.layers.iter().flat_map(|layer| [layer.rest.vertices.len(); 4])) {
            return false;
        }
        (self.clock, self.pose) = (state.clock.clone(), state.pose);
        let arrays = self
            .layers
            .iter_mut()
            .flat_map(|layer| [&mut layer.x, &mut layer.prev, &mut layer.begun, &mut layer.shown]);
        arrays.zip(&state.arrays).for_each(|(array, kept)| array.clone_from(kept));
        true
    }

    /// All layers at the last step.
    pub fn measure(&self) -> Measure {
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let pose = self.clock.pose_at_step();
        let of_layer =
            |layer: &Layer| measure(&layer.rest, obstacles, pose, &layer.x, &layer.begun, self.params.step_secs);
        self.layers.iter().map(of_layer).fold(Measure::default(), |sum, layer| sum.and(&layer))
    }

    fn run(&mut self, frame: &Frame) {
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let params = self.params;
        let air = Air::new(&self.settings);
        for layer in &mut self.layers {
            let n = layer.rest.n_vertices as usize;
            if n < 2 {
                continue;
            }
            let rest = layer.rest.vertices.par_chunks_exact(n);
            let state = layer.x.par_chunks_exact_mut(n).zip(layer.prev.par_chunks_exact_mut(n));
            let seen = layer.begun.par_chunks_exact_mut(n).zip(layer.shown.par_chunks_exact_mut(n));
            rest.zip(state).zip(seen).for_each(|((rest, (x, prev)), (begun, shown))| {
                let mut strand = Strand { rest, x, prev };
                run_strand(&mut strand, &params, air, obstacles, frame, begun, shown);
            });
        }
    }
}

/// All of a frame's steps for one strand. Twin of the entry point of `sim_strand.wgsl`.
fn run_strand(
    s: &mut Strand<'_>,
    params: &StepParams,
    air: Air,
    obstacles: Obstacles<'_>,
    frame: &Frame,
    begun: &mut [Vec4],
    shown: &mut [Vec4],
) {
    if let Some(carry) = frame.carry {
        for k in 0..s.x.len() {
            s.x[k] = carry.apply(s.x[k].xyz()).extend(0.0);
            s.prev[k] = carry.apply(s.prev[k].xyz()).extend(0.0);
            begun[k] = carry.apply(begun[k].xyz()).extend(0.0);
        }
    }
    for (step, poses) in frame.poses.windows(2).enumerate() {
        begun.copy_from_slice(s.x);
        step_strand(s, params, air, obstacles.at_step(step, frame.n_steps()), poses[0], poses[1]);
    }
    // The picture is up to a step ahead of the last step: go on at the present velocity, roots with the head.
    for k in 0..s.x.len() {
        let x = s.x[k].xyz();
        let ahead = x + frame.ahead * (x - begun[k].xyz());
        shown[k] = if k < crate::strand::N_PINNED { frame.shown.apply(s.rest[k].xyz()) } else { ahead }.extend(0.0);
    }
}
