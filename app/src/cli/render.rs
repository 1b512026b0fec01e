//! `lorelei render`: one picture without a window, and what it cost.

use std::path::PathBuf;
use std::time::Instant;

use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::io::{Watch, write_atomically};
use lorelei_core::look::{Choice, Look, set};
use lorelei_core::motion::{Motion, Movement};
use lorelei_core::pin::Pin;
use lorelei_render::versus::Comparison;
use lorelei_shaders::Gpu;
use serde_json::json;

use super::scene::{Scene, SceneArguments, parse_look};
use super::wind_source::{self, SourceArgument};
use super::{CliError, check_png, make_folder_of, pin, print_line};
use crate::stage::pacer::Detail;
use crate::stage::shown::Shown;
use crate::stage::{Playback, Stage, bounds_of};
use crate::turntable;

const AFTER_HELP: &str = r#"A set-up file (--setup), either part may be left out:
  (
    camera: Some((target: (0, 165, 0), azimuth_deg: 35, elevation_deg: 5, distance: 85, fov_y_deg: 24)),
    lights: Some([
      (name: "key", kind: Directional(azimuth_deg: 40, elevation_deg: 40), intensity: 2.6),
      (name: "lamp", kind: Point(position: (80, 200, 90)), colour: (1, 0.9, 0.8), intensity: 1.5),
      (name: "panel", kind: Rect(position: (0, 190, -120), target: (0, 165, 0), size: 40), intensity: 2),
    ]),
  )
Centimetres, Y up, +Z front, colours linear."#;

#[derive(Debug, clap::Args)]
#[command(after_long_help = AFTER_HELP)]
pub struct RenderArguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    size: [u32; 2],
    /// Let the head move before the picture: none, turn, nod, shake, walk, jump, gust.
    #[arg(long, value_name = "NAME", value_parser = parse_motion, requires = "seconds")]
    motion: Option<Motion>,
    /// How long it moves before the picture is taken.
    #[arg(long, value_name = "S", value_parser = parse_seconds, allow_negative_numbers = true)]
    seconds: Option<f32>,
    /// A fan or a vortex, as often as there are any: centimetres in the world, and speed, radius, falloff, gusts,
    /// gust-period, eddies, eddy-size, seed, name, to=X/Y/Z (where it blows to: else the groom's middle). The wind
    /// becomes a grid, unless --set wind=NAME says otherwise. Such as fan,45,0,20,speed=800;
    /// it blows while --seconds pass.
    #[arg(long = "wind-source", value_name = wind_source::SYNTAX, value_parser = wind_source::parse, allow_hyphen_values = true, requires = "seconds")]
    wind_sources: Vec<SourceArgument>,
    /// A ball on the head that holds what hair lies in it, as often as there are any: centimetres in head space, and radius,
    /// name. Such as 7,2,3,radius=1.5; it holds while --seconds pass.
    #[arg(long = "pin", value_name = pin::SYNTAX, value_parser = pin::parse, allow_hyphen_values = true, requires = "seconds")]
    pins: Vec<Pin>,
    /// Another look beside the groom's own: KEY=VALUE changes the groom's, a file or a name replaces it; one after the
    /// other where there are several.
    #[arg(long, value_name = "LOOK|KEY=VALUE", num_args = 1.., conflicts_with = "repeat")]
    versus: Vec<String>,
    /// With --versus: the groom's own look left of this share of the width, the other right of it.
    #[arg(long, value_name = "SHARE", value_parser = parse_share, requires = "versus", conflicts_with = "difference")]
    wipe: Option<f32>,
    /// With --versus: the absolute difference of the two pictures, times this.
    #[arg(long, value_name = "GAIN", value_parser = parse_gain, requires = "versus")]
    difference: Option<f32>,
    /// So many pictures from all around instead of one; --out is then a folder.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600), conflicts_with_all = ["repeat", "seconds"])]
    turntable: Option<u32>,
    /// The picture: .png; with --turntable a folder.
    #[arg(long, value_name = "PATH", default_value = "lorelei.png")]
    out: PathBuf,
    /// Draw this many frames after one that is not counted; times are their medians. As many are drawn while only the
    /// camera moves (orbit_frame_ms), when strands and shadows are kept.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=10_000))]
    repeat: u32,
    /// Print one JSON object: adapter, strands, vertices, frame_ms, orbit_frame_ms, gpu_ms (by pass), bytes, out.
    #[arg(long)]
    json: bool,
}

