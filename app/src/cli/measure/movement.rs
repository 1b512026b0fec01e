//! `lorelei measure movement`: what simulated steps take, for strand counts from the references to every strand, under each law,
//! on the GPU and on the CPU; and what contacts, wind and hair against hair add to them.

use std::fmt::Write;
use std::time::Duration;

use lorelei_core::look::Choice;
use lorelei_core::simulation::{SimulationSettings, Solver, Volume, Wind};
use lorelei_core::wind::AirSettings;
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_sim::bench::{STEPS, Workload, cpu_frame_ms, gpu_frame_ms};
use serde_json::{Value, json};

use super::super::{CliError, print_line};
use super::{MeasureArguments, page};
use crate::stage::shader_library;

const PAGE: &str = "docs/movement/solver.md";
/// How long each number is measured, after as long to warm up.
const BUDGET: Duration = Duration::from_millis(400);
/// More strands than these are not asked of a software driver, nor of a CPU, unless they are asked for.
const MOST_ON_CPU: u32 = 5_000;

/// What is measured, and whose figure stands beside it.
const WORK: [(&str, Workload, &str); 6] = [
    ("guides of Chen 2014", Workload::new(240, 12), "120 frames a second on a GTX 660M"),
    (
        "hair-mesh chains of Yuksel 2009",
        Workload::new(120, 31),
        "92 frames a second on one thread of a Core 2 at 2.14 GHz",
    ),
    ("guides", Workload::new(1_000, 32), ""),
    ("guides", Workload::new(4_000, 32), ""),
    ("every strand", Workload::new(100_000, 32), "target 0.8 ms on an H200"),
    (
        "every strand",
        Workload { n_steps: 2, ..Workload::new(100_000, 32) },
        "in 2 steps, as draft quality takes them at 60 frames a second",
    ),
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

/// Law of the frames that something is added to, where none is asked for.
const PLAIN: Solver = Solver::Rods;

/// A frame of the GPU with something more in it, and the same frame with nothing: no obstacle, air that is still, hair that
/// passes through hair.
struct Added {
    n_strands: u32,
    what: &'static str,
    gpu_ms: f64,
    plain_ms: f64,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let library = shader_library().map_err(CliError::failed)?;
    let is_software = gpu.adapter_info.device_type == wgpu::DeviceType::Cpu;
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    let asked_for = arguments.strands.map(|n_strands| ("strands", Workload::new(n_strands, 32), ""));
    let work: Vec<_> = asked_for.map_or_else(|| WORK.to_vec(), |asked_for| vec![asked_for]);
    let is_small = |work: Workload| asked_for.is_some() || work.n_strands <= MOST_ON_CPU;
    let solvers = || {
        let only = arguments.only.as_deref();
        Solver::ALL.iter().copied().filter(move |solver| only.is_none_or(|name| name == solver.info().name))
    };
    let plain = solvers().find(|&solver| solver == PLAIN).or(solvers().next()).unwrap_or(PLAIN);
    let mut rows = Vec::new();
    let mut added = Vec::new();
    for (what, work, beside) in work {
        for solver in solvers() {
            let settings = SimulationSettings { solver, ..SimulationSettings::default() };
            let mut row = Row { what, work, solver, gpu_ms: None, cpu_ms: None, thread_ms: None, beside };
            if work.fits(&gpu) && (is_small(work) || !is_software) {
                let ms = gpu_frame_ms(&gpu, &library, work, &settings, BUDGET).map_err(CliError::failed)?;
                row.gpu_ms = Some(ms);
            }
            if is_small(work) {
                row.cpu_ms = Some(cpu_frame_ms(work, &settings, n_threads, BUDGET));
            }
            if work.n_strands <= MOST_ON_CPU {
                row.thread_ms = Some(cpu_frame_ms(work, &settings, 1, BUDGET));
            }
            let is_plain =
                solver == plain && work.n_strands >= 1_000 && work.n_strands != 4_000 && work.n_steps == STEPS;
            if row.gpu_ms.is_some() && is_plain {
                added.extend(added_to(&gpu, &library, work, &settings)?);
            }
            rows.push(row);
        }
    }
    let adapter = &gpu.adapter_info.name;
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(Row::json).collect();
        let beside: Vec<Value> = added.iter().map(Added::json).collect();
        let all = json!({ "adapter": adapter, "threads": n_threads, "rows": rows, "beside": beside });
        return print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?);
    }
    let table = format!("{}{}", table(adapter, n_threads, &rows), table_of_added(plain, &added));
    match &arguments.write {
        Some(path) => page::write(path, PAGE, &table),
        None => print_line(&table),
    }
}

