//! The solver on the GPU: one dispatch a layer takes every strand through all of a frame's steps. Positions never
//! leave the GPU.
//!
//! A rod is one thread's: each of its sweeps goes from one end to the other. A chain's vertices are a thread's each, as the
//! references have it.

use glam::{Affine3A, Vec3, Vec4};
use lorelei_core::binding::Tie;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::io::Watch;
use lorelei_core::moved::MovedHair;
use lorelei_core::simulation::{Moved, SimulationSettings, Solver};
use lorelei_shaders::{Bindings, Gpu, GpuError, Kernel, Link, ShaderError, ShaderLibrary, grid_1d};

use crate::air::{AirFrame, GpuAir, module};
use crate::chain;
use crate::clock::{Clock, Frame, MAX_STEPS_PER_FRAME};
use crate::contact::{Capsule, Obstacles, arrive, capsules_of, come_from, faces_of};
use crate::follow::Followed;
use crate::layer::{SimulatedLayer, longest_edge};
use crate::measure::{Measure, measure};
use crate::pose::Pose;
use crate::pull::{Pull, PullParams};
use crate::rest::Rest;
use crate::rod::{LANES, RodVertex};
use crate::state::SolverState;
use crate::volume::{GpuVolume, VolumeGrid, VolumeLayer, VolumeParams};
use crate::wind::GpuWind;
use crate::wind::gpu::GpuHairLayer;

/// Layout of `Pose` in WGSL.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct GpuPose {
    rotation: [f32; 4],
    translation: [f32; 4],
}

impl From<Pose> for GpuPose {
    fn from(pose: Pose) -> Self {
        Self { rotation: pose.rotation.to_array(), translation: pose.translation.extend(0.0).to_array() }
    }
}

/// Layout of `FrameParams` in WGSL.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct FrameParams {
    n_guides: u32,
    n_vertices: u32,
    n_steps: u32,
    ahead: f32,
    carried: u32,
    pad: [u32; 3],
    carry: GpuPose,
    shown: GpuPose,
    pull: PullParams,
    poses: [GpuPose; MAX_STEPS_PER_FRAME + 1],
    carries: [GpuPose; MAX_STEPS_PER_FRAME],
}

/// A layer on the GPU.
struct Layer {
    /// As it rests: its state is that of the last reset.
    model: SimulatedLayer,
    rest: wgpu::Buffer,
    state: wgpu::Buffer,
    /// What the sweeps of a rod hand on to each other, of the strands that are worked on at a time.
    eliminated: wgpu::Buffer,
    positions: wgpu::Buffer,
    /// The guides, where what moves are others.
    followed: Option<Followed>,
}

impl Layer {
    fn new(gpu: &Gpu, model: SimulatedLayer) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let read_back = storage | wgpu::BufferUsages::COPY_SRC;
        Self {
            rest: gpu.buffer_of("sim.rest", &model.lanes()[0].lay(model.rest_vec4s()), storage),
            state: gpu.buffer_of("sim.state", &model.lanes()[1].lay(model.state_vec4s()), read_back),
            eliminated: gpu.buffer("sim.eliminated", rod_groups(gpu, &model) * eliminated_bytes(&model), storage),
            positions: gpu.buffer_of("sim.positions", &model.shown, read_back),
            followed: None,
            model,
        }
    }

    /// Send what is fixed, from before what is submitted later.
    fn send_rest(&self, gpu: &Gpu) {
        gpu.queue.write_buffer(
            &self.rest,
            0,
            bytemuck::cast_slice(&self.model.lanes()[0].lay(self.model.rest_vec4s())),
        );
    }

    /// The state in the CPU's order, after what was submitted. Waits for the GPU.
    fn read_state(&self, gpu: &Gpu) -> Result<Vec<Vec4>, GpuError> {
        Ok(self.model.lanes()[1].take_up(gpu.read_buffer(&self.state)?, self.model.state_vec4s().len()))
    }

    /// Send the model's state, of a head at `pose`, from before what is submitted later.
    fn send_state(&self, gpu: &Gpu, pose: Pose) {
        let state = self.model.lanes()[1].lay(self.model.state_vec4s());
        for (buffer, contents) in [(&self.state, &state[..]), (&self.positions, &self.model.shown)] {
            if !contents.is_empty() {
                gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(contents));
            }
        }
        if let Some(followed) = &self.followed {
            followed.send(gpu, &self.model.shown, pose.rotation);
        }
    }
}

