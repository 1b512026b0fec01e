//! `lorelei simulate`: hair that moves, without a window: how well it keeps its laws, what a step costs, pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use image::RgbaImage;
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::io::gltf_motion::{read_motions, track_of};
use lorelei_core::io::{Watch, write_atomically};
use lorelei_core::look::Choice;
use lorelei_core::motion::{Motion, Movement};
use lorelei_core::pin::Pin;
use lorelei_core::simulation::Moved;
use lorelei_render::Bound;
use lorelei_shaders::Gpu;
use lorelei_sim::Measure;
use serde_json::json;

use super::render::{parse_motion, parse_seconds, parse_size};
use super::scene::{Scene, SceneArguments};
use super::wind_source::{self, SourceArgument};
use super::{CliError, check_png, make_folder_of, pin, print_line};
use crate::movement::file::{self, Contents, EXTENSION, Replaced, Writer};
use crate::movement::filmstrip::{camera_of_all, filmstrip, frames_of, title_of};
use crate::movement::range::header_of;
use crate::movement::solver::On;
use crate::movement::{Course, Run, Shot, Subject};
use crate::stage::pacer::Detail;
use crate::stage::{Playback, Stage};

const AFTER_HELP: &str = "\
What is printed, of what is moved (--set moved=guides|mesh|rope|strands):
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
    /// What happens: none, turn, nod, shake, walk, jump, gust. Without it: what the groom's timeline says.
    #[arg(long, value_name = "NAME", value_parser = parse_motion)]
    motion: Option<Motion>,
    /// Let a node of a .glb or .gltf move head and body besides.
    #[arg(long, value_name = "FILE")]
    animation: Option<PathBuf>,
    /// The node of --animation. Without it: the one that is called a head, or the first that moves.
    #[arg(long, value_name = "NAME", requires = "animation")]
    node: Option<String>,
    /// How long it moves. Without it: the groom's range.
    #[arg(long, value_name = "S", value_parser = parse_seconds, allow_negative_numbers = true)]
    seconds: Option<f32>,
    /// How long it rests then, after the motion has gone on to its end.
    #[arg(long, value_name = "S", default_value = "4", value_parser = parse_seconds, allow_negative_numbers = true)]
    rest: f32,
    /// A fan or a vortex, as often as there are any: centimetres in the world, and speed, radius, falloff, gusts,
    /// gust-period, eddies, eddy-size, seed, name, to=X/Y/Z (where it blows to: else the groom's middle). The wind
    /// becomes a grid, unless --set wind=NAME says otherwise. Such as fan,45,0,20,speed=800.
    #[arg(long = "wind-source", value_name = wind_source::SYNTAX, value_parser = wind_source::parse, allow_hyphen_values = true)]
    wind_sources: Vec<SourceArgument>,
    /// A ball on the head that holds what hair lies in it, as often as there are any: centimetres in head space, and radius,
    /// name. Such as 7,2,3,radius=1.5.
    #[arg(long = "pin", value_name = pin::SYNTAX, value_parser = pin::parse, allow_hyphen_values = true)]
    pins: Vec<Pin>,
    /// Let this much time pass before the first frame.
    #[arg(long, value_name = "S", value_parser = parse_seconds, allow_negative_numbers = true)]
    warm_up: Option<f32>,
    /// Frames a second: where the hair is measured and drawn. The steps between are the solver's own.
    #[arg(long, value_name = "N", value_parser = parse_fps, allow_negative_numbers = true)]
    fps: Option<f32>,
    /// The solver of the graphics device, or its twin on all cores.
    #[arg(long, value_enum, default_value = "gpu")]
    on: Device,
    /// A folder for a picture of every frame: frame-0000.png and on; or NAME.frames: the frames in a file, which the
    /// studio opens, and which goes on where an interrupted run has ended.
    #[arg(long, value_name = "FOLDER|NAME.frames")]
    out: Option<PathBuf>,
    /// Eight frames side by side: .png.
    #[arg(long, value_name = "PATH")]
    filmstrip: Option<PathBuf>,
    /// Size of a frame's picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "300x360", value_parser = parse_size)]
    size: [u32; 2],
    /// Print one JSON object: what the help explains, and adapter, what moves, how many, vertices, steps.
    #[arg(long)]
    json: bool,
}

