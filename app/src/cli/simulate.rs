//! `lorelei simulate`: hair that moves, without a window: how well it keeps its laws, what a step costs, pictures.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::Vec4Swizzles;
use image::RgbaImage;
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::io::{Watch, write_atomically};
use lorelei_core::look::Choice;
use lorelei_core::motion::Motion;
use lorelei_render::Bound;
use lorelei_shaders::Gpu;
use lorelei_sim::Measure;
use serde_json::json;

use super::render::{parse_motion, parse_seconds, parse_size};
use super::scene::{Scene, SceneArguments};
use super::{CliError, check_png, make_folder_of, print_line};
use crate::movement::filmstrip::{filmstrip, frames_of};
use crate::movement::solver::On;
use crate::movement::{Course, Run, Shot, Subject};
use crate::stage::pacer::Detail;
use crate::stage::{Playback, Stage, bounds_of};

const AFTER_HELP: &str = "\
What is printed, of the guides that strands are made from:
  length_error_rms, length_error_max   of each edge over its rest length, less 1; over all frames
  penetration_max_cm                   deepest below the head's surface, and below where it rests
  kinetic_energy                       mean half speed squared, erg/g, at each frame
  rest_speed_max_cm_s                  fastest vertex at the end, after motion and wind have ended and --rest has passed
  nan                                  vertices that were not finite in any frame
  ms_per_step                          solver steps alone, without pictures and measuring";

#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub struct SimulateArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// What happens: none, turn, nod, shake, walk, jump, gust.
    #[arg(long, value_name = "NAME", default_value = "shake", value_parser = parse_motion)]
    motion: Motion,
    /// How long it moves.
    #[arg(long, value_name = "S", default_value = "3", value_parser = parse_seconds)]
    seconds: f32,
    /// How long it rests then, after the motion has gone on to its end.
    #[arg(long, value_name = "S", default_value = "4", value_parser = parse_seconds)]
    rest: f32,
    /// Let this much time pass before the first frame.
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_seconds)]
    warm_up: f32,
    /// Frames a second: where the hair is measured and drawn. The steps between are the solver's own.
    #[arg(long, value_name = "N", default_value = "60", value_parser = parse_fps)]
    fps: f32,
    /// The solver of the graphics device, or its twin on all cores.
    #[arg(long, value_enum, default_value = "gpu")]
    on: Device,
    /// A folder for a picture of every frame: frame-0000.png and on.
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Eight frames side by side: .png.
    #[arg(long, value_name = "PATH")]
    filmstrip: Option<PathBuf>,
    /// Size of a frame's picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "300x360", value_parser = parse_size)]
    size: [u32; 2],
    /// Print one JSON object: what the help explains, and adapter, guides, vertices, steps.
    #[arg(long)]
    json: bool,
}

/// Which solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Device {
    Cpu,
    Gpu,
}

pub(super) fn parse_fps(text: &str) -> Result<f32, String> {
    let fps = text.parse::<f32>().ok().filter(|fps| (1.0..=480.0).contains(fps));
    fps.ok_or_else(|| "frames a second from 1 to 480".to_owned())
}

/// What was measured on the way.
#[derive(Debug, Default)]
struct Tally {
    squared_length_error: f64,
    n_frames: u32,
    length_error_max: f32,
    penetration_max_cm: f32,
    n_not_finite: usize,
    /// Seconds and erg/g.
    kinetic_energy: Vec<(f64, f32)>,
}

impl Tally {
    fn add(&mut self, secs: f64, measure: &Measure) {
        self.squared_length_error += f64::from(measure.length_error_rms).powi(2);
        self.n_frames += 1;
        self.length_error_max = self.length_error_max.max(measure.length_error_max);
        self.penetration_max_cm = self.penetration_max_cm.max(measure.penetration_max_cm);
        self.n_not_finite = self.n_not_finite.max(measure.n_not_finite);
        self.kinetic_energy.push((secs, measure.kinetic_energy));
    }

