//! The grid of air on the GPU. At 32 cells a frame is 17 dispatches: one each for hair, rotation, prediction and
//! equations, two sweeps, five for each multigrid cycle, and the projection.

use glam::{Vec3, Vec4};
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Bindings, Gpu, GpuError, Kernel, Link, ShaderError, ShaderLibrary};

use super::air::{AirGrid, AirGridParams};
use super::free::FreeAir;
use super::grid::{AirBox, GridParams, WindFrame};
use super::hair::HairParams;
use super::pressure::Levels;
use crate::pose::Pose;

/// A layer of hair as the grid sees it.
#[derive(Debug, Clone, Copy)]
pub struct GpuHairLayer<'a> {
    pub n_guides: u32,
    pub n_vertices: u32,
    /// World, `array<vec4<f32>>`, vertex `k` of guide `g` at `g * n_vertices + k`.
    pub positions: &'a wgpu::Buffer,
    /// Mass at each vertex of which the wind takes hold, g: `array<f32>`.
    pub windage: &'a wgpu::Buffer,
    /// Of all of them.
    pub g: f32,
}

struct Kernels {
    splat: Kernel,
    turn: Kernel,
    predict: Kernel,
    begin: Kernel,
    sweeps: [Kernel; 2],
    coarsen: Kernel,
    refine: Kernel,
    coarse: Kernel,
    project: Kernel,
}

/// What one level needs that does not change from frame to frame.
struct Level {
    sweeps: [Bindings; 2],
    coarsen: Bindings,
    refine: Bindings,
    n: u32,
}

/// The twin of [`super::CpuWind`].
pub struct GpuWind {
    gpu: Gpu,
    kernels: Kernels,
    air_box: AirBox,
    grid: GridParams,
    free: FreeAir,
    fine: Vec<Level>,
    coarse: Bindings,
    faces: wgpu::Buffer,
    air: wgpu::Buffer,
    curls: wgpu::Buffer,
    hair_cells: wgpu::Buffer,
    predicted: wgpu::Buffer,
    openness: wgpu::Buffer,
    equations: wgpu::Buffer,
    pressure: wgpu::Buffer,
    free_buffer: wgpu::Buffer,
    air_grid: wgpu::Buffer,
    /// Of every layer, and how many vertices it has.
    positions_before: Vec<(wgpu::Buffer, usize)>,
    is_new: bool,
}

impl GpuWind {
    /// Around points (head space), in the free air of the time 0. Fails where a shader does not link or the device does
    /// not take it.
    pub fn new(
        gpu: &Gpu,
        library: &ShaderLibrary,
        points: impl Iterator<Item = Vec3>,
        settings: &SimulationSettings,
        pose: Pose,
    ) -> Result<Self, ShaderError> {
        let kernels = Kernels::new(gpu, library)?;
        let mut air_box = AirBox::around(points, settings, pose);
        let grid = air_box.advance(settings, &WindFrame::first(pose), 1.0);
        let levels = Levels::new(grid.n);
        let storage = wgpu::BufferUsages::STORAGE;
        let of_cells = |label: &str| gpu.buffer(label, 16 * grid.n_entries() as u64, storage);
        let of_levels = |label: &str, size: u64| gpu.buffer(label, size * levels.n_entries() as u64, storage);
        let openness = of_levels("wind.openness", 16);
        let equations = of_levels("wind.equations", 8);
        let pressure = of_levels("wind.pressure", 4);
        let bind_level = |kernel: &Kernel, level: usize| {
            let uniform = gpu.buffer_of("wind.levels", &[levels.at(level)], wgpu::BufferUsages::UNIFORM);
            kernel.bind_used(
                gpu,
                &[
                    ("levels", uniform.as_entire_binding()),
                    ("openness", openness.as_entire_binding()),
                    ("equations", equations.as_entire_binding()),
                    ("pressure", pressure.as_entire_binding()),
                ],
            )
        };
        let fine = (0..levels.first_coarse())
            .map(|level| {
                Ok(Level {
                    sweeps: [bind_level(&kernels.sweeps[0], level)?, bind_level(&kernels.sweeps[1], level)?],
                    coarsen: bind_level(&kernels.coarsen, level)?,
                    refine: bind_level(&kernels.refine, level)?,
                    n: levels.of[level][0],
                })
            })
            .collect::<Result<_, ShaderError>>()?;
        let free = FreeAir::new(settings, 0.0);
        let air_grid = AirGridParams { min: grid.min, cell: grid.cell, n: grid.n, pad: [0; 3] };
        let wind = Self {
            coarse: bind_level(&kernels.coarse, levels.first_coarse())?,
            fine,
            kernels,
            grid,
            free,
            faces: of_cells("wind.faces"),
            air: of_cells("wind.air"),
            curls: of_cells("wind.curls"),
            hair_cells: of_cells("wind.hair_cells"),
            predicted: of_cells("wind.predicted"),
            openness,
            equations,
            pressure,
            free_buffer: gpu.buffer_of("wind.free", &[free], storage),
            air_grid: gpu.buffer_of("wind.air_grid", &[air_grid], storage),
            positions_before: Vec::new(),
            is_new: true,
            air_box,
            gpu: gpu.clone(),
        };
        wind.fill(free.steady);
        Ok(wind)
    }

