//! The solver on the GPU: one dispatch a layer takes every strand through all of a frame's steps. Positions never
//! leave the GPU.
//!
//! One thread takes one strand. A strand is a chain in which every pass goes from one end to the other; a
//! workgroup a strand, one thread a vertex, would need a barrier between the batches of every iteration, has no
//! direct solve of the lengths, and leaves half its threads idle in each batch. On the software driver, where a
//! barrier suspends every thread of the group, it is out of the question.

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Bindings, Gpu, GpuError, Kernel, Link, ShaderError, ShaderLibrary};

use crate::air::Air;
use crate::clock::{Clock, Frame, MAX_STEPS_PER_FRAME};
use crate::contact::{Capsule, Obstacles, arrive, capsules_of, come_from};
use crate::measure::{Measure, measure};
use crate::pose::Pose;
use crate::rest::Rest;
use crate::state::SolverState;
use crate::strand::StepParams;

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

/// Layout of `Params` in WGSL.
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Params {
    step: StepParams,
    n_guides: u32,
    n_vertices: u32,
    n_steps: u32,
    ahead: f32,
    carried: u32,
    pad: [u32; 3],
    carry: GpuPose,
    shown: GpuPose,
    poses: [GpuPose; MAX_STEPS_PER_FRAME + 1],
}

struct Layer {
    guides: GuideSet,
    rest: Rest,
    rest_buffer: wgpu::Buffer,
    present: wgpu::Buffer,
    before_that: wgpu::Buffer,
    begun: wgpu::Buffer,
    positions: wgpu::Buffer,
}

impl Layer {
    /// What goes on from step to step, in the order of the CPU solver's arrays.
    fn state(&self) -> [&wgpu::Buffer; 4] {
        [&self.present, &self.before_that, &self.begun, &self.positions]
    }
}