    fn length_error_rms(&self) -> f64 {
        (self.squared_length_error / f64::from(self.n_frames.max(1))).sqrt()
    }
}

pub fn run(arguments: &SimulateArguments) -> Result<(), CliError> {
    if let Some(path) = &arguments.filmstrip {
        check_png(path)?;
    }
    let Scene { groom, camera, warnings } = arguments.scene.read(arguments.size)?;
    if !arguments.json {
        for warning in &warnings {
            eprintln!("warning: {warning}");
        }
    }
    let bound = Bound::default().update(&groom, Watch::default()).unwrap_or_default();
    let subject = Subject::of(&bound);
    if subject.n_guides() == 0 {
        return Err(CliError::failed(format!("{}: there is no hair in it that could move", groom.name)));
    }
    let gpu = (arguments.on == Device::Gpu).then(Gpu::headless).transpose().map_err(CliError::failed)?;
    let adapter = gpu.as_ref().map_or("CPU, all cores".to_owned(), |gpu| gpu.adapter_info.name.clone());
    let on = gpu.map_or(On::Cpu, |gpu| On::Gpu(Box::new(gpu)));
    let start = Instant::now();
    let course = Course::of(&groom, arguments.motion);
    let mut run =
        Run::start(on, &subject, course.clone(), arguments.fps, arguments.warm_up).map_err(CliError::failed)?;

    let n_frames = (arguments.seconds * arguments.fps).round() as u32;
    let of_strip = if arguments.filmstrip.is_some() { frames_of(n_frames) } else { Vec::new() };
    let mut tally = Tally::default();
    let mut shots: Vec<(u32, Shot)> = Vec::new();
    loop {
        let measure = run.measure().map_err(CliError::failed)?;
        tally.add(run.secs(), &measure);
        if arguments.out.is_some() || of_strip.contains(&run.frame_idx()) {
            shots.push((run.frame_idx(), run.shot().map_err(CliError::failed)?));
        }
        if run.frame_idx() >= n_frames {
            break;
        }
        run.next_frame().map_err(CliError::failed)?;
    }
    let end_secs = f64::from(course.end_after(arguments.seconds));
    let rest_frames = f64::from(arguments.rest * arguments.fps).round() as u32;
    let n_moving = ((end_secs * f64::from(arguments.fps)).ceil() as u32).max(n_frames);
    run.end_course_at(n_moving);
    for _ in n_frames..n_moving + rest_frames {
        run.next_frame().map_err(CliError::failed)?;
    }
    let at_rest = run.measure().map_err(CliError::failed)?;
    let (n_steps, ms_per_step) = run.cost();
    let n_not_finite = tally.n_not_finite.max(at_rest.n_not_finite);
    let all_ms = start.elapsed().as_secs_f64() * 1e3;

    if arguments.out.is_some() || arguments.filmstrip.is_some() {
        let line = format!(
            "length error {:.4} % rms, deepest {:.3} cm, at rest {:.4} cm/s, {ms_per_step:.2} ms a step on {adapter}",
            100.0 * tally.length_error_rms(),
            tally.penetration_max_cm,
            at_rest.speed_max
        );
        draw(arguments, &groom, bound, &camera, &shots, &of_strip, &line)?;
    }
    let energy: Vec<[f64; 2]> = tally.kinetic_energy.iter().map(|&(t, energy)| [t, f64::from(energy)]).collect();
    if arguments.json {
        let json = json!({
            "adapter": adapter,
            "motion": arguments.motion.info().name,
            "seconds": arguments.seconds,
            "fps": arguments.fps,
            "guides": subject.n_guides(),
            "vertices": subject.n_vertices(),
            "steps": n_steps,
            "length_error_rms": tally.length_error_rms(),
            "length_error_max": tally.length_error_max,
            "penetration_max_cm": tally.penetration_max_cm,
            "kinetic_energy": energy,
            "rest_speed_max_cm_s": at_rest.speed_max,
            "rest_kinetic_energy": at_rest.kinetic_energy,
            "from_rest_rms_cm": at_rest.from_rest_rms_cm,
            "nan": n_not_finite,
            "ms_per_step": ms_per_step,
            "all_ms": all_ms,
            "warnings": warnings,
            "out": arguments.out,
            "filmstrip": arguments.filmstrip,
        });
        return print_line(&json.to_string());
    }
    print_line(&format!(
        "{}: {} for {} s, {} guides with {} vertices, {n_steps} steps on {adapter}",
        groom.name,
        arguments.motion.info().label,
        arguments.seconds,
        subject.n_guides(),
        subject.n_vertices()
    ))?;
    print_line(&format!("length_error_rms     {:.6}", tally.length_error_rms()))?;
    print_line(&format!("length_error_max     {:.6}", tally.length_error_max))?;
    print_line(&format!("penetration_max_cm   {:.4}", tally.penetration_max_cm))?;
    let every = (energy.len() / 8).max(1);
    let samples: Vec<String> =
        energy.iter().step_by(every).map(|[secs, energy]| format!("{energy:.1} at {secs:.2} s")).collect();
    print_line(&format!("kinetic_energy       {}", samples.join(", ")))?;
    print_line(&format!("rest_speed_max_cm_s  {:.6}", at_rest.speed_max))?;
    print_line(&format!("nan                  {n_not_finite}"))?;
    print_line(&format!("ms_per_step          {ms_per_step:.4}"))
}

