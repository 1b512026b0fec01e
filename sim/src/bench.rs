//! How long steps take: on the GPU, and on the CPU with all cores or with one.

use std::time::{Duration, Instant};

use glam::{UVec3, Vec3};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::SimulationSettings;
use lorelei_shaders::{Gpu, GpuError, ShaderError, ShaderLibrary};

use crate::{CpuSolver, GpuSolver};

/// Steps of a measured frame where nothing else is said.
pub const STEPS: u32 = 8;
const FRAMES_PER_SECOND: f32 = 30.0;
const FRAME_SECS: f32 = 1.0 / FRAMES_PER_SECOND;

/// Strands that shake on a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Workload {
    pub n_strands: u32,
    pub n_vertices: u32,
    /// Of a frame.
    pub n_steps: u32,
    /// They keep out of the ball.
    pub has_field: bool,
}

impl Workload {
    pub const fn new(n_strands: u32, n_vertices: u32) -> Self {
        Self { n_strands, n_vertices, n_steps: STEPS, has_field: true }
    }

    fn steps_per_second(&self) -> f32 {
        self.n_steps as f32 * FRAMES_PER_SECOND
    }

    /// Whether a device can bind what a law keeps of every vertex.
    pub fn fits(&self, gpu: &Gpu) -> bool {
        let bytes = u64::from(self.n_strands) * u64::from(self.n_vertices) * MOST_BYTES_A_VERTEX;
        bytes <= gpu.max_storage_binding()
    }
}

/// Of the largest buffer, in either law.
const MOST_BYTES_A_VERTEX: u64 = 64;

/// Why nothing was measured.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Milliseconds that the GPU takes for a frame of 1/30 s: the median of rounds of several frames each, after warming
/// up for as long. Between two timestamps of the GPU; where it has none, from submission until the work is done.
pub fn gpu_frame_ms(
    gpu: &Gpu,
    library: &ShaderLibrary,
    work: Workload,
    settings: &SimulationSettings,
    budget: Duration,
) -> Result<f64, BenchError> {
    let (guides, field) = (wavy(work), ball());
    let settings = SimulationSettings { steps_per_second: work.steps_per_second(), ..settings.clone() };
    let field = work.has_field.then_some(&field);
    let mut solver = GpuSolver::new(gpu, library, &[&guides], field, &settings)?;
    let stopwatch = Stopwatch::new(gpu);
    let mut n_frames = 0;
    let mut round = |frames: u32| -> Result<f64, BenchError> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        stopwatch.mark(&mut encoder, 0);
        for _ in 0..frames {
            n_frames += 1;
            solver.set_head_pose(&Motion::Shake.pose(n_frames as f32 * FRAME_SECS, Vec3::NEG_Y * 8.0));
            solver.advance(&mut encoder, FRAME_SECS)?;
        }
        stopwatch.mark(&mut encoder, 1);
        let start = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let waited_ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(stopwatch.read_ms(gpu)?.unwrap_or(waited_ms) / f64::from(frames))
    };
    // As many frames as make the gap between two submissions small beside them.
    let frames = ((40.0 / round(1)?.max(1e-3)) as u32).clamp(1, 32);
    let warm_up = Instant::now();
    while warm_up.elapsed() < budget {
        round(frames)?;
    }
    let mut times = Vec::new();
    let start = Instant::now();
    while times.len() < 3 || start.elapsed() < budget {
        times.push(round(frames)?);
    }
    Ok(median(&mut times))
}

/// Two timestamps, where the device has them.
struct Stopwatch(Option<(wgpu::QuerySet, wgpu::Buffer)>);

impl Stopwatch {
    fn new(gpu: &Gpu) -> Self {
        Self(gpu.has(wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS).then(|| {
            let marks = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("bench.marks"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            (marks, gpu.buffer("bench.ticks", 16, wgpu::BufferUsages::QUERY_RESOLVE))
        }))
    }

    /// Record mark 0 or, at the end, 1.
    fn mark(&self, encoder: &mut wgpu::CommandEncoder, idx: u32) {
        if let Some((marks, ticks)) = &self.0 {
            encoder.write_timestamp(marks, idx);
            if idx == 1 {
                encoder.resolve_query_set(marks, 0..2, ticks, 0);
            }
        }
    }

    /// Between the two, once they were submitted. Waits for the GPU.
    fn read_ms(&self, gpu: &Gpu) -> Result<Option<f64>, GpuError> {
        let Some((_, ticks)) = &self.0 else { return Ok(None) };
        let ticks: Vec<u64> = gpu.read_buffer(ticks)?;
        let period_ns = f64::from(gpu.queue.get_timestamp_period());
        Ok(Some(ticks[1].saturating_sub(ticks[0]) as f64 * period_ns * 1e-6))
    }
}

/// Milliseconds that the CPU takes for a frame of [`STEPS`] steps, with as many threads: the median over a time.
pub fn cpu_frame_ms(work: Workload, settings: &SimulationSettings, n_threads: usize, budget: Duration) -> f64 {
    let (guides, field) = (wavy(work), ball());
    let settings = SimulationSettings { steps_per_second: work.steps_per_second(), ..settings.clone() };
    let measured = || {
        let mut solver = CpuSolver::new(&[&guides], work.has_field.then_some(&field), &settings);
        let mut times = Vec::new();
        let start = Instant::now();
        while times.len() < 4 || start.elapsed() < budget {
            solver.set_head_pose(&Motion::Shake.pose(times.len() as f32 * FRAME_SECS, Vec3::NEG_Y * 8.0));
            let frame = Instant::now();
            solver.advance(FRAME_SECS);
            times.push(frame.elapsed().as_secs_f64() * 1e3);
        }
        // The first one touches everything for the first time.
        median(&mut times[1..])
    };
    match rayon::ThreadPoolBuilder::new().num_threads(n_threads).build() {
        Ok(pool) => pool.install(measured),
        Err(_) => measured(),
    }
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Strands that leave a ball of 9 cm at its equator and above, and hang in waves.
fn wavy(work: Workload) -> GuideSet {
    let (n_guides, n_vertices) = (work.n_strands, work.n_vertices.max(2));
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
        let (work, settings) = (Workload::new(20, 16), SimulationSettings::default());
        let on_gpu = gpu_frame_ms(&gpu, &ShaderLibrary::embedded(), work, &settings, Duration::ZERO).unwrap();
        let on_cpu = cpu_frame_ms(work, &settings, 1, Duration::ZERO);
        assert!(on_gpu > 0.0 && on_cpu > 0.0, "{on_gpu} {on_cpu}");
    }
}
