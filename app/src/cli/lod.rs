//! `lorelei lod`: the levels of detail of a groom side by side, with what each costs; or the level that meets a target.

use std::path::PathBuf;

use lorelei_core::camera::Camera;
use lorelei_core::io::{ImportOptions, Watch, write_atomically};
use serde_json::json;

use super::render::{View, camera_of, parse_size, parse_view};
use super::{CliError, print_line};
use crate::lod_strip::{LevelPicture, LevelStage, side_by_side};
use crate::open;

#[derive(Debug, clap::Args)]
pub struct LodArguments {
    /// A groom: .lorelei, or an embedded style: long, bob, curls. Without it: long.
    #[arg(default_value = "long")]
    file: PathBuf,
    /// Write the levels side by side: .png.
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Size of one level's picture in pixels.
    #[arg(long, value_name = "WxH", default_value = "320x320", value_parser = parse_size)]
    size: [u32; 2],
    /// As of `lorelei render`.
    #[arg(long, default_value = "three-quarter", value_parser = parse_view, allow_hyphen_values = true)]
    camera: View,
    /// Find the level that draws this many strands.
    #[arg(long, value_name = "N", conflicts_with = "ms")]
    strands: Option<f32>,
    /// Find the level whose frames take this many milliseconds on this machine.
    #[arg(long, value_name = "MS")]
    ms: Option<f32>,
    /// Print one JSON object: levels (level, strands, vertices, ms) and solved.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &LodArguments) -> Result<(), CliError> {
    let opened = open::open(&arguments.file, None, ImportOptions::default(), Watch::default());
    let groom = opened.map_err(CliError::failed)?.groom;
    let camera: Camera = camera_of(&groom, arguments.camera, arguments.size);
    let mut stage = LevelStage::new(&groom, camera, arguments.size).map_err(CliError::failed)?;
    let mut levels: Vec<LevelPicture> = Vec::new();
    for level in 0..groom.lod.levels.len() {
        levels.push(stage.draw(level as f32).map_err(CliError::failed)?);
    }
    let mut failure = None;
    let solved = arguments.strands.map(|n| (n, false)).or(arguments.ms.map(|ms| (ms, true)));
    let solved = solved.map(|(target, is_ms)| {
        let found = groom.lod.solve(target, |level| match stage.draw(level) {
            Ok(drawn) if is_ms => drawn.ms,
            Ok(drawn) => drawn.n_strands as f32,
            Err(why) => {
                failure = Some(why);
                0.0
            }
        });
        (found, groom.lod.blend(found.0), if is_ms { "ms" } else { "strands" })
    });
    if let Some(why) = failure {
        return Err(CliError::failed(why));
    }
    if let Some(out) = &arguments.out {
        let strip = side_by_side(&levels);
        write_atomically(out, |file| strip.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other))
            .map_err(CliError::failed)?;
    }
    if arguments.json {
        let rows: Vec<_> = levels
            .iter()
            .map(|drawn| {
                json!({ "level": drawn.level, "strands": drawn.n_strands, "vertices": drawn.n_vertices, "ms": drawn.ms })
            })
            .collect();
        let solved = solved.map(|((level, cost), blend, of)| {
            json!({ "level": level, of: cost, "share_of_strands": blend.strands, "share_of_vertices": blend.vertices })
        });
        return print_line(&json!({ "levels": rows, "solved": solved, "out": arguments.out }).to_string());
    }
    for drawn in &levels {
        print_line(&format!(
            "level {}: {} strands, {} vertices, {:.1} ms",
            drawn.level, drawn.n_strands, drawn.n_vertices, drawn.ms
        ))?;
    }
    if let Some(((level, cost), blend, of)) = solved {
        print_line(&format!(
            "level {level:.2} meets it with {cost:.1} {of}: {:.1} % of the strands, {:.0} % of their vertices",
            100.0 * blend.strands,
            100.0 * blend.vertices
        ))?;
    }
    Ok(())
}
