//! The solver of either device behind one face.

use std::time::Instant;

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Gpu, GpuError, ShaderError};
use lorelei_sim::gpu::{TooMuchHair, check_room};
use lorelei_sim::{CpuSolver, GpuSolver, Measure, SolverState};

use super::Subject;
use crate::stage::shader_library;

/// Why a frame was not simulated.
#[derive(Debug, thiserror::Error)]
pub enum SolverError {
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    TooMuchHair(#[from] TooMuchHair),
}

/// Where a solver works.
pub enum On {
    Cpu,
    Gpu(Box<Gpu>),
}

impl On {
    /// The device, by name.
    pub fn device(&self) -> String {
        match self {
            Self::Cpu => "CPU, all cores".to_owned(),
            Self::Gpu(gpu) => gpu.adapter_info.name.clone(),
        }
    }
}

/// A piece of a frame: the head at its end, the settings during it, its length.
#[derive(Debug, Clone)]
pub struct Piece {
    pub world_from_head: Affine3A,
    pub settings: SimulationSettings,
    pub secs: f32,
}

enum Which {
    Cpu(Box<CpuSolver>),
    Gpu(Box<GpuSolver>, Box<Gpu>),
}

/// A solver, and the settings that it has.
pub struct Solver {
    which: Which,
    settings: SimulationSettings,
    n_layers: usize,
}

impl Solver {
    /// At rest where the head is at `world_from_head`.
    pub fn new(
        on: On,
        subject: &Subject,
        settings: &SimulationSettings,
        world_from_head: &Affine3A,
    ) -> Result<Self, SolverError> {
        let field = subject.field.as_deref();
        let which = match on {
            On::Cpu => {
                let mut solver = CpuSolver::of_hair(&subject.hair, field, settings);
                solver.set_head_pose(world_from_head);
                solver.reset();
                Which::Cpu(Box::new(solver))
            }
            On::Gpu(gpu) => {
                for hair in &subject.hair {
                    check_room(&gpu, "the groom", hair.curves.positions.len())?;
                }
                let mut solver = GpuSolver::of_hair(&gpu, &shader_library()?, &subject.hair, field, settings)?;
                solver.set_head_pose(world_from_head);
                solver.reset();
                Which::Gpu(Box::new(solver), gpu)
            }
        };
        Ok(Self { which, settings: settings.clone(), n_layers: subject.hair.len() })
    }

    /// Let the pieces pass one after the other and wait until they have; returns steps and milliseconds.
    pub fn advance(&mut self, pieces: &[Piece]) -> Result<(usize, f64), SolverError> {
        let start = Instant::now();
        let mut n_steps = 0;
        match &mut self.which {
            Which::Cpu(solver) => {
                for piece in pieces {
                    if self.settings != piece.settings {
                        solver.set_settings(&piece.settings);
                        self.settings.clone_from(&piece.settings);
                    }
                    solver.set_head_pose(&piece.world_from_head);
                    n_steps += solver.advance(piece.secs);
                }
            }
            Which::Gpu(solver, gpu) => {
                let label = wgpu::CommandEncoderDescriptor { label: Some("movement.frame") };
                let mut encoder = gpu.device.create_command_encoder(&label);
                for piece in pieces {
                    if self.settings != piece.settings {
                        solver.set_settings(&piece.settings)?;
                        self.settings.clone_from(&piece.settings);
                    }
                    solver.set_head_pose(&piece.world_from_head);
                    n_steps += solver.advance(&mut encoder, piece.secs)?;
                }
                gpu.queue.submit([encoder.finish()]);
                gpu.wait()?;
            }
        }
        Ok((n_steps, start.elapsed().as_secs_f64() * 1e3))
    }

    /// Every layer's guides, or strands, as the picture shows them, world.
    pub fn positions(&self) -> Result<Vec<Vec<Vec3>>, SolverError> {
        let xyz = |positions: &[Vec4]| positions.iter().map(|p| p.xyz()).collect();
        (0..self.n_layers)
            .map(|layer_idx| match &self.which {
                Which::Cpu(solver) => Ok(xyz(solver.positions(layer_idx))),
                Which::Gpu(solver, _) => Ok(xyz(&solver.read_positions(layer_idx)?)),
            })
            .collect()
    }

    /// How well the laws are kept at the last step.
    pub fn measure(&self) -> Result<Measure, SolverError> {
        match &self.which {
            Which::Cpu(solver) => Ok(solver.measure()),
            Which::Gpu(solver, _) => Ok(solver.measure()?),
        }
    }

    /// Everything that the solver goes on from.
    pub fn read_state(&self) -> Result<SolverState, SolverError> {
        match &self.which {
            Which::Cpu(solver) => Ok(solver.read_state()),
            Which::Gpu(solver, _) => Ok(solver.read_state()?),
        }
    }

    /// Go on from a state; false where it is of other guides.
    pub fn write_state(&mut self, state: &SolverState) -> bool {
        match &mut self.which {
            Which::Cpu(solver) => solver.write_state(state),
            Which::Gpu(solver, _) => solver.write_state(state),
        }
    }
}
