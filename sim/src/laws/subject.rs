//! The solver of either device behind one face, taken through a movement frame by frame.

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Gpu, ShaderLibrary};

use super::Under;
use crate::bench::BenchError;
use crate::{CpuSolver, GpuSolver, Measure, SolverState};

/// Where a law is measured.
pub enum On {
    Cpu,
    Gpu(Box<Gpu>, ShaderLibrary),
}

enum Which<'a> {
    Cpu(Box<CpuSolver>),
    Gpu(Box<GpuSolver>, &'a Gpu),
}

/// One groom that moves.
pub struct Subject<'a>(Which<'a>);

impl<'a> Subject<'a> {
    /// At rest at the identity pose; `settings` say which solver.
    pub fn new(
        under: &Under<'a>,
        guides: &GuideSet,
        field: Option<&DistanceField>,
        settings: &SimulationSettings,
    ) -> Result<Self, BenchError> {
        Ok(Self(match under.on {
            On::Cpu => Which::Cpu(Box::new(CpuSolver::new(&[guides], field, settings))),
            On::Gpu(gpu, library) => {
                Which::Gpu(Box::new(GpuSolver::new(gpu, library, &[guides], field, settings)?), gpu)
            }
        }))
    }

    /// The movement goes on with other settings.
    pub fn set_settings(&mut self, settings: &SimulationSettings) -> Result<(), BenchError> {
        match &mut self.0 {
            Which::Cpu(solver) => solver.set_settings(settings),
            Which::Gpu(solver, _) => solver.set_settings(settings)?,
        }
        Ok(())
    }

    pub fn set_head_pose(&mut self, world_from_head: &Affine3A) {
        match &mut self.0 {
            Which::Cpu(solver) => solver.set_head_pose(world_from_head),
            Which::Gpu(solver, _) => solver.set_head_pose(world_from_head),
        }
    }

    /// Let a frame's time pass.
    pub fn advance(&mut self, frame_secs: f32) -> Result<(), BenchError> {
        self.record(
            |solver| {
                solver.advance(frame_secs);
            },
            |solver, encoder| solver.advance(encoder, frame_secs).map(drop),
        )
    }

    pub fn step_once(&mut self) -> Result<(), BenchError> {
        self.record(CpuSolver::step_once, GpuSolver::step_once)
    }

    fn record(
        &mut self,
        on_cpu: impl FnOnce(&mut CpuSolver),
        on_gpu: impl FnOnce(&mut GpuSolver, &mut wgpu::CommandEncoder) -> Result<(), lorelei_shaders::ShaderError>,
    ) -> Result<(), BenchError> {
        match &mut self.0 {
            Which::Cpu(solver) => on_cpu(solver),
            Which::Gpu(solver, gpu) => {
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                on_gpu(solver, &mut encoder)?;
                gpu.queue.submit([encoder.finish()]);
            }
        }
        Ok(())
    }

    /// Let `secs` pass in frames, the head where `pose` says at the end of each; after each frame `then` sees the groom.
    pub fn run(
        &mut self,
        secs: f32,
        frames_per_second: f32,
        pose: impl Fn(f32) -> Affine3A,
        mut then: impl FnMut(&Measure),
    ) -> Result<(), BenchError> {
        for frame in 1..=(secs * frames_per_second).round() as u32 {
            self.set_head_pose(&pose(frame as f32 / frames_per_second));
            self.advance(1.0 / frames_per_second)?;
            then(&self.measure()?);
        }
        Ok(())
    }

    /// Let `secs` pass at sixty frames a second while the head rests.
    pub fn settle(&mut self, secs: f32) -> Result<(), BenchError> {
        self.set_head_pose(&Affine3A::IDENTITY);
        (0..(60.0 * secs).round() as u32).try_for_each(|_| self.advance(1.0 / 60.0))
    }

    pub fn measure(&self) -> Result<Measure, BenchError> {
        Ok(match &self.0 {
            Which::Cpu(solver) => solver.measure(),
            Which::Gpu(solver, _) => solver.measure()?,
        })
    }

    /// Guides as the picture shows them, world.
    pub fn positions(&self) -> Result<Vec<Vec3>, BenchError> {
        let xyz = |positions: &[Vec4]| positions.iter().map(|x| x.xyz()).collect();
        Ok(match &self.0 {
            Which::Cpu(solver) => xyz(solver.positions(0)),
            Which::Gpu(solver, _) => xyz(&solver.read_positions(0)?),
        })
    }

    /// Positions now and a step ago, world.
    pub fn set_state(&mut self, x: &[Vec3], prev: &[Vec3]) {
        match &mut self.0 {
            Which::Cpu(solver) => solver.set_state(0, x, prev),
            Which::Gpu(solver, _) => solver.set_state(0, x, prev),
        }
    }

    pub fn reset(&mut self) {
        match &mut self.0 {
            Which::Cpu(solver) => solver.reset(),
            Which::Gpu(solver, _) => solver.reset(),
        }
    }

    pub fn read_state(&self) -> Result<SolverState, BenchError> {
        Ok(match &self.0 {
            Which::Cpu(solver) => solver.read_state(),
            Which::Gpu(solver, _) => solver.read_state()?,
        })
    }

    pub fn write_state(&mut self, state: &SolverState) -> bool {
        match &mut self.0 {
            Which::Cpu(solver) => solver.write_state(state),
            Which::Gpu(solver, _) => solver.write_state(state),
        }
    }
}