/// Bytes of a vertex in `eliminated`.
const ELIMINATED_BYTES: u64 = 5 * 16;

/// Most workgroups of rods: each takes groups of strands one after the other, so that what it keeps of a vertex for a step is
/// kept of few strands. More than a large GPU works on at a time gain nothing (an H200 with 1,056: 3.5 ms; with 1,563: 2.83; with
/// 2,640: 2.90).
const MOST_ROD_GROUPS: u64 = 1584;

/// Workgroups for rods: as many as there are groups of strands, or as what they keep has room for.
fn rod_groups(gpu: &Gpu, model: &SimulatedLayer) -> u64 {
    let n_groups = model.n_guides().div_ceil(LANES) as u64;
    let have_room = gpu.max_storage_binding() / eliminated_bytes(model).max(1);
    n_groups.min(MOST_ROD_GROUPS).min(have_room).max(1)
}

/// Bytes of `eliminated` for a workgroup of rods; chains have none.
fn eliminated_bytes(model: &SimulatedLayer) -> u64 {
    let strands = if model.is_of_rods() { LANES as u64 } else { 0 };
    ELIMINATED_BYTES * strands * u64::from(model.rest.n_vertices)
}

/// There is more hair in a layer than this device moves at once.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "moving every strand of {layer} needs {needed_mib} MiB at once and this GPU binds {available_mib} MiB: use fewer strands, or fewer points each, or move guides"
)]
pub struct TooMuchHair {
    pub layer: String,
    pub needed_mib: u64,
    pub available_mib: u64,
}

/// Whether a layer of `n_vertices` vertices has room in the buffers of a device.
pub fn check_room(gpu: &Gpu, layer: &str, n_vertices: usize) -> Result<(), TooMuchHair> {
    let needed = BYTES_A_VERTEX * n_vertices as u64;
    let available = gpu.max_storage_binding();
    if needed <= available {
        return Ok(());
    }
    Err(TooMuchHair { layer: layer.to_owned(), needed_mib: needed >> 20, available_mib: available >> 20 })
}

/// Bytes that the largest buffer of a layer has for a vertex.
const BYTES_A_VERTEX: u64 = size_of::<RodVertex>() as u64;

/// The twin of [`crate::CpuSolver`].
pub struct GpuSolver {
    gpu: Gpu,
    library: ShaderLibrary,
    kernel: Kernel,
    /// The kernel asks about edges too: see [`Obstacles::has_thin`].
    has_thin: bool,
    /// Where some layer's guides follow other curves.
    follow: Option<Kernel>,
    layers: Vec<Layer>,
    /// Of every layer what [`Windage`](crate::rest::Windage) says, and how much it is together, g.
    windage: Vec<(wgpu::Buffer, f32)>,
    field: Option<DistanceField>,
    field_faces: wgpu::Buffer,
    capsules: Vec<Capsule>,
    volume: Option<(VolumeGrid, GpuVolume)>,
    settings: SimulationSettings,
    clock: Clock,
    pose: Pose,
    air: GpuAir,
    pull: Option<Pull>,
}

impl GpuSolver {
    /// At rest at the identity pose. Fails where the shader does not link or the device does not take it.
    pub fn new(
        gpu: &Gpu,
        library: &ShaderLibrary,
        guides: &[&GuideSet],
        field: Option<&DistanceField>,
        settings: &SimulationSettings,
    ) -> Result<Self, ShaderError> {
        Self::of_hair(gpu, library, &MovedHair::of_guides(guides), field, settings)
    }

    /// The same of hair that is tied, and of what follows what moves.
    pub fn of_hair(
        gpu: &Gpu,
        library: &ShaderLibrary,
        hair: &[MovedHair],
        field: Option<&DistanceField>,
        settings: &SimulationSettings,
    ) -> Result<Self, ShaderError> {
        let made = Self::of_hair_watched(gpu, library, hair, field, settings, Watch::default())?;
        Ok(made.expect("nobody can cancel what is not watched"))
    }

