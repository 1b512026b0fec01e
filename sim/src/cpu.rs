//! The reference solver: every guide on the CPU, in parallel. The GPU solver is tested against it.

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};
use lorelei_core::binding::Tie;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::moved::MovedHair;
use lorelei_core::simulation::SimulationSettings;

use crate::air::{AirFrame, CpuAir};
use crate::clock::{Clock, Frame};
use crate::contact::{Capsule, Obstacles, arrive, capsules_of, come_from};
use crate::follow::Following;
use crate::layer::{SimulatedLayer, longest_edge};
use crate::measure::{Measure, measure};
use crate::pose::Pose;
use crate::pull::{Pull, PullParams};
use crate::rest::{Rest, Windage};
use crate::state::SolverState;
use crate::volume::VolumeGrid;
use crate::wind::CpuWind;
use crate::wind::cpu::HairLayer;

/// Rest state in, positions out. Cannot fail.
pub struct CpuSolver {
    layers: Vec<SimulatedLayer>,
    /// Of every layer: its guides, where what moves are others, and where they are shown.
    followed: Vec<Option<(Arc<Following>, Vec<Vec4>)>>,
    /// Of every layer.
    windage: Vec<Windage>,
    field: Option<DistanceField>,
    capsules: Vec<Capsule>,
    volume: Option<VolumeGrid>,
    settings: SimulationSettings,
    clock: Clock,
    pose: Pose,
    air: CpuAir,
    pull: Option<Pull>,
}

impl CpuSolver {
    /// At rest at the identity pose.
    pub fn new(guides: &[&GuideSet], field: Option<&DistanceField>, settings: &SimulationSettings) -> Self {
        Self::of_hair(&MovedHair::of_guides(guides), field, settings)
    }

    /// The same of hair that is tied, and of what follows what moves.
    pub fn of_hair(hair: &[MovedHair], field: Option<&DistanceField>, settings: &SimulationSettings) -> Self {
        let capsules = capsules_of(settings);
        let obstacles = Obstacles::new(field, &capsules, settings);
        let pose = Pose::IDENTITY;
        let model = |hair: &MovedHair| SimulatedLayer::new(hair, obstacles, settings, pose);
        let layers: Vec<SimulatedLayer> = hair.iter().map(model).collect();
        let followed = |layer: &SimulatedLayer| layer.rest.following.clone().map(|following| (following, Vec::new()));
        let volume = volume_of(&layers, settings);
        let mut solver = Self {
            windage: layers
                .iter()
                .zip(hair)
                .map(|(layer, hair)| layer.windage(hair.g_per_cm, settings.moved))
                .collect(),
            air: CpuAir::default(),
            followed: layers.iter().map(followed).collect(),
            layers,
            field: field.cloned(),
            capsules,
            volume,
            settings: settings.clone(),
            clock: Clock::new(Pose::IDENTITY),
            pose,
            pull: None,
        };
        solver.follow(pose);
        solver
    }

    /// Let guides follow what has moved, on a head at `pose`.
    fn follow(&mut self, pose: Pose) {
        for (layer, followed) in self.layers.iter().zip(&mut self.followed) {
            if let Some((following, shown)) = followed {
                *shown = following.follow_curves(&layer.shown, pose.rotation);
            }
        }
    }