/// The twin of [`crate::CpuSolver`].
pub struct GpuSolver {
    gpu: Gpu,
    library: ShaderLibrary,
    kernel: Kernel,
    layers: Vec<Layer>,
    field: Option<DistanceField>,
    field_values: wgpu::Buffer,
    capsules: Vec<Capsule>,
    settings: SimulationSettings,
    params: StepParams,
    clock: Clock,
    pose: Pose,
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
        let kernel = kernel_for(gpu, library, settings)?;
        let capsules = capsules_of(settings);
        let obstacles = Obstacles::new(field, &capsules, settings);
        let layers = guides
            .iter()
            .map(|&guides| {
                let rest = Rest::new(guides, obstacles);
                let n_bytes = 16 * rest.vertices.len() as u64;
                let storage = wgpu::BufferUsages::STORAGE;
                Layer {
                    rest_buffer: gpu.buffer_of("sim.rest", &rest.vertices, storage),
                    present: gpu.buffer("sim.present", n_bytes, storage),
                    before_that: gpu.buffer("sim.before_that", n_bytes, storage),
                    begun: gpu.buffer("sim.begun", n_bytes, storage),
                    positions: gpu.buffer("sim.positions", n_bytes, storage),
                    guides: guides.clone(),
                    rest,
                }
            })
            .collect();
        let values = field.map_or(&[][..], |field| &field.values);
        let mut solver = Self {
            kernel,
            layers,
            field: field.cloned(),
            field_values: gpu.buffer_of("sim.field_values", values, wgpu::BufferUsages::STORAGE),
            capsules,
            params: StepParams::new(settings),
            settings: settings.clone(),
            clock: Clock::new(Pose::IDENTITY),
            pose: Pose::IDENTITY,
            gpu: gpu.clone(),
            library: library.clone(),
        };
        solver.reset();
        Ok(solver)
    }

    /// The movement goes on with other settings. Fails where a shader that they need does not link.
    pub fn set_settings(&mut self, settings: &SimulationSettings) -> Result<(), ShaderError> {
        if self.settings.wind != settings.wind {
            self.kernel = kernel_for(&self.gpu, &self.library, settings)?;
        }
        if self.settings.colliders != settings.colliders {
            let mut capsules = capsules_of(settings);
            come_from(&mut capsules, &self.capsules);
            let obstacles = Obstacles::new(self.field.as_ref(), &capsules, settings);
            if capsules.iter().chain(&self.capsules).any(|capsule| capsule.keeps_rest == 1) {
                for layer in &mut self.layers {
                    layer.rest = Rest::new(&layer.guides, obstacles);
                    self.gpu.queue.write_buffer(&layer.rest_buffer, 0, bytemuck::cast_slice(&layer.rest.vertices));
                }
            }
            self.capsules = capsules;
        }
        self.settings = settings.clone();
        self.params = StepParams::new(settings);
        Ok(())
    }

    /// Where the head is at the end of the next [`GpuSolver::advance`] or [`GpuSolver::step_once`].
    pub fn set_head_pose(&mut self, world_from_head: &Affine3A) {
        self.pose = Pose::new(world_from_head);
    }

    /// Record the passing of time; returns the steps taken.
    pub fn advance(&mut self, encoder: &mut wgpu::CommandEncoder, frame_secs: f32) -> Result<usize, ShaderError> {
        let frame = self.clock.advance(frame_secs, f64::from(self.params.step_secs), self.pose);
        self.record(encoder, &frame)?;
        if frame.n_steps() > 0 {
            arrive(&mut self.capsules);
        }
        Ok(frame.n_steps())
    }

    /// Record one step, however long the frame.
    pub fn step_once(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), ShaderError> {
        let frame = self.clock.step_once(self.pose);
        self.record(encoder, &frame)?;
        arrive(&mut self.capsules);
        Ok(())
    }

    /// Back to rest at the present pose. Takes effect before commands that are submitted later.
    pub fn reset(&mut self) {
        self.clock = Clock::new(self.pose);
        for layer in &self.layers {
            let x: Vec<Vec4> = layer.rest.vertices.iter().map(|v| self.pose.apply(v.xyz()).extend(0.0)).collect();
            self.write_layer(layer, &x, &x);
        }
    }

    /// World positions of a layer's guides as the picture shows them: `array<vec4<f32>>`, vertex `k` of guide `g` at
    /// `g * n_vertices + k`; w is 0.
    pub fn positions(&self, layer_idx: usize) -> &wgpu::Buffer {
        &self.layers[layer_idx].positions
    }

    pub fn n_layers(&self) -> usize {
        self.layers.len()
    }

    /// Set the state: positions now and one step ago, world.
    pub fn set_state(&mut self, layer_idx: usize, x: &[Vec3], prev: &[Vec3]) {
        let extend = |points: &[Vec3]| -> Vec<Vec4> { points.iter().map(|p| p.extend(0.0)).collect() };
        self.write_layer(&self.layers[layer_idx], &extend(x), &extend(prev));
    }

    /// Everything that the solver goes on from, after what was submitted. Waits for the GPU.
    pub fn read_state(&self) -> Result<SolverState, GpuError> {
        let read = |layer: &Layer| layer.state().map(|buffer| self.read_vertices(layer, buffer));
        let arrays = self.layers.iter().flat_map(read).collect::<Result<_, _>>()?;
        Ok(SolverState { clock: self.clock.clone(), pose: self.pose, arrays })
    }

    /// Go on from a state of the same guides; false, and nothing changes, where it is of others. Takes effect before
    /// commands that are submitted later.
    pub fn write_state(&mut self, state: &SolverState) -> bool {
        if !state.fits(self.layers.iter().flat_map(|layer| [layer.rest.vertices.len(); 4])) {
            return false;
        }
        (self.clock, self.pose) = (state.clock.clone(), state.pose);
        for (buffer, array) in self.layers.iter().flat_map(Layer::state).zip(&state.arrays) {
            if !array.is_empty() {
                self.gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(array));
            }
        }
        true
    }

    /// World positions of a layer's guides as of the commands that were submitted. Waits for the GPU.
    pub fn read_positions(&self, layer_idx: usize) -> Result<Vec<Vec4>, GpuError> {
        let layer = &self.layers[layer_idx];
        self.read_vertices(layer, &layer.positions)
    }

    /// A buffer without what it has room for beyond the layer's vertices.
    fn read_vertices(&self, layer: &Layer, buffer: &wgpu::Buffer) -> Result<Vec<Vec4>, GpuError> {
        let mut vertices: Vec<Vec4> = self.gpu.read_buffer(buffer)?;
        vertices.truncate(layer.rest.vertices.len());
        Ok(vertices)
    }

    /// All layers at the last step that was submitted. Waits for the GPU: for tests and reports.
    pub fn measure(&self) -> Result<Measure, GpuError> {
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let mut sum = Measure::default();
        for layer in &self.layers {
            let x: Vec<Vec4> = self.gpu.read_buffer(&layer.present)?;
            let prev: Vec<Vec4> = self.gpu.read_buffer(&layer.begun)?;
            let pose = self.clock.pose_at_step();
            sum = sum.and(&measure(&layer.rest, obstacles, pose, &x, &prev, self.params.step_secs));
        }
        Ok(sum)
    }

    fn write_layer(&self, layer: &Layer, x: &[Vec4], prev: &[Vec4]) {
        let buffers = [(&layer.present, x), (&layer.before_that, prev), (&layer.begun, prev), (&layer.positions, x)];
        for (buffer, contents) in buffers {
            if !contents.is_empty() {
                self.gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(contents));
            }
        }
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder, frame: &Frame) -> Result<(), ShaderError> {
        // Parameters get a buffer of their own every time: several frames can be recorded before one is submitted.
        let recorded: Vec<(Bindings, u32)> = self
            .layers
            .iter()
            .filter(|layer| layer.rest.n_guides() > 0 && layer.rest.n_vertices >= 2)
            .map(|layer| Ok((self.bind(layer, frame)?, layer.rest.n_guides() as u32)))
            .collect::<Result<_, ShaderError>>()?;
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sim.strand"), timestamp_writes: None });
        for (bindings, n_guides) in &recorded {
            self.kernel.dispatch_items(&mut pass, bindings, *n_guides);
        }
        Ok(())
    }

    fn bind(&self, layer: &Layer, frame: &Frame) -> Result<Bindings, ShaderError> {
        let mut poses = [GpuPose::from(frame.shown); MAX_STEPS_PER_FRAME + 1];
        for (slot, &pose) in poses.iter_mut().zip(&frame.poses) {
            *slot = pose.into();
        }
        let params = Params {
            step: self.params,
            n_guides: layer.rest.n_guides() as u32,
            n_vertices: layer.rest.n_vertices,
            n_steps: frame.n_steps() as u32,
            ahead: frame.ahead,
            carried: u32::from(frame.carry.is_some()),
            pad: [0; 3],
            carry: frame.carry.unwrap_or(Pose::IDENTITY).into(),
            shown: frame.shown.into(),
            poses,
        };
        let uniform = wgpu::BufferUsages::UNIFORM;
        let params = self.gpu.buffer_of("sim.params", &[params], uniform);
        let obstacles = Obstacles::new(self.field.as_ref(), &self.capsules, &self.settings);
        let contact = self.gpu.buffer_of("sim.contact", &[obstacles.params], uniform);
        let capsules = self.gpu.buffer_of("sim.capsules", &self.capsules, wgpu::BufferUsages::STORAGE);
        let air = self.gpu.buffer_of("sim.air", &[Air::new(&self.settings).params()], uniform);
        // Still air has no parameters.
        self.kernel.bind_used(
            &self.gpu,
            &[
                ("params", params.as_entire_binding()),
                ("contact", contact.as_entire_binding()),
                ("air", air.as_entire_binding()),
                ("rest", layer.rest_buffer.as_entire_binding()),
                ("present", layer.present.as_entire_binding()),
                ("before_that", layer.before_that.as_entire_binding()),
                ("begun", layer.begun.as_entire_binding()),
                ("positions", layer.positions.as_entire_binding()),
                ("field_values", self.field_values.as_entire_binding()),
                ("capsules", capsules.as_entire_binding()),
            ],
        )
    }
}

fn kernel_for(gpu: &Gpu, library: &ShaderLibrary, settings: &SimulationSettings) -> Result<Kernel, ShaderError> {
    library.kernel(gpu, "sim_strand", "advance", &[], &[Link::Slot("sim_air", Air::new(settings).module())])
}