    /// As [`GpuSolver::of_hair`]; `None` where it was cancelled.
    pub fn of_hair_watched(
        gpu: &Gpu,
        library: &ShaderLibrary,
        hair: &[MovedHair],
        field: Option<&DistanceField>,
        settings: &SimulationSettings,
        watch: Watch<'_>,
    ) -> Result<Option<Self>, ShaderError> {
        let capsules = capsules_of(settings);
        let obstacles = Obstacles::new(field, &capsules, settings);
        let mut layers = Vec::with_capacity(hair.len());
        let mut follow = None;
        let n_vertices: usize = hair.iter().map(|hair| hair.curves.positions.len()).sum();
        let mut n_done = 0;
        for hair in hair {
            let n = hair.curves.positions.len();
            let on_progress =
                |share: f32| watch.progress((n_done as f32 + share * n as f32) / n_vertices.max(1) as f32);
            let of_layer = Watch { on_progress: Some(&on_progress), cancel: watch.cancel };
            let made = SimulatedLayer::new_watched(hair, obstacles, settings, Pose::IDENTITY, of_layer);
            let Some(model) = made else { return Ok(None) };
            n_done += n;
            let mut layer = Layer::new(gpu, model);
            if let Some(following) = layer.model.rest.following.clone() {
                if follow.is_none() {
                    follow = Some(library.kernel(gpu, "sim_follow", "follow_curves", &[], &[])?);
                }
                layer.followed = Some(Followed::new(gpu, following, &layer.model.shown));
            }
            layers.push(layer);
        }
        let edge = longest_edge(layers.iter().map(|layer| &layer.model));
        let has_thin = obstacles.for_edges(edge).has_thin();
        let kernel = kernel_for(gpu, library, settings, has_thin)?;
        let volume = volume_of(gpu, library, &layers, settings)?;
        let faces = field.map_or_else(Vec::new, faces_of);
        Ok(Some(Self {
            kernel,
            has_thin,
            follow,
            windage: (layers.iter().zip(hair))
                .map(|(layer, hair)| windage_of(gpu, layer, hair.g_per_cm, settings.moved))
                .collect(),
            air: GpuAir::default(),
            layers,
            field: field.cloned(),
            field_faces: gpu.buffer_of("sim.field_faces", &faces, wgpu::BufferUsages::STORAGE),
            capsules,
            volume,
            settings: settings.clone(),
            clock: Clock::new(Pose::IDENTITY),
            pose: Pose::IDENTITY,
            pull: None,
            gpu: gpu.clone(),
            library: library.clone(),
        }))
    }

