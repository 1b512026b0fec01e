//! `lorelei measure movement`: what simulated steps take, for strand counts from the references to every strand, under each law,
//! on the GPU and on the CPU.

use std::fmt::Write;
use std::time::Duration;

use lorelei_core::look::Choice;
use lorelei_core::simulation::{SimulationSettings, Solver};
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_sim::bench::{STEPS, Workload, cpu_frame_ms, gpu_frame_ms};
use serde_json::{Value, json};

use super::super::{CliError, print_line};
use super::{MeasureArguments, page};

const PAGE: &str = "docs/movement/solver.md";
/// How long each number is measured, after as long to warm up.
const BUDGET: Duration = Duration::from_millis(400);
/// More strands than these are not asked of a software driver, nor of a CPU.
const MOST_ON_CPU: u32 = 5_000;

/// What is measured, and whose figure stands beside it.
const WORK: [(&str, Workload, &str); 5] = [
    ("guides of Chen 2014", Workload { n_strands: 240, n_vertices: 12 }, "120 frames a second on a GTX 660M"),
    (
        "hair-mesh chains of Yuksel 2009",
        Workload { n_strands: 120, n_vertices: 31 },
        "92 frames a second on one thread of a Core 2 at 2.14 GHz",
    ),
    ("guides", Workload { n_strands: 1_000, n_vertices: 32 }, ""),
    ("guides", Workload { n_strands: 4_000, n_vertices: 32 }, ""),
    ("every strand", Workload { n_strands: 100_000, n_vertices: 32 }, "target 0.8 ms on an H200"),
];

struct Row {
    what: &'static str,
    work: Workload,
    solver: Solver,
    gpu_ms: Option<f64>,
    cpu_ms: Option<f64>,
    thread_ms: Option<f64>,
    beside: &'static str,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let library = ShaderLibrary::embedded();
    let is_software = gpu.adapter_info.device_type == wgpu::DeviceType::Cpu;
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut rows = Vec::new();
    for (what, work, beside) in WORK {
        for &solver in Solver::ALL {
            let settings = SimulationSettings { solver, ..SimulationSettings::default() };
            let is_small = work.n_strands <= MOST_ON_CPU;
            let mut row = Row { what, work, solver, gpu_ms: None, cpu_ms: None, thread_ms: None, beside };
            if is_small || !is_software {
                let ms = gpu_frame_ms(&gpu, &library, work, &settings, BUDGET).map_err(CliError::failed)?;
                row.gpu_ms = Some(ms);
            }
            if is_small {
                row.cpu_ms = Some(cpu_frame_ms(work, &settings, n_threads, BUDGET));
                row.thread_ms = Some(cpu_frame_ms(work, &settings, 1, BUDGET));
            }
            rows.push(row);
        }
    }
    let adapter = &gpu.adapter_info.name;
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(Row::json).collect();
        let all = json!({ "adapter": adapter, "threads": n_threads, "steps": STEPS, "rows": rows });
        return print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?);
    }
    let table = table(adapter, n_threads, &rows);
    match &arguments.write {
        Some(path) => page::write(path, PAGE, &table),
        None => print_line(&table),
    }
}

impl Row {
    fn json(&self) -> Value {
        json!({
            "what": self.what,
            "strands": self.work.n_strands,
            "vertices": self.work.n_vertices,
            "solver": self.solver.info().name,
            "gpu_ms": self.gpu_ms,
            "cpu_ms": self.cpu_ms,
            "thread_ms": self.thread_ms,
        })
    }
}

fn table(adapter: &str, n_threads: usize, rows: &[Row]) -> String {
    let mut text = format!(
        "Milliseconds of a frame of {STEPS} steps, and of one step, on {adapter} and on {n_threads} threads of its machine's CPU, \
         while a head shakes; `lorelei measure movement`.\n\n\
         | strands x vertices | law | GPU, frame | GPU, step | CPU, step | one thread, step | CPU / GPU | |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    let steps = f64::from(STEPS);
    let number = |ms: Option<f64>| ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}"));
    for row in rows {
        let ratio = row.cpu_ms.zip(row.gpu_ms).map_or_else(|| "-".to_owned(), |(cpu, gpu)| format!("{:.1}", cpu / gpu));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} x {}, {} | {} | {} | {} | {} | {} | {ratio} | {} |",
            row.work.n_strands,
            row.work.n_vertices,
            row.what,
            row.solver.info().name,
            number(row.gpu_ms),
            number(row.gpu_ms.map(|ms| ms / steps)),
            number(row.cpu_ms.map(|ms| ms / steps)),
            number(row.thread_ms.map(|ms| ms / steps)),
            row.beside,
        );
    }
    text
}