/// What each choice adds to a frame.
fn added_to(
    gpu: &Gpu,
    library: &ShaderLibrary,
    work: Workload,
    settings: &SimulationSettings,
) -> Result<Vec<Added>, CliError> {
    let plain = SimulationSettings { wind: Wind::Off, volume: Volume::Off, ..settings.clone() };
    let nowhere = Workload { has_field: false, ..work };
    let ms = |work: Workload, settings: &SimulationSettings| {
        gpu_frame_ms(gpu, library, work, settings, BUDGET).map_err(CliError::failed)
    };
    let blown = |wind: Wind, resolution: u32| SimulationSettings {
        wind,
        wind_speed: 300.0,
        air: AirSettings { resolution, ..plain.air.clone() },
        ..plain.clone()
    };
    let crowded = |volume: Volume| SimulationSettings { volume, ..plain.clone() };
    let plain_ms = ms(nowhere, &plain)?;
    let cases = [
        ("contact with the head's field", work, plain.clone()),
        ("steady wind", nowhere, blown(Wind::Uniform, 32)),
        ("wind on a grid of 32 cubed", nowhere, blown(Wind::Grid, 32)),
        ("wind on a grid of 64 cubed", nowhere, blown(Wind::Grid, 64)),
        ("hair against hair, density", nowhere, crowded(Volume::Density)),
        ("hair against hair, density and velocity", nowhere, crowded(Volume::DensityVelocity)),
    ];
    let of_case = |(what, work, settings): (&'static str, Workload, SimulationSettings)| {
        Ok(Added { n_strands: work.n_strands, what, gpu_ms: ms(work, &settings)?, plain_ms })
    };
    cases.into_iter().map(of_case).collect()
}

impl Row {
    fn json(&self) -> Value {
        json!({
            "what": self.what,
            "strands": self.work.n_strands,
            "vertices": self.work.n_vertices,
            "steps": self.work.n_steps,
            "solver": self.solver.info().name,
            "gpu_ms": self.gpu_ms,
            "cpu_ms": self.cpu_ms,
            "thread_ms": self.thread_ms,
        })
    }
}

impl Added {
    fn json(&self) -> Value {
        json!({
            "strands": self.n_strands,
            "what": self.what,
            "gpu_ms": self.gpu_ms,
            "plain_ms": self.plain_ms,
        })
    }
}

fn table(adapter: &str, n_threads: usize, rows: &[Row]) -> String {
    let mut text = format!(
        "Milliseconds of a frame of {STEPS} steps where no other number stands, and of one step, on {adapter} and on {n_threads} \
         threads of its machine's CPU, while a head shakes; `lorelei measure movement`.\n\n\
         | strands x vertices | law | GPU, frame | GPU, step | CPU, step | one thread, step | CPU / GPU | |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    let number = |ms: Option<f64>| ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.3}"));
    for row in rows {
        let steps = f64::from(row.work.n_steps);
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

fn table_of_added(plain: Solver, added: &[Added]) -> String {
    if added.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "\nWhat else a frame of the GPU pays for, beside the same frame of {} without obstacles, in still air, where hair passes \
         through hair:\n\n\
         | strands | with | frame | plain frame | more |\n\
         |---|---|---|---|---|\n",
        plain.info().name
    );
    for Added { n_strands, what, gpu_ms, plain_ms } in added {
        let more = 100.0 * (gpu_ms / plain_ms - 1.0);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "| {n_strands} | {what} | {gpu_ms:.3} | {plain_ms:.3} | {more:.0} % |");
    }
    text
}