/// Where the camera looks from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    azimuth_deg: f32,
    elevation_deg: f32,
    /// `None`: so that all fills the picture.
    distance: Option<f32>,
}

pub(super) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', 'X']).map(|(w, h)| (w.parse::<u32>(), h.parse::<u32>()));
    match sides {
        Some((Ok(width @ 1..=16384), Ok(height @ 1..=16384))) => Ok([width, height]),
        _ => Err("write it as WIDTHxHEIGHT, such as 1920x1080; each side from 1 to 16384".to_owned()),
    }
}

pub(super) fn parse_view(text: &str) -> Result<View, String> {
    let named = match text {
        "front" => Some((0.0, 5.0)),
        "side" => Some((90.0, 5.0)),
        "back" => Some((180.0, 5.0)),
        "three-quarter" => Some((35.0, 5.0)),
        "top" => Some((0.0, 89.0)),
        _ => None,
    };
    if let Some((azimuth_deg, elevation_deg)) = named {
        return Ok(View { azimuth_deg, elevation_deg, distance: None });
    }
    let numbers: Option<Vec<f32>> =
        text.split(',').map(|part| part.trim().parse().ok().filter(|v: &f32| v.is_finite())).collect();
    match numbers.as_deref() {
        Some(&[azimuth_deg, elevation_deg]) if elevation_deg.abs() <= 90.0 => {
            Ok(View { azimuth_deg, elevation_deg, distance: None })
        }
        Some(&[azimuth_deg, elevation_deg, distance]) if elevation_deg.abs() <= 90.0 && distance > 0.0 => {
            Ok(View { azimuth_deg, elevation_deg, distance: Some(distance) })
        }
        _ => Err("use front, side, back, three-quarter, top, or AZ,EL,DIST such as 35,5,85".to_owned()),
    }
}

pub(super) fn parse_motion(text: &str) -> Result<Motion, String> {
    let found = Motion::ALL.iter().find(|motion| motion.info().name == text);
    let names: Vec<&str> = Motion::ALL.iter().map(|motion| motion.info().name).collect();
    found.copied().ok_or_else(|| format!("use one of {}", names.join(", ")))
}

fn parse_share(text: &str) -> Result<f32, String> {
    let share = text.parse::<f32>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "a share of the width from 0 to 1".to_owned())
}

fn parse_gain(text: &str) -> Result<f32, String> {
    let gain = text.parse::<f32>().ok().filter(|gain| (0.0..=1000.0).contains(gain));
    gain.ok_or_else(|| "a number from 0 to 1000".to_owned())
}

/// The other look and how it is seen beside the groom's own.
fn versus_of(arguments: &RenderArguments, groom: &Groom) -> Result<Option<(Look, Comparison)>, CliError> {
    if arguments.versus.is_empty() {
        return Ok(None);
    }
    let mut look = groom.look.clone();
    for text in &arguments.versus {
        let failed = |why: String| CliError::Usage(format!("--versus {text}: {why}"));
        match text.split_once('=') {
            Some((key, value)) => {
                set(&mut look.slots(), key.trim(), value.trim()).map_err(|why| failed(why.to_string()))?;
            }
            None => look = parse_look(text).map_err(failed)?,
        }
    }
    let comparison = match arguments.difference {
        Some(gain) => Comparison::Difference(gain),
        None => Comparison::Wipe(arguments.wipe.unwrap_or(0.5)),
    };
    Ok(Some((look, comparison)))
}