    /// The movement goes on with other settings.
    pub fn set_settings(&mut self, settings: &SimulationSettings) {
        let mut are_moved = false;
        if self.settings.colliders != settings.colliders {
            let mut capsules = capsules_of(settings);
            come_from(&mut capsules, &self.capsules);
            are_moved = capsules.iter().chain(&self.capsules).any(|capsule| capsule.keeps_rest == 1);
            self.capsules = capsules;
        }
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, settings);
        for layer in &mut self.layers {
            layer.set_settings(obstacles, are_moved, settings, self.pose);
        }
        if VolumeGrid::is_other(&self.settings, settings) {
            self.volume = volume_of(&self.layers, settings);
        }
        self.settings = settings.clone();
    }

    /// Tie a layer's curves to the style.
    pub fn set_ties(&mut self, layer_idx: usize, ties: &[Tie]) {
        self.layers[layer_idx].set_ties(ties, &self.settings, self.pose);
    }

    /// A layer is more hair or less: see [`MovedHair::g_per_cm`].
    pub fn set_g_per_cm(&mut self, layer_idx: usize, g_per_cm: f32) {
        self.windage[layer_idx] = self.layers[layer_idx].windage(g_per_cm, self.settings.moved);
    }

    /// Room that the hair took when the last frame began, cm3; `None` where nobody counts it.
    pub fn occupied_cm3(&self) -> Option<f32> {
        self.volume.as_ref().map(VolumeGrid::occupied_cm3)
    }

    /// Hair against hair, before the steps of a frame.
    fn crowd(&mut self, frame: &Frame) {
        let Some(volume) = &mut self.volume else { return };
        // What is put somewhere else is crowded as it was.
        if frame.n_steps() == 0 || frame.carry.is_some() {
            return;
        }
        let step_secs = SimulatedLayer::step_secs(&self.settings);
        let times = [step_secs, frame.n_steps() as f32 * step_secs];
        volume.clear();
        let params = |volume: &VolumeGrid, layer: &SimulatedLayer| {
            let sizes = [layer.rest.n_vertices, layer.vec4s_a_vertex() as u32];
            volume.params(frame.poses[0], &self.settings, sizes, times)
        };
        for (layer_idx, layer) in self.layers.iter().enumerate() {
            volume.splat(&params(volume, layer), layer_idx, layer.state_vec4s());
        }
        volume.blur();
        for (layer_idx, layer) in self.layers.iter_mut().enumerate() {
            let params = params(volume, layer);
            volume.push(&params, layer_idx, layer.state_vec4s_mut());
        }
    }

    /// Where the head is at the end of the next [`CpuSolver::advance`] or [`CpuSolver::step_once`].
    pub fn set_head_pose(&mut self, world_from_head: &Affine3A) {
        self.pose = Pose::new(world_from_head);
    }

    /// A hand holds hair from now on, or lets go.
    pub fn set_pull(&mut self, pull: Option<Pull>) {
        self.pull = pull;
    }

    /// Let time pass; returns the steps taken.
    pub fn advance(&mut self, frame_secs: f32) -> usize {
        let frame = self.clock.advance(frame_secs, f64::from(SimulatedLayer::step_secs(&self.settings)), self.pose);
        self.run(&frame, frame_secs);
        if frame.n_steps() > 0 {
            arrive(&mut self.capsules);
        }
        frame.n_steps()
    }

    /// Take one step, however long the frame.
    pub fn step_once(&mut self) {
        let frame = self.clock.step_once(self.pose);
        self.run(&frame, SimulatedLayer::step_secs(&self.settings));
        arrive(&mut self.capsules);
    }

    /// Back to rest at the present pose.
    pub fn reset(&mut self) {
        self.clock = Clock::new(self.pose);
        self.air = CpuAir::default();
        for layer in &mut self.layers {
            layer.reset(self.pose);
        }
        self.follow(self.pose);
    }

    /// World positions of a layer's guides, or of its strands where those are moved, as the picture shows them: vertex `k`
    /// of guide `g` at `g * n_vertices + k`.
    pub fn positions(&self, layer_idx: usize) -> &[Vec4] {
        self.followed[layer_idx].as_ref().map_or(&self.layers[layer_idx].shown, |(_, shown)| shown)
    }

    /// Set the state: positions now and one step ago, world.
    pub fn set_state(&mut self, layer_idx: usize, x: &[Vec3], prev: &[Vec3]) {
        self.layers[layer_idx].put(x, prev);
        self.follow(self.pose);
    }

    /// Everything that the solver goes on from.
    pub fn read_state(&self) -> SolverState {
        let arrays = self.layers.iter().flat_map(|layer| [layer.state_vec4s().to_vec(), layer.shown.clone()]);
        SolverState {
            clock: self.clock.clone(),
            pose: self.pose,
            arrays: arrays.chain(self.air.read_state()).collect(),
        }
    }

    /// Go on from a state of the same guides; false, and nothing changes, where it is of others.
    pub fn write_state(&mut self, state: &SolverState) -> bool {
        let lengths = self.layers.iter().flat_map(|layer| [layer.state_vec4s().len(), layer.shown.len()]);
        let Some((arrays, air)) = state.split(lengths) else { return false };
        self.air.write_state(air);
        (self.clock, self.pose) = (state.clock.clone(), state.pose);
        for (layer, arrays) in self.layers.iter_mut().zip(arrays.chunks_exact(2)) {
            layer.set_state_vec4s(&arrays[0]);
            layer.shown.clone_from(&arrays[1]);
        }
        self.follow(self.pose);
        true
    }

    /// All layers at the last step.
    pub fn measure(&self) -> Measure {
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let pose = self.clock.pose_at_step();
        let step_secs = SimulatedLayer::step_secs(&self.settings);
        let of_layer = |layer: &SimulatedLayer| {
            let (x, begun) = layer.places();
            measure(&layer.rest, obstacles, pose, &x, &begun, step_secs)
        };
        self.layers.iter().map(of_layer).fold(Measure::default(), |sum, layer| sum.and(&layer))
    }

    /// The grid of air, once a frame has passed in which the wind was one.
    pub fn air_grid(&self) -> Option<&CpuWind> {
        self.air.grid()
    }

    fn run(&mut self, frame: &Frame, frame_secs: f32) {
        self.crowd(frame);
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let (settings, pose, jumped) = (&self.settings, frame.shown, frame.carry.is_some());
        let air_frame = AirFrame { settings, obstacles, pose, jumped, frame_secs };
        let rests: Vec<&Rest> = self.layers.iter().map(|layer| &layer.rest).collect();
        let hair = self.layers.iter().zip(&self.windage).map(|(layer, windage)| HairLayer {
            n_vertices: layer.rest.n_vertices,
            positions: &layer.shown,
            windage: &windage.of_vertices,
            g: windage.g,
        });
        let hair: Vec<HairLayer<'_>> = hair.collect();
        let air = self.air.advance(air_frame, &rests, &hair);
        let pull = PullParams::new(self.pull.as_ref(), frame.shown);
        let obstacles = obstacles.for_edges(longest_edge(self.layers.iter()));
        for layer in &mut self.layers {
            layer.run(&air, obstacles, &pull, frame);
        }
        self.follow(self.pose);
    }
}

fn volume_of(layers: &[SimulatedLayer], settings: &SimulationSettings) -> Option<VolumeGrid> {
    VolumeGrid::new(&layers.iter().map(|layer| &layer.rest).collect::<Vec<_>>(), settings)
}
