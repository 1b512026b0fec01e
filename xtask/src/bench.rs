//! `cargo xtask bench`: the studio's speed on this machine, as ratios of runs that alternate.
//!
//! It drives the release program through its command line, so that it measures what a user gets.
//! Absolute times are printed with the adapter's name; on a software driver only ratios mean anything.

use std::process::Command;
use std::time::Instant;

use crate::machine::{self, Needs, binary, root};
use crate::numbers::{number, text};
use crate::run::build_release;

const N_ROUNDS: usize = 3;
const N_STRANDS: i32 = 10_000;
const N_POINTS: i32 = 16;

/// `args`: extra arguments for every `lorelei render`, such as `--strands 20000`.
pub fn bench(args: &[String]) -> Result<(), String> {
    machine::prepare(Needs::Pictures)?;
    build_release()?;
    let out = root().join("out");
    std::fs::create_dir_all(&out).map_err(|why| format!("cannot create the folder `out`: {why}"))?;
    let picture = out.join("bench.png");
    let render = |set: &[&str]| -> Result<(String, f64), String> {
        let mut command = Command::new(binary("release", "lorelei"));
        command.args(["render", "--json", "--repeat", "2", "--out"]).arg(&picture);
        for pair in set {
            command.args(["--set", pair]);
        }
        command.args(args);
        let start = Instant::now();
        let output = command.output().map_err(|why| format!("lorelei could not be started: {why}"))?;
        if !output.status.success() {
            return Err(format!("lorelei render failed: {}", String::from_utf8_lossy(&output.stderr)));
        }
        Ok((String::from_utf8_lossy(&output.stdout).into_owned(), start.elapsed().as_secs_f64() * 1e3))
    };

    println!(
        "Compute path against ribbon path, the same frame, alternating ({N_ROUNDS} rounds, median of 2 frames each):"
    );
    let (mut compute, mut ribbons, mut adapter) = (Times::default(), Times::default(), String::new());
    for _ in 0..N_ROUNDS {
        let (json, wall_ms) = render(&["primitive=compute"])?;
        adapter = text(&json, "adapter").unwrap_or_default();
        compute.add(&json, wall_ms, &["raster.count", "raster.scatter", "raster.fine", "raster.more_rounds"])?;
        let (json, wall_ms) = render(&["primitive=ribbons"])?;
        ribbons.add(&json, wall_ms, &["blended"])?;
    }
    println!("  adapter   {adapter}");
    for (what, compute, ribbons) in [
        ("Strands into pixels (GPU timestamps of the path's own passes)", &compute.drawing, &ribbons.drawing),
        ("Whole frame, everything made again", &compute.frame, &ribbons.frame),
        ("Whole frame while only the camera moves", &compute.orbit, &ribbons.orbit),
    ] {
        let (compute, ribbons) = (Spread::of(compute.clone()), Spread::of(ribbons.clone()));
        println!("{what}:");
        println!("  compute   {compute} ms");
        println!("  ribbons   {ribbons} ms");
        println!("  ratio     {:.2}", ribbons.median / compute.median);
    }
    println!("Start-up with the compute path, without a window:");
    for (what, times) in [
        ("shaders and device", compute.compile),
        ("strands bound to the groom", compute.prepare),
        ("first frame", compute.first_frame),
        ("whole process with all frames and the picture", compute.wall),
    ] {
        println!("  {} ms  {what}", Spread::of(times));
    }

    println!("Frames (lorelei measure frames):");
    let measured = Command::new(binary("release", "lorelei")).args(["measure", "frames"]).status();
    if !measured.is_ok_and(|status| status.success()) {
        return Err("lorelei measure frames failed".to_owned());
    }

    println!("Movement (lorelei measure movement):");
    let measured = Command::new(binary("release", "lorelei")).args(["measure", "movement"]).status();
    if !measured.is_ok_and(|status| status.success()) {
        return Err("lorelei measure movement failed".to_owned());
    }
    println!("Work on a groom (lorelei measure grooming):");
    let measured = Command::new(binary("release", "lorelei")).args(["measure", "grooming"]).status();
    if !measured.is_ok_and(|status| status.success()) {
        return Err("lorelei measure grooming failed".to_owned());
    }

    println!("Import rate ({N_STRANDS} strands of {N_POINTS} points, lorelei info, whole process):");
    let source = out.join("bench.data");
    std::fs::write(&source, strands_file()).map_err(|why| format!("cannot write {}: {why}", source.display()))?;
    for format in ["data", "hair", "tfx"] {
        let file = out.join(format!("bench.{format}"));
        if format != "data" {
            let mut convert = Command::new(binary("release", "lorelei"));
            let converted = convert.arg("convert").arg(&source).arg(&file).output();
            let converted = converted.map_err(|why| format!("lorelei could not be started: {why}"))?;
            if !converted.status.success() {
                return Err(format!("lorelei convert failed: {}", String::from_utf8_lossy(&converted.stderr)));
            }
        }
        let bytes = std::fs::metadata(&file).map_or(0, |meta| meta.len());
        let mut times = Vec::new();
        for _ in 0..N_ROUNDS {
            let start = Instant::now();
            let info = Command::new(binary("release", "lorelei")).arg("info").arg(&file).arg("--json").output();
            if !info.is_ok_and(|info| info.status.success()) {
                return Err(format!("lorelei info {} failed", file.display()));
            }
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        let spread = Spread::of(times);
        println!(
            "  .{format:<5} {:7.1} MB in {spread} ms: {:.0} MB/s",
            bytes as f64 / 1e6,
            bytes as f64 / 1e3 / spread.median
        );
    }
    Ok(())
}

/// Wavy strands on a hemisphere of 9 cm in the `.data` layout: a count, then for each strand its count and points.
fn strands_file() -> Vec<u8> {
    let mut bytes = N_STRANDS.to_le_bytes().to_vec();
    for strand_idx in 0..N_STRANDS {
        bytes.extend(N_POINTS.to_le_bytes());
        // Compute a spiral that spaces roots evenly (Vogel 1979).
        let (height, turn) = (strand_idx as f32 / N_STRANDS as f32, strand_idx as f32 * 2.399_963);
        let ring = (1.0 - height * height).sqrt();
        for point_idx in 0..N_POINTS {
            let along = point_idx as f32 / (N_POINTS - 1) as f32;
            let (reach, wave) = (9.0 + 4.0 * along, 0.2 * (12.0 * along + turn).sin());
            let point =
                [reach * ring * turn.cos() + wave, 160.0 + 9.0 * height - 20.0 * along, reach * ring * turn.sin()];
            bytes.extend(point.iter().flat_map(|coordinate| coordinate.to_le_bytes()));
        }
    }
    bytes
}

/// Milliseconds of each run.
#[derive(Default)]
struct Times {
    drawing: Vec<f64>,
    frame: Vec<f64>,
    orbit: Vec<f64>,
    compile: Vec<f64>,
    prepare: Vec<f64>,
    first_frame: Vec<f64>,
    wall: Vec<f64>,
}

impl Times {
    fn add(&mut self, json: &str, wall_ms: f64, drawing: &[&str]) -> Result<(), String> {
        let mut drawing_ms = 0.0;
        for pass in drawing {
            drawing_ms += number(json, pass)?;
        }
        self.drawing.push(drawing_ms);
        for (times, key) in [
            (&mut self.frame, "frame_ms"),
            (&mut self.orbit, "orbit_frame_ms"),
            (&mut self.compile, "compile_ms"),
            (&mut self.prepare, "prepare_ms"),
            (&mut self.first_frame, "first_frame_ms"),
        ] {
            times.push(number(json, key)?);
        }
        self.wall.push(wall_ms);
        Ok(())
    }
}

struct Spread {
    min: f64,
    median: f64,
    max: f64,
}

impl Spread {
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self { min: values[0], median: values[values.len() / 2], max: values[values.len() - 1] }
    }
}

impl std::fmt::Display for Spread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:8.1} (min {:.1}, max {:.1})", self.median, self.min, self.max)
    }
}