pub(super) fn parse_seconds(text: &str) -> Result<f32, String> {
    let seconds = text.parse::<f32>().ok().filter(|seconds| (0.0..=600.0).contains(seconds));
    seconds.ok_or_else(|| "a number of seconds from 0 to 600".to_owned())
}

pub fn run(arguments: &RenderArguments) -> Result<(), CliError> {
    if arguments.turntable.is_none() {
        check_png("--out", &arguments.out)?;
    }
    let Scene { mut groom, camera, mut warnings } = arguments.scene.read(arguments.size, &arguments.wind_sources)?;
    groom.simulation.pins.extend_from_slice(&arguments.pins);
    let Movement { motion, .. } = groom.movement;
    groom.movement.motion = arguments.motion.unwrap_or(motion);

    let start = Instant::now();
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let adapter = gpu.adapter_info.clone();
    let mut stage = Stage::new(gpu).map_err(CliError::failed)?;
    let compile_ms = ms_since(start);
    let start = Instant::now();
    warnings.extend(stage.set_groom(&groom).map_err(CliError::failed)?);
    let prepare_ms = ms_since(start);
    if !arguments.json {
        for warning in &warnings {
            eprintln!("warning: {warning}");
        }
    }

    stage.set_shown(&Shown { solo: None, versus: versus_of(arguments, &groom)? });
    if let Some(n_pictures) = arguments.turntable {
        return write_turntable(arguments, &mut stage, &camera, n_pictures);
    }

    let mut playback = Playback::default();
    if let Some(seconds) = arguments.seconds {
        let Movement { fps, start, .. } = groom.movement.bounded();
        playback.seek(start + (seconds * fps).round() as u32);
        // Small pictures pass the time quickly.
        let detail = Detail { lod: 0.0, ..Detail::FULL };
        loop {
            stage.frame(&playback, 0.0, &camera, [16, 16], detail).map_err(CliError::failed)?;
            if stage.player().wanted().is_none() {
                break;
            }
        }
    }
    let frame = |stage: &mut Stage, camera: &Camera| -> Result<f32, CliError> {
        let start = Instant::now();
        stage.frame(&playback, 0.0, camera, arguments.size, Detail::FULL).map_err(CliError::failed)?;
        Ok(ms_since(start))
    };
    let first_frame_ms = frame(&mut stage, &camera)?;
    let mut pass_times = vec![stage.pass_times()];
    let (mut orbit_times, mut frame_times) = (Vec::new(), vec![first_frame_ms]);
    if arguments.repeat > 0 {
        (pass_times, frame_times) = (Vec::new(), Vec::new());
    }
    for n in 1..=arguments.repeat {
        let turned = Camera { azimuth_deg: camera.azimuth_deg + 0.5 * n as f32, ..camera };
        orbit_times.push(frame(&mut stage, &turned)?);
    }
    for _ in 0..arguments.repeat {
        stage.forget();
        frame_times.push(frame(&mut stage, &camera)?);
        pass_times.push(stage.pass_times());
    }
    let picture = stage.read_pixels().map_err(CliError::failed)?;
    make_folder_of(&arguments.out)?;
    write_atomically(&arguments.out, |file| {
        picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other)
    })
    .map_err(CliError::failed)?;
    let statistics = stage.statistics();
    let frame_ms = median(frame_times);
    let gpu_ms = pass_medians(&pass_times);
    if arguments.json {
        let passes: serde_json::Map<String, serde_json::Value> =
            gpu_ms.iter().map(|(pass, ms)| (pass.clone(), json!(ms))).collect();
        let json = json!({
            "adapter": adapter.name,
            "driver": format!("{} {}", adapter.driver, adapter.driver_info).trim(),
            "size": arguments.size,
            "strands": statistics.n_strands,
            "vertices": statistics.n_vertices,
            "compile_ms": compile_ms,
            "prepare_ms": prepare_ms,
            "first_frame_ms": first_frame_ms,
            "frame_ms": frame_ms,
            "orbit_frame_ms": (arguments.repeat > 0).then(|| median(orbit_times)),
            "repeat": arguments.repeat,
            "gpu_ms": passes,
            "bytes": statistics.n_bytes,
            "warnings": warnings,
            "out": arguments.out,
        });
        return print_line(&json.to_string());
    }
    print_line(&format!(
        "{}: {} strands, {} vertices, {frame_ms:.1} ms a frame on {}",
        arguments.out.display(),
        statistics.n_strands,
        statistics.n_vertices,
        adapter.name
    ))
}

