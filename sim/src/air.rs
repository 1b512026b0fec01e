//! The velocity of the air where a strand is. Twins of the `sim_air_*.wgsl` modules, one for each choice of the wind.
//!
//! [`CpuAir`] and [`GpuAir`] are what a solver keeps of the air between frames: the time, for gusts and eddies depend on it, and
//! the grid where the wind is one. Both go on once a frame, before the strands' first step.

use std::sync::Arc;

use glam::{Vec3, Vec4};
use lorelei_core::simulation::{SimulationSettings, Wind};
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};

use crate::contact::Obstacles;
use crate::pose::Pose;
use crate::rest::Rest;
use crate::wind::cpu::HairLayer;
use crate::wind::gpu::GpuHairLayer;
use crate::wind::{AirGrid, CpuWind, FreeAir, GpuWind, WindFrame};

/// The air around the groom; a clone is cheap.
#[derive(Debug, Clone, PartialEq)]
pub enum Air {
    Still,
    /// Wind that nothing stands in the way of.
    Free(Arc<FreeAir>),
    Grid(AirGrid),
}

impl Air {
    /// At a place in the world, cm/s. Twin of `air_velocity`.
    pub fn velocity(&self, p: Vec3) -> Vec3 {
        match self {
            Self::Still => Vec3::ZERO,
            Self::Free(free) => free.free_air(p),
            Self::Grid(grid) => grid.air_velocity(p),
        }
    }
}

/// The shader module that stands in for the slot `sim_air`.
pub(crate) fn module(settings: &SimulationSettings) -> &'static str {
    match settings.wind {
        Wind::Off => "sim_air_off",
        Wind::Uniform => "sim_air_uniform",
        Wind::Grid => "sim_air_grid",
    }
}

/// A frame of a solver as the air needs it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AirFrame<'a> {
    pub settings: &'a SimulationSettings,
    pub obstacles: Obstacles<'a>,
    pub pose: Pose,
    /// The head was put there, it did not go.
    pub jumped: bool,
    pub frame_secs: f32,
}

impl AirFrame<'_> {
    fn wind_frame(&self, t_secs: f64) -> WindFrame {
        WindFrame { pose: self.pose, jumped: self.jumped, t_secs, frame_secs: self.frame_secs }
    }
}

/// What the reference solver keeps of the air.
#[derive(Default)]
pub(crate) struct CpuAir {
    t_secs: f64,
    grid: Option<CpuWind>,
    /// A state to go on from, until there is a grid.
    kept: Vec<Vec<Vec4>>,
}

impl CpuAir {
    /// Let a frame pass, and say what air the strands' steps in it have.
    pub fn advance(&mut self, frame: AirFrame<'_>, rests: &[&Rest], layers: &[HairLayer<'_>]) -> Air {
        self.t_secs += f64::from(passed(frame.frame_secs));
        match frame.settings.wind {
            Wind::Off => Air::Still,
            Wind::Uniform => Air::Free(Arc::new(FreeAir::new(frame.settings, self.t_secs))),
            Wind::Grid => {
                let n = frame.settings.air.n_cells();
                let mut grid = self.grid.take().filter(|grid| grid.grid().n == n).unwrap_or_else(|| {
                    let points = rests.iter().flat_map(|rest| &rest.vertices).map(|v| v.truncate());
                    CpuWind::new(points, frame.settings, frame.pose)
                });
                grid.write_state(&std::mem::take(&mut self.kept));
                grid.advance(frame.settings, frame.obstacles, layers, &frame.wind_frame(self.t_secs));
                Air::Grid(self.grid.insert(grid).air())
            }
        }
    }

    /// Everything that the next frame depends on.
    pub fn read_state(&self) -> Vec<Vec<Vec4>> {
        let grid = self.grid.as_ref().map_or_else(|| self.kept.clone(), CpuWind::read_state);
        [vec![time_to_vector(self.t_secs)]].into_iter().chain(grid).collect()
    }

    /// Go on from a state, of the CPU or of the GPU.
    pub fn write_state(&mut self, state: &[Vec<Vec4>]) {
        self.t_secs = time_of(state);
        self.kept = state.get(1..).unwrap_or(&[]).to_vec();
        if self.kept.is_empty() {
            self.grid = None;
        }
    }

    /// The grid, where the wind is one.
    pub fn grid(&self) -> Option<&CpuWind> {
        self.grid.as_ref()
    }
}