/// Which solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Device {
    Cpu,
    Gpu,
}

impl SimulateArguments {
    /// What is not asked for is as the groom says.
    fn set_movement(&self, groom: &mut Groom) -> Result<(), CliError> {
        let movement = &mut groom.movement;
        if let Some(path) = &self.animation {
            let tracks = read_motions(path, Watch::default()).map_err(CliError::failed)?;
            let track = track_of(&tracks, self.node.as_deref());
            let track = track.map_err(|why| CliError::Usage(format!("--node in {}: {why}", path.display())))?;
            movement.end = movement.start + (track.secs() * self.fps.unwrap_or(movement.fps)).ceil() as u32;
            movement.track = Some(Arc::new(track));
        }
        movement.motion = self.motion.unwrap_or(movement.motion);
        movement.fps = self.fps.unwrap_or(movement.fps);
        movement.warm_up_secs = self.warm_up.unwrap_or(movement.warm_up_secs);
        if let Some(seconds) = self.seconds {
            movement.end = movement.start + (seconds * movement.fps).round().max(1.0) as u32;
        }
        *movement = movement.bounded();
        Ok(())
    }
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
        check_png("--filmstrip", path)?;
    }
    let Scene { mut groom, camera, mut warnings } = arguments.scene.read(arguments.size, &arguments.wind_sources)?;
    groom.simulation.pins.extend_from_slice(&arguments.pins);
    arguments.set_movement(&mut groom)?;
    if !arguments.json {
        for warning in &warnings {
            eprintln!("warning: {warning}");
        }
    }
    let bound = Bound::default().update(&groom, Watch::default()).unwrap_or_default();
    let moved = groom.simulation.moved;
    let subject = Subject::of(&bound, moved);
    if subject.n_curves() == 0 {
        return Err(CliError::failed(format!("{}: there is no hair in it that could move", groom.name)));
    }
    let gpu = (arguments.on == Device::Gpu).then(Gpu::headless).transpose().map_err(CliError::failed)?;
    let on = gpu.map_or(On::Cpu, |gpu| On::Gpu(Box::new(gpu)));
    let adapter = on.device();
    let start = Instant::now();
    let course = Course::of(&groom);
    let Movement { fps, start: first, end, .. } = groom.movement;
    let mut run = Run::start(on, &subject, course.clone(), &groom.movement).map_err(CliError::failed)?;

    let n_frames = end - first;
    let of_strip = if arguments.filmstrip.is_some() { frames_of(n_frames) } else { Vec::new() };
    let of_strip: Vec<u32> = of_strip.into_iter().map(|at| first + at).collect();
    let mut tally = Tally::default();
    let mut shots: Vec<(u32, Shot)> = Vec::new();
    let file = arguments.out.as_deref().filter(|out| is_frames(out));
    let header = header_of(&subject, &course, &groom.movement, &adapter);
    if let Some(path) = file
        && file::replaced(path, &header).map_err(CliError::failed)? == Replaced::Other
    {
        let words = format!("{} held frames of another movement: they are replaced", path.display());
        if !arguments.json {
            eprintln!("warning: {words}");
        }
        warnings.push(words);
    }
    let opened = file.map(|path| Writer::open(path, &header)).transpose().map_err(CliError::failed)?;
    let (mut writer, left) = opened.map_or((None, None), |(writer, left)| (Some(writer), left));
    let mut gone_on_from = None;
    if let Some(Contents { shots: known, state: Some((frame_idx, state)), .. }) = left
        && run.go_on_from(frame_idx, &state)
    {
        gone_on_from = Some(frame_idx);
        shots.extend(known.into_iter().filter(|(at, _)| *at < frame_idx && of_strip.contains(at)));
    }
    loop {
        let measure = run.measure().map_err(CliError::failed)?;
        let frame_idx = run.frame_idx();
        tally.add(run.secs(), &measure);
        let is_drawn = (arguments.out.is_some() && file.is_none()) || of_strip.contains(&frame_idx);
        if is_drawn || writer.is_some() {
            let shot = run.shot().map_err(CliError::failed)?;
            if let Some(writer) = writer.as_mut().filter(|_| gone_on_from != Some(frame_idx))
                && writer.frame(frame_idx, &shot).map_err(CliError::failed)?
            {
                let state = run.read_state().map_err(CliError::failed)?;
                writer.state(frame_idx, &state).map_err(CliError::failed)?;
            }
            if is_drawn {
                shots.push((frame_idx, shot));
            }
        }
        if frame_idx >= end {
            break;
        }
        run.next_frame().map_err(CliError::failed)?;
    }
    if let Some(mut writer) = writer {
        let state = run.read_state().map_err(CliError::failed)?;
        writer.state(end, &state).and_then(|()| writer.finish()).map_err(CliError::failed)?;
    }
    let end_secs = f64::from(course.end_after(groom.movement.secs_of(end) as f32));
    let rest_frames = f64::from(arguments.rest * fps).round() as u32;
    let n_moving = ((end_secs * f64::from(fps)).ceil() as u32).max(end);
    run.end_course_at(n_moving);
    for _ in end..n_moving + rest_frames {
        run.next_frame().map_err(CliError::failed)?;
    }
    let at_rest = run.measure().map_err(CliError::failed)?;
    let (n_steps, ms_per_step) = run.cost();
    let n_not_finite = tally.n_not_finite.max(at_rest.n_not_finite);
    let all_ms = start.elapsed().as_secs_f64() * 1e3;

    if (arguments.out.is_some() && file.is_none()) || arguments.filmstrip.is_some() {
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
            "motion": course.motion.info().name,
            "seconds": f64::from(n_frames) / f64::from(fps),
            "fps": fps,
            "moved": moved.info().name,
            "guides": subject.n_curves(),
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
            "gone_on_from": gone_on_from,
            "warnings": warnings,
            "out": arguments.out,
            "filmstrip": arguments.filmstrip,
        });
        return print_line(&json.to_string());
    }
    print_line(&format!(
        "{}: {} for {:.2} s, {} {} with {} vertices, {n_steps} steps on {adapter}",
        groom.name,
        course.motion.info().label,
        f64::from(n_frames) / f64::from(fps),
        subject.n_curves(),
        match moved {
            Moved::Guides => "guides",
            Moved::Mesh => "chains",
            Moved::Rope => "ropes",
            Moved::Strands => "strands",
        },
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
    let camera = camera_of_all(groom, camera, shots, arguments.size[0] as f32 / arguments.size[1] as f32);
    let mut stage = Stage::new(Gpu::headless().map_err(CliError::failed)?).map_err(CliError::failed)?;
    stage.set_bound(groom, bound).map_err(CliError::failed)?;
    let folder = arguments.out.as_ref().filter(|out| !is_frames(out));
    if let Some(folder) = folder {
        std::fs::create_dir_all(folder).map_err(|why| CliError::Failed(format!("{}: {why}", folder.display())))?;
    }
    let mut strip = Vec::new();
    for (frame_idx, shot) in shots {
        stage.show_shot(shot);
        stage.frame(&Playback::default(), 0.0, &camera, arguments.size, Detail::FULL).map_err(CliError::failed)?;
        let picture = stage.read_pixels().map_err(CliError::failed)?;
        if let Some(folder) = folder {
            write_png(&folder.join(format!("frame-{frame_idx:04}.png")), &picture)?;
        }
        if of_strip.contains(frame_idx) {
            strip.push((groom.movement.secs_of(*frame_idx), picture));
        }
    }
    if let Some(path) = &arguments.filmstrip {
        make_folder_of(path)?;
        write_png(path, &filmstrip(&title_of(groom), line, &strip))?;
    }
    Ok(())
}

/// Whether frames go into a file rather than a folder of pictures.
fn is_frames(out: &Path) -> bool {
    out.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(EXTENSION))
}

fn write_png(path: &Path, picture: &RgbaImage) -> Result<(), CliError> {
    write_atomically(path, |file| picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other))
        .map_err(CliError::failed)
}