fn write_turntable(
    arguments: &RenderArguments,
    stage: &mut Stage,
    camera: &Camera,
    n_pictures: u32,
) -> Result<(), CliError> {
    let folder = &arguments.out;
    std::fs::create_dir_all(folder).map_err(|why| CliError::Failed(format!("{}: {why}", folder.display())))?;
    let start = Instant::now();
    let path_of = |idx: u32| folder.join(format!("turntable-{idx:03}.png"));
    let written = turntable::write(stage, camera, arguments.size, n_pictures, path_of, Watch::default())
        .map_err(CliError::failed)?;
    let frame_ms = ms_since(start) / n_pictures as f32;
    if arguments.json {
        return print_line(&json!({ "out": folder, "pictures": written, "frame_ms": frame_ms }).to_string());
    }
    print_line(&format!("{}: {n_pictures} pictures, {frame_ms:.1} ms each", folder.display()))
}

pub(super) fn camera_of(groom: &Groom, view: View, size: [u32; 2]) -> Camera {
    let mut camera = Camera { azimuth_deg: view.azimuth_deg, elevation_deg: view.elevation_deg, ..Camera::default() };
    camera.frame(bounds_of(groom), size[0] as f32 / size[1] as f32);
    if let Some(distance) = view.distance {
        camera.distance = distance;
    }
    camera
}

fn ms_since(start: Instant) -> f32 {
    start.elapsed().as_secs_f32() * 1000.0
}

/// The middle value; the mean of the two middle ones where their number is even.
fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    let n = values.len();
    match n {
        0 => 0.0,
        _ if n % 2 == 1 => values[n / 2],
        _ => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

/// Median by pass, in the order of the frame.
fn pass_medians(frames: &[Vec<(String, f32)>]) -> Vec<(String, f32)> {
    let last = frames.last().map(Vec::as_slice).unwrap_or_default();
    last.iter()
        .map(|(pass, _)| {
            let of_pass =
                frames.iter().filter_map(|frame| frame.iter().find(|(name, _)| name == pass).map(|(_, ms)| *ms));
            (pass.clone(), median(of_pass.collect()))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::setup;
    use super::*;

    #[test]
    fn the_set_up_in_the_help_is_one() {
        let start = AFTER_HELP.find("  (").unwrap();
        let end = AFTER_HELP.rfind(')').unwrap();
        let setup = setup::parse(&AFTER_HELP[start..=end]).unwrap();
        assert_eq!(setup.lights.map(|lights| lights.len()), Some(3));
    }

    #[test]
    fn sizes_and_views_are_read_and_nonsense_is_refused() {
        assert_eq!(parse_size("1920x1080"), Ok([1920, 1080]));
        for bad in ["1920", "0x5", "-1x5", "1x99999", "axb"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert_eq!(parse_view("-35,5,85"), Ok(View { azimuth_deg: -35.0, elevation_deg: 5.0, distance: Some(85.0) }));
        assert_eq!(parse_view("back").map(|view| view.azimuth_deg), Ok(180.0));
        for bad in ["left", "1,2,3,4", "0,100,50", "0,0,-1", "0,0,NaN"] {
            assert!(parse_view(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn medians_are_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        let frames = vec![vec![("a".to_owned(), 1.0)], vec![("a".to_owned(), 3.0)], vec![("a".to_owned(), 2.0)]];
        assert_eq!(pass_medians(&frames), vec![("a".to_owned(), 2.0)]);
    }
}