    fn fill(&self, velocity: Vec3) {
        let filled = vec![velocity.extend(0.0); self.grid.n_entries()];
        self.gpu.queue.write_buffer(&self.faces, 0, bytemuck::cast_slice(&filled));
        let filled = vec![velocity.extend(1.0); self.grid.n_entries()];
        self.gpu.queue.write_buffer(&self.air, 0, bytemuck::cast_slice(&filled));
    }

    /// Record a frame. `contact` is what the module `sim_contact` binds.
    pub fn advance(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        settings: &SimulationSettings,
        contact: &[(&str, wgpu::BindingResource<'_>)],
        layers: &[GpuHairLayer<'_>],
        frame: &WindFrame,
    ) -> Result<(), ShaderError> {
        if frame.frame_secs.is_nan() || frame.frame_secs <= 0.0 {
            return Ok(());
        }
        let hair_g = layers.iter().map(|layer| layer.g).sum();
        self.grid = self.air_box.advance(settings, frame, hair_g);
        self.free = FreeAir::new(settings, frame.t_secs);
        // Parameters get a buffer of their own every time: several frames can be recorded before one is submitted.
        let uniform = wgpu::BufferUsages::UNIFORM;
        let grid = self.gpu.buffer_of("wind.grid", &[self.grid], uniform);
        self.free_buffer = self.gpu.buffer_of("wind.free", &[self.free], wgpu::BufferUsages::STORAGE);
        let air_grid = AirGridParams { min: self.grid.min, cell: self.grid.cell, n: self.grid.n, pad: [0; 3] };
        self.air_grid = self.gpu.buffer_of("wind.air_grid", &[air_grid], wgpu::BufferUsages::STORAGE);
        let mut resources = vec![
            ("grid", grid.as_entire_binding()),
            ("free", self.free_buffer.as_entire_binding()),
            ("faces", self.faces.as_entire_binding()),
            ("air", self.air.as_entire_binding()),
            ("curls", self.curls.as_entire_binding()),
            ("hair_cells", self.hair_cells.as_entire_binding()),
            ("predicted", self.predicted.as_entire_binding()),
            ("openness", self.openness.as_entire_binding()),
            ("equations", self.equations.as_entire_binding()),
            ("pressure", self.pressure.as_entire_binding()),
        ];
        resources.extend(contact.iter().map(|(name, resource)| (*name, resource.clone())));
        let kernels = &self.kernels;
        let [turn, predict, begin, project] = [&kernels.turn, &kernels.predict, &kernels.begin, &kernels.project]
            .map(|kernel| kernel.bind_used(&self.gpu, &resources));
        let (turn, predict, begin, project) = (turn?, predict?, begin?, project?);
        let dt_secs = (!self.is_new && !frame.jumped).then_some(frame.frame_secs);
        let mut splats = Vec::new();
        for (layer_idx, layer) in layers.iter().enumerate() {
            if self.positions_before.len() <= layer_idx {
                let n_vertices = layer.n_guides * layer.n_vertices;
                let buffer = self.gpu.buffer("wind.before", 16 * u64::from(n_vertices), wgpu::BufferUsages::STORAGE);
                self.positions_before.push((buffer, n_vertices as usize));
            }
            if layer.n_guides == 0 || layer.n_vertices < 2 {
                continue;
            }
            let hair = HairParams::new(layer.n_guides, layer.n_vertices, dt_secs);
            let hair_grid = self.gpu.buffer_of("wind.hair", &[hair], uniform);
            let bindings = kernels.splat.bind(
                &self.gpu,
                &[
                    ("grid", grid.as_entire_binding()),
                    ("hair", hair_grid.as_entire_binding()),
                    ("windage", layer.windage.as_entire_binding()),
                    ("positions", layer.positions.as_entire_binding()),
                    ("positions_before", self.positions_before[layer_idx].0.as_entire_binding()),
                    ("hair_cells", self.hair_cells.as_entire_binding()),
                ],
            )?;
            splats.push((bindings, hair.n_taken * hair.n_vertices));
        }
        self.is_new = false;
        encoder.clear_buffer(&self.hair_cells, 0, None);
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("sim.wind"), timestamp_writes: None });
        for (bindings, n_items) in &splats {
            kernels.splat.dispatch_items(&mut pass, bindings, *n_items);
        }
        let (n_cells, n_entries) = (self.grid.n.pow(3), self.grid.n_entries() as u32);
        if self.grid.vorticity > 0.0 {
            kernels.turn.dispatch_items(&mut pass, &turn, n_cells);
        }
        // Four threads an entry.
        kernels.predict.dispatch_items(&mut pass, &predict, 4 * n_entries);
        kernels.begin.dispatch_items(&mut pass, &begin, n_cells);
        self.record_solve(&mut pass, settings.air.n_cycles);
        kernels.project.dispatch_items(&mut pass, &project, n_entries);
        Ok(())
    }

    /// As many cycles as asked for, from the pressure of the last frame.
    fn record_solve(&self, pass: &mut wgpu::ComputePass<'_>, n_cycles: u32) {
        let kernels = &self.kernels;
        let sweep = |pass: &mut wgpu::ComputePass<'_>, level: &Level| {
            for (kernel, bindings) in kernels.sweeps.iter().zip(&level.sweeps) {
                kernel.dispatch_items(pass, bindings, level.n * level.n * level.n.div_ceil(2));
            }
        };
        if let Some(finest) = self.fine.first() {
            sweep(pass, finest);
        }
        for _ in 0..n_cycles.clamp(1, 8) {
            for (level_idx, level) in self.fine.iter().enumerate() {
                if level_idx > 0 {
                    sweep(pass, level);
                }
                // Eight threads a cell.
                kernels.coarsen.dispatch_items(pass, &level.coarsen, level.n.pow(3));
            }
            kernels.coarse.dispatch(pass, &self.coarse, [1, 1, 1]);
            for level in self.fine.iter().rev() {
                kernels.refine.dispatch_items(pass, &level.refine, level.n.pow(3));
                sweep(pass, level);
            }
        }
    }

