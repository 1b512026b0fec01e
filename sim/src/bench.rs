//! How long a step takes on the CPU and on the GPU, in one run and in turns.

use std::time::Instant;

use glam::{UVec3, Vec3};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};

use crate::{CpuSolver, GpuSolver};

/// Medians over the rounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepTimes {
    pub n_guides: u32,
    pub n_vertices: u32,
    /// Milliseconds a step, all cores.
    pub cpu_ms: f64,
    /// Milliseconds a step, from submission until it is done.
    pub gpu_ms: f64,
}

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Time the two solvers on `n_guides` wavy strands of 30 cm around a ball that shakes, alternating.
pub fn step_times(
    gpu: &Gpu,
    library: &ShaderLibrary,
    n_guides: u32,
    n_vertices: u32,
    n_rounds: u32,
) -> Result<StepTimes, BenchError> {
    const FRAMES_A_ROUND: u32 = 4;
    const FRAME_SECS: f32 = 1.0 / 60.0;
    let (guides, field, settings) = (wavy(n_guides, n_vertices), ball(), SimulationSettings::default());
    let mut on_cpu = CpuSolver::new(&[&guides], Some(&field), &settings);
    let mut on_gpu = GpuSolver::new(gpu, library, &[&guides], Some(&field), &settings)?;
    let (mut cpu_ms, mut gpu_ms) = (Vec::new(), Vec::new());
    // The first round warms up pipelines and caches and is not counted.
    for round in 0..=n_rounds.max(1) {
        let pose =
            |frame: u32| Motion::Shake.pose((round * FRAMES_A_ROUND + frame) as f32 * FRAME_SECS, Vec3::NEG_Y * 8.0);
        let start = Instant::now();
        let mut n_steps = 0;
        for frame in 0..FRAMES_A_ROUND {
            on_cpu.set_head_pose(&pose(frame));
            n_steps += on_cpu.advance(FRAME_SECS);
        }
        let cpu = start.elapsed().as_secs_f64() * 1e3 / n_steps.max(1) as f64;
        let start = Instant::now();
        let mut n_steps = 0;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for frame in 0..FRAMES_A_ROUND {
            on_gpu.set_head_pose(&pose(frame));
            n_steps += on_gpu.advance(&mut encoder, FRAME_SECS)?;
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let on_gpu_ms = start.elapsed().as_secs_f64() * 1e3 / n_steps.max(1) as f64;
        if round > 0 {
            cpu_ms.push(cpu);
            gpu_ms.push(on_gpu_ms);
        }
    }
    Ok(StepTimes { n_guides, n_vertices, cpu_ms: median(&mut cpu_ms), gpu_ms: median(&mut gpu_ms) })
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Strands that leave a ball of 9 cm at its equator and above, and hang in waves.
fn wavy(n_guides: u32, n_vertices: u32) -> GuideSet {
    let n_vertices = n_vertices.max(2);
    let mut positions = Vec::with_capacity((n_guides * n_vertices) as usize);
    for guide_idx in 0..n_guides {
        let y = 0.6 * guide_idx as f32 / n_guides as f32;
        let (sin, cos) = (2.399963 * guide_idx as f32).sin_cos();
        let outwards = Vec3::new(sin, 0.0, cos);
        let root = 9.0 * (outwards * (1.0 - y * y).sqrt() + Vec3::Y * y);
        for k in 0..n_vertices {
            let s = 30.0 * k as f32 / (n_vertices - 1) as f32;
            let aside = 0.4 * (1.2 * s).sin() * outwards.cross(Vec3::Y);
            positions.push(root + outwards * (9.6 - root.dot(outwards)) * (s / 4.0).min(1.0) - Vec3::Y * s + aside);
        }
    }
    GuideSet { n_vertices, positions }
}

fn ball() -> DistanceField {
    let (n, cell, min) = (64_u32, 0.4, Vec3::splat(-12.6));
    let node = |i: u32| min + cell * UVec3::new(i % n, i / n % n, i / (n * n)).as_vec3();
    DistanceField { min, cell, n: [n; 3], values: (0..n * n * n).map(|i| node(i).length() - 9.0).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_solvers_are_timed() {
        let gpu = Gpu::headless().unwrap();
        let times = step_times(&gpu, &ShaderLibrary::embedded(), 50, 16, 2).unwrap();
        assert!(times.cpu_ms > 0.0 && times.gpu_ms > 0.0 && times.cpu_ms.is_finite(), "{times:?}");
    }
}