/// What the GPU solver keeps of the air.
#[derive(Default)]
pub(crate) struct GpuAir {
    t_secs: f64,
    grid: Option<GpuWind>,
    free: Option<wgpu::Buffer>,
    /// A state to go on from, until there is a grid.
    kept: Vec<Vec<Vec4>>,
}

impl GpuAir {
    /// Record the passing of a frame.
    pub fn advance(
        &mut self,
        (gpu, library): (&Gpu, &ShaderLibrary),
        encoder: &mut wgpu::CommandEncoder,
        frame: AirFrame<'_>,
        contact: &[(&str, wgpu::BindingResource<'_>)],
        rests: &[&Rest],
        layers: &[GpuHairLayer<'_>],
    ) -> Result<(), ShaderError> {
        self.t_secs += f64::from(passed(frame.frame_secs));
        match frame.settings.wind {
            Wind::Off => {}
            Wind::Uniform => {
                let free = FreeAir::new(frame.settings, self.t_secs);
                self.free = Some(gpu.buffer_of("sim.free", &[free], wgpu::BufferUsages::STORAGE));
            }
            Wind::Grid => {
                let n = frame.settings.air.n_cells();
                if self.grid.as_ref().is_none_or(|grid| grid.grid().n != n) {
                    let points = rests.iter().flat_map(|rest| &rest.vertices).map(|v| v.truncate());
                    self.grid = Some(GpuWind::new(gpu, library, points, frame.settings, frame.pose)?);
                }
                if let Some(grid) = &mut self.grid {
                    grid.write_state(&std::mem::take(&mut self.kept));
                    grid.advance(encoder, frame.settings, contact, layers, &frame.wind_frame(self.t_secs))?;
                }
            }
        }
        Ok(())
    }

    /// Everything that the next frame depends on, after what was submitted. Waits for the GPU.
    pub fn read_state(&self) -> Result<Vec<Vec<Vec4>>, GpuError> {
        let grid = self.grid.as_ref().map_or_else(|| Ok(self.kept.clone()), GpuWind::read_state)?;
        Ok([vec![time_to_vector(self.t_secs)]].into_iter().chain(grid).collect())
    }

    /// Go on from a state, of the CPU or of the GPU.
    pub fn write_state(&mut self, state: &[Vec<Vec4>]) {
        self.t_secs = time_of(state);
        self.kept = state.get(1..).unwrap_or(&[]).to_vec();
        if self.kept.is_empty() {
            self.grid = None;
        }
    }

    /// What the module of the slot `sim_air` binds.
    pub fn resources(&self, settings: &SimulationSettings) -> Vec<(&'static str, wgpu::BindingResource<'_>)> {
        match settings.wind {
            Wind::Off => Vec::new(),
            Wind::Uniform => self.free.iter().map(|free| ("free", free.as_entire_binding())).collect(),
            Wind::Grid => self.grid.iter().flat_map(GpuWind::resources).collect(),
        }
    }

    /// The grid, where the wind is one.
    pub fn grid(&self) -> Option<&GpuWind> {
        self.grid.as_ref()
    }
}

/// A time in three parts, each as fine as a float can be: without loss.
fn time_to_vector(t_secs: f64) -> Vec4 {
    let coarse = t_secs as f32;
    let finer = (t_secs - f64::from(coarse)) as f32;
    let finest = (t_secs - f64::from(coarse) - f64::from(finer)) as f32;
    Vec4::new(coarse, finer, finest, 0.0)
}

fn time_of(state: &[Vec<Vec4>]) -> f64 {
    let Some(&[time]) = state.first().map(Vec::as_slice) else { return 0.0 };
    f64::from(time.x) + f64::from(time.y) + f64::from(time.z)
}

fn passed(frame_secs: f32) -> f32 {
    if frame_secs.is_finite() { frame_secs.clamp(0.0, 10.0) } else { 0.0 }
}