/// The pictures that were asked for.
fn draw(
    arguments: &SimulateArguments,
    groom: &Groom,
    bound: Bound,
    camera: &Camera,
    shots: &[(u32, Shot)],
    of_strip: &[u32],
    line: &str,
) -> Result<(), CliError> {
    let camera = camera_for(groom, camera, shots, arguments.size);
    let mut stage = Stage::new(Gpu::headless().map_err(CliError::failed)?).map_err(CliError::failed)?;
    stage.set_bound(groom, bound).map_err(CliError::failed)?;
    if let Some(folder) = &arguments.out {
        std::fs::create_dir_all(folder).map_err(|why| CliError::Failed(format!("{}: {why}", folder.display())))?;
    }
    let mut strip = Vec::new();
    for (frame_idx, shot) in shots {
        stage.set_shot(Some(shot));
        stage.frame(&Playback::default(), 0.0, &camera, arguments.size, Detail::FULL).map_err(CliError::failed)?;
        let picture = stage.read_pixels().map_err(CliError::failed)?;
        if let Some(folder) = &arguments.out {
            write_png(&folder.join(format!("frame-{frame_idx:04}.png")), &picture)?;
        }
        if of_strip.contains(frame_idx) {
            strip.push((f64::from(*frame_idx) / f64::from(arguments.fps), picture));
        }
    }
    if let Some(path) = &arguments.filmstrip {
        let title = format!("{}: {}", groom.name, arguments.motion.info().label);
        make_folder_of(path)?;
        write_png(path, &filmstrip(&title, line, &strip))?;
    }
    Ok(())
}

fn write_png(path: &Path, picture: &RgbaImage) -> Result<(), CliError> {
    write_atomically(path, |file| picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other))
        .map_err(CliError::failed)
}

/// The camera that was asked for; where that frames the groom at rest, it frames all that is seen of the movement.
fn camera_for(groom: &Groom, camera: &Camera, shots: &[(u32, Shot)], size: [u32; 2]) -> Camera {
    let aspect = size[0] as f32 / size[1] as f32;
    let at_rest = bounds_of(groom);
    let mut framed = *camera;
    framed.frame(at_rest, aspect);
    if framed != *camera {
        return *camera;
    }
    let (mut low, mut high) = at_rest;
    for (_, shot) in shots {
        for p in shot.positions.iter().flatten().map(|p| p.xyz()).filter(|p| p.is_finite()) {
            // An explosion need not be framed whole.
            let p = p.clamp(at_rest.0 - 60.0, at_rest.1 + 60.0);
            (low, high) = (low.min(p), high.max(p));
        }
    }
    framed.frame((low, high), aspect);
    framed
}