    /// The movement goes on with other settings; under another law it starts again from rest. Fails where a shader that
    /// they need does not link.
    pub fn set_settings(&mut self, settings: &SimulationSettings) -> Result<(), ShaderError> {
        let is_other_law = self.settings.solver != settings.solver;
        let mut are_moved = false;
        if self.settings.colliders != settings.colliders {
            let mut capsules = capsules_of(settings);
            come_from(&mut capsules, &self.capsules);
            are_moved = capsules.iter().chain(&self.capsules).any(|capsule| capsule.keeps_rest == 1);
            self.capsules = capsules;
        }
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, settings);
        let has_thin = obstacles.for_edges(self.longest_edge()).has_thin();
        if is_other_law || self.settings.wind != settings.wind || self.has_thin != has_thin {
            self.kernel = kernel_for(&self.gpu, &self.library, settings, has_thin)?;
            self.has_thin = has_thin;
        }
        for layer in &mut self.layers {
            if is_other_law {
                let followed = layer.followed.take();
                *layer = Layer::new(&self.gpu, layer.model.under(obstacles, settings, self.pose));
                layer.followed = followed;
                layer.send_state(&self.gpu, self.pose);
            } else if layer.model.set_settings(obstacles, are_moved, settings, self.pose) {
                layer.send_rest(&self.gpu);
            }
        }
        if VolumeGrid::is_other(&self.settings, settings) {
            self.volume = volume_of(&self.gpu, &self.library, &self.layers, settings)?;
        }
        self.settings = settings.clone();
        Ok(())
    }

    /// Tie a layer's curves to the style.
    pub fn set_ties(&mut self, layer_idx: usize, ties: &[Tie]) {
        let layer = &mut self.layers[layer_idx];
        if layer.model.set_ties(ties, &self.settings, self.pose) {
            layer.send_rest(&self.gpu);
        }
    }

    /// A layer is more hair or less: see [`MovedHair::g_per_cm`].
    pub fn set_g_per_cm(&mut self, layer_idx: usize, g_per_cm: f32) {
        self.windage[layer_idx] = windage_of(&self.gpu, &self.layers[layer_idx], g_per_cm, self.settings.moved);
    }

    /// Hair against hair, before the steps of a frame.
    fn crowd(&self, encoder: &mut wgpu::CommandEncoder, frame: &Frame) -> Result<(), ShaderError> {
        let Some((grid, volume)) = &self.volume else { return Ok(()) };
        // What is put somewhere else is crowded as it was.
        if frame.n_steps() == 0 || frame.carry.is_some() {
            return Ok(());
        }
        let step_secs = SimulatedLayer::step_secs(&self.settings);
        let times = [step_secs, frame.n_steps() as f32 * step_secs];
        let layers = self.layers.iter().map(|layer| VolumeLayer {
            state: &layer.state,
            n_vertices: layer.model.rest.vertices.len() as u32,
            params: VolumeParams {
                lanes: layer.model.lanes()[1].side_by_side,
                ..grid.params(
                    frame.poses[0],
                    &self.settings,
                    [layer.model.rest.n_vertices, layer.model.vec4s_a_vertex() as u32],
                    times,
                )
            },
        });
        let layers: Vec<VolumeLayer<'_>> = layers.collect();
        volume.record(&self.gpu, encoder, &layers)
    }

    /// Where the head is at the end of the next [`GpuSolver::advance`] or [`GpuSolver::step_once`].
    pub fn set_head_pose(&mut self, world_from_head: &Affine3A) {
        self.pose = Pose::new(world_from_head);
    }

    /// A hand holds hair from now on, or lets go.
    pub fn set_pull(&mut self, pull: Option<Pull>) {
        self.pull = pull;
    }

    /// Record the passing of time; returns the steps taken.
    pub fn advance(&mut self, encoder: &mut wgpu::CommandEncoder, frame_secs: f32) -> Result<usize, ShaderError> {
        let frame = self.clock.advance(frame_secs, f64::from(SimulatedLayer::step_secs(&self.settings)), self.pose);
        self.record(encoder, &frame, frame_secs)?;
        if frame.n_steps() > 0 {
            arrive(&mut self.capsules);
        }
        Ok(frame.n_steps())
    }

    /// Record one step, however long the frame.
    pub fn step_once(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), ShaderError> {
        let frame = self.clock.step_once(self.pose);
        self.record(encoder, &frame, SimulatedLayer::step_secs(&self.settings))?;
        arrive(&mut self.capsules);
        Ok(())
    }

    /// Back to rest at the present pose. Takes effect before commands that are submitted later.
    pub fn reset(&mut self) {
        self.clock = Clock::new(self.pose);
        self.air = GpuAir::default();
        for layer in &mut self.layers {
            layer.model.reset(self.pose);
            layer.send_state(&self.gpu, self.pose);
        }
    }

    /// World positions of a layer's guides, or of its strands where those are moved, as the picture shows them:
    /// `array<vec4<f32>>`, vertex `k` of guide `g` at `g * n_vertices + k`; w is 0.
    pub fn positions(&self, layer_idx: usize) -> &wgpu::Buffer {
        let layer = &self.layers[layer_idx];
        layer.followed.as_ref().map_or(&layer.positions, |followed| &followed.positions)
    }

    pub fn n_layers(&self) -> usize {
        self.layers.len()
    }

    /// Set the state: positions now and one step ago, world.
    pub fn set_state(&mut self, layer_idx: usize, x: &[Vec3], prev: &[Vec3]) {
        let layer = &mut self.layers[layer_idx];
        layer.model.reset(self.pose);
        layer.model.put(x, prev);
        layer.send_state(&self.gpu, self.pose);
    }

    /// Everything that the solver goes on from, after what was submitted. Waits for the GPU.
    pub fn read_state(&self) -> Result<SolverState, GpuError> {
        let mut arrays = Vec::with_capacity(2 * self.layers.len());
        for layer in &self.layers {
            arrays.push(layer.read_state(&self.gpu)?);
            arrays.push(self.read_vec4s(&layer.positions, layer.model.shown.len())?);
        }
        arrays.extend(self.air.read_state()?);
        Ok(SolverState { clock: self.clock.clone(), pose: self.pose, arrays })
    }

    /// Go on from a state of the same guides under the same law; false, and nothing changes, where it is of others. Takes
    /// effect before commands that are submitted later.
    pub fn write_state(&mut self, state: &SolverState) -> bool {
        let lengths = self.layers.iter().flat_map(|l| [l.model.state_vec4s().len(), l.model.shown.len()]);
        let Some((arrays, air)) = state.split(lengths) else { return false };
        self.air.write_state(air);
        (self.clock, self.pose) = (state.clock.clone(), state.pose);
        for (layer, arrays) in self.layers.iter_mut().zip(arrays.chunks_exact(2)) {
            layer.model.set_state_vec4s(&arrays[0]);
            layer.model.shown.clone_from(&arrays[1]);
            layer.send_state(&self.gpu, self.pose);
        }
        true
    }

    /// [`GpuSolver::positions`] as of the commands that were submitted. Waits for the GPU.
    pub fn read_positions(&self, layer_idx: usize) -> Result<Vec<Vec4>, GpuError> {
        let layer = &self.layers[layer_idx];
        let n_vertices = layer.followed.as_ref().map_or(layer.model.shown.len(), Followed::n_shown);
        self.read_vec4s(self.positions(layer_idx), n_vertices)
    }

    /// What is moved of a layer, at rest in head space: guides, chains of a hair mesh, or strands.
    pub fn curves(&self, layer_idx: usize) -> &GuideSet {
        self.layers[layer_idx].model.guides()
    }

    /// World positions of [`GpuSolver::curves`], as [`GpuSolver::positions`] has those of the guides that follow them.
    pub fn curves_buffer(&self, layer_idx: usize) -> &wgpu::Buffer {
        &self.layers[layer_idx].positions
    }

    /// [`GpuSolver::curves_buffer`] as of the commands that were submitted. Waits for the GPU.
    pub fn read_curves(&self, layer_idx: usize) -> Result<Vec<Vec4>, GpuError> {
        let layer = &self.layers[layer_idx];
        self.read_vec4s(&layer.positions, layer.model.shown.len())
    }

    /// A buffer without what it has room for beyond `n`.
    fn read_vec4s(&self, buffer: &wgpu::Buffer, n: usize) -> Result<Vec<Vec4>, GpuError> {
        let mut numbers: Vec<Vec4> = self.gpu.read_buffer(buffer)?;
        numbers.truncate(n);
        Ok(numbers)
    }

    /// All layers at the last step that was submitted. Waits for the GPU: for tests and reports.
    pub fn measure(&self) -> Result<Measure, GpuError> {
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let step_secs = SimulatedLayer::step_secs(&self.settings);
        let mut sum = Measure::default();
        for layer in &self.layers {
            let mut now = layer.model.clone();
            now.set_state_vec4s(&layer.read_state(&self.gpu)?);
            let (x, begun) = now.places();
            sum = sum.and(&measure(&now.rest, obstacles, self.clock.pose_at_step(), &x, &begun, step_secs));
        }
        Ok(sum)
    }

    /// The grid of air, once a frame has passed in which the wind was one.
    pub fn air_grid(&self) -> Option<&GpuWind> {
        self.air.grid()
    }

    fn longest_edge(&self) -> f32 {
        longest_edge(self.layers.iter().map(|layer| &layer.model))
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &Frame,
        frame_secs: f32,
    ) -> Result<(), ShaderError> {
        self.crowd(encoder, frame)?;
        let obstacles =
            Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings).for_edges(self.longest_edge());
        let contact = self.gpu.buffer_of("sim.contact", &[obstacles.params], wgpu::BufferUsages::UNIFORM);
        let capsules = self.gpu.buffer_of("sim.capsules", &self.capsules, wgpu::BufferUsages::STORAGE);
        let contact = [
            ("contact", contact.as_entire_binding()),
            ("field_faces", self.field_faces.as_entire_binding()),
            ("capsules", capsules.as_entire_binding()),
        ];
        let (settings, pose, jumped) = (&self.settings, frame.shown, frame.carry.is_some());
        let air_frame = AirFrame { settings, obstacles, pose, jumped, frame_secs };
        let rests: Vec<&Rest> = self.layers.iter().map(|layer| &layer.model.rest).collect();
        let hair = self.layers.iter().zip(&self.windage).map(|(layer, (windage, g))| GpuHairLayer {
            n_guides: layer.model.n_guides() as u32,
            n_vertices: layer.model.rest.n_vertices,
            positions: &layer.positions,
            windage,
            g: *g,
        });
        let hair: Vec<GpuHairLayer<'_>> = hair.collect();
        self.air.advance((&self.gpu, &self.library), encoder, air_frame, &contact, &rests, &hair)?;
        // Parameters get a buffer of their own every time: several frames can be recorded before one is submitted.
        let workgroups = |model: &SimulatedLayer| match self.settings.solver {
            Solver::Rods => [rod_groups(&self.gpu, model) as u32, 1, 1],
            // As many strands as have room in each.
            Solver::Chains => {
                let n_threads = model.rest.n_vertices.div_ceil(chain::BLOCK);
                grid_1d(model.n_guides() as u32, self.kernel.workgroup_size()[0] / n_threads)
            }
        };
        let recorded: Vec<(Bindings, [u32; 3])> = self
            .layers
            .iter()
            .filter(|layer| layer.model.n_guides() > 0 && layer.model.rest.n_vertices >= 2)
            .map(|layer| Ok((self.bind(layer, frame, &contact)?, workgroups(&layer.model))))
            .collect::<Result<_, ShaderError>>()?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sim.strand"), timestamp_writes: None });
        for (bindings, workgroups) in &recorded {
            self.kernel.dispatch(&mut pass, bindings, *workgroups);
        }
        for layer in &self.layers {
            if let (Some(followed), Some(kernel)) = (&layer.followed, &self.follow) {
                followed.record(&self.gpu, kernel, &mut pass, &layer.positions, frame.shown.rotation)?;
            }
        }
        Ok(())
    }

    fn bind(
        &self,
        layer: &Layer,
        frame: &Frame,
        contact: &[(&str, wgpu::BindingResource<'_>)],
    ) -> Result<Bindings, ShaderError> {
        let mut poses = [GpuPose::from(frame.shown); MAX_STEPS_PER_FRAME + 1];
        for (slot, &pose) in poses.iter_mut().zip(&frame.poses) {
            *slot = pose.into();
        }
        let mut carries = [GpuPose::from(Pose::IDENTITY); MAX_STEPS_PER_FRAME];
        for (slot, poses) in carries.iter_mut().zip(frame.poses.windows(2)) {
            *slot = poses[1].after_inverse_of(&poses[0]).into();
        }
        let params = FrameParams {
            n_guides: layer.model.n_guides() as u32,
            n_vertices: layer.model.rest.n_vertices,
            n_steps: frame.n_steps() as u32,
            ahead: frame.ahead,
            carried: u32::from(frame.carry.is_some()),
            pad: [0; 3],
            carry: frame.carry.unwrap_or(Pose::IDENTITY).into(),
            shown: frame.shown.into(),
            pull: PullParams::new(self.pull.as_ref(), frame.shown),
            poses,
            carries,
        };
        let uniform = wgpu::BufferUsages::UNIFORM;
        let params = self.gpu.buffer_of("sim.frame", &[params], uniform);
        // Storage: Mesa's software driver 22.3 crashes on a fourth uniform buffer in a kernel of this size.
        let law = self.gpu.buffer_of("sim.law", &layer.model.params_bytes(), uniform | wgpu::BufferUsages::STORAGE);
        let mut resources = vec![
            ("asked", params.as_entire_binding()),
            ("rod", law.as_entire_binding()),
            ("chain", law.as_entire_binding()),
            ("rest", layer.rest.as_entire_binding()),
            ("s", layer.state.as_entire_binding()),
            ("eliminated", layer.eliminated.as_entire_binding()),
            ("positions", layer.positions.as_entire_binding()),
        ];
        resources.extend(contact.iter().cloned());
        resources.extend(self.air.resources(&self.settings));
        // A law has its own parameters, and still air has none.
        self.kernel.bind_used(&self.gpu, &resources)
    }
}

fn windage_of(gpu: &Gpu, layer: &Layer, g_per_cm: f32, moved: Moved) -> (wgpu::Buffer, f32) {
    let windage = layer.model.windage(g_per_cm, moved);
    (gpu.buffer_of("sim.windage", &windage.of_vertices, wgpu::BufferUsages::STORAGE), windage.g)
}

fn volume_of(
    gpu: &Gpu,
    library: &ShaderLibrary,
    layers: &[Layer],
    settings: &SimulationSettings,
) -> Result<Option<(VolumeGrid, GpuVolume)>, ShaderError> {
    let grid = VolumeGrid::new(&layers.iter().map(|layer| &layer.model.rest).collect::<Vec<_>>(), settings);
    let lanes = layers.iter().map(|layer| layer.model.lanes()[1]);
    grid.map(|grid| GpuVolume::new(gpu, library, &grid, lanes).map(|volume| (grid, volume))).transpose()
}

fn kernel_for(
    gpu: &Gpu,
    library: &ShaderLibrary,
    settings: &SimulationSettings,
    has_thin: bool,
) -> Result<Kernel, ShaderError> {
    let file = match settings.solver {
        Solver::Rods => "sim_rod",
        Solver::Chains => "sim_chain",
    };
    let overrides = [("THIN_COLLIDERS", f64::from(u32::from(has_thin)))];
    library.kernel(gpu, file, "advance", &overrides, &[Link::Slot("sim_air", module(settings))])
}