    /// Everything that the next frame depends on, after what was submitted. Waits for the GPU.
    pub(crate) fn read_state(&self) -> Result<Vec<Vec<Vec4>>, GpuError> {
        let read = |buffer: &wgpu::Buffer| self.gpu.read_buffer::<Vec4>(buffer);
        let mut state = vec![self.air_box.to_vectors()];
        for (buffer, n) in self.state() {
            let mut array = read(buffer)?;
            array.truncate(n);
            state.push(array);
        }
        for (buffer, n) in &self.positions_before {
            let mut array = read(buffer)?;
            array.truncate(*n);
            state.push(array);
        }
        Ok(state)
    }

    /// Go on from a state; one of other cells is left alone. Takes effect before commands that are submitted later.
    pub(crate) fn write_state(&mut self, state: &[Vec<Vec4>]) {
        let Some((air_box, arrays)) = state.split_first() else { return };
        let Some((own, positions_before)) = arrays.split_at_checked(self.state().len()) else { return };
        let fits = own.iter().zip(self.state()).all(|(array, (_, n))| array.len() == n);
        if !fits || !self.air_box.set_vectors(air_box) {
            return;
        }
        for (array, (buffer, _)) in own.iter().zip(self.state()) {
            self.gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(array));
        }
        let storage = wgpu::BufferUsages::STORAGE;
        let kept = |array: &Vec<Vec4>| {
            let buffer = self.gpu.buffer("wind.before", size_of_val(array.as_slice()) as u64, storage);
            self.gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(array));
            (buffer, array.len())
        };
        self.positions_before = positions_before.iter().map(kept).collect();
        self.is_new = positions_before.is_empty();
    }

    /// The arrays that go on from frame to frame, in the order of the CPU's, and how many vectors they have.
    fn state(&self) -> [(&wgpu::Buffer, usize); 3] {
        let n = self.grid.n_entries();
        [(&self.faces, n), (&self.air, n), (&self.pressure, Levels::new(self.grid.n).n_entries().div_ceil(4))]
    }

    /// What the module `sim_air_grid` binds.
    pub fn resources(&self) -> [(&'static str, wgpu::BindingResource<'_>); 3] {
        [
            ("free", self.free_buffer.as_entire_binding()),
            ("air_grid", self.air_grid.as_entire_binding()),
            ("air", self.air.as_entire_binding()),
        ]
    }

    pub fn grid(&self) -> &GridParams {
        &self.grid
    }

    /// The free air of the last frame.
    pub fn free(&self) -> &FreeAir {
        &self.free
    }

    /// Speeds through the lower faces of every entry. Waits for the GPU: for tests and reports.
    pub fn read_faces(&self) -> Result<Vec<Vec4>, GpuError> {
        self.gpu.read_buffer(&self.faces)
    }

    /// The air as it is now. Waits for the GPU: for tests and reports.
    pub fn read_air(&self) -> Result<AirGrid, GpuError> {
        let params = AirGridParams { min: self.grid.min, cell: self.grid.cell, n: self.grid.n, pad: [0; 3] };
        Ok(AirGrid { params, air: self.gpu.read_buffer(&self.air)?.into(), free: self.free.into() })
    }
}

impl Kernels {
    fn new(gpu: &Gpu, library: &ShaderLibrary) -> Result<Self, ShaderError> {
        let kernel = |file: &str, entry: &str| library.kernel(gpu, file, entry, &[], &[] as &[Link<'_>]);
        let limits = gpu.device.limits();
        let most = limits.max_compute_invocations_per_workgroup.min(limits.max_compute_workgroup_size_x);
        let large: &[Link<'_>] = if most >= 1024 { &[Link::Def("LARGE_WORKGROUPS")] } else { &[] };
        let sweep = |colour: f64| library.kernel(gpu, "wind_pressure", "sweep", &[("COLOUR", colour)], &[]);
        Ok(Self {
            splat: kernel("wind_hair", "splat")?,
            turn: kernel("wind_predict", "turn")?,
            predict: kernel("wind_predict", "predict")?,
            begin: kernel("wind_pressure", "begin")?,
            sweeps: [sweep(0.0)?, sweep(1.0)?],
            coarsen: kernel("wind_pressure", "coarsen")?,
            refine: kernel("wind_pressure", "refine")?,
            coarse: library.kernel(gpu, "wind_pressure", "coarse", &[], large)?,
            project: kernel("wind_pressure", "project")?,
        })
    }
}
