//! `lorelei sheet`: every choice of a slot of the look in one picture, labelled with what it costs.

use std::path::{Path, PathBuf};

use lorelei_core::io::{Watch, write_atomically};
use lorelei_shaders::Gpu;
use serde_json::{Value, json};

use super::render::parse_size;
use super::scene::SceneArguments;
use super::{CliError, print_line};
use crate::sheet::{self, Sheet, SheetInput, Tile};

#[derive(Debug, clap::Args)]
pub struct SheetArguments {
    /// The slot whose choices are drawn, as `lorelei looks` lists them: shadowing, transparency, hair, ..; or all:
    /// a picture for each.
    #[arg(long, value_name = "SLOT", value_parser = parse_slot)]
    slot: SlotArgument,
    #[command(flatten)]
    scene: SceneArguments,
    /// Size of one tile in pixels.
    #[arg(long, value_name = "WxH", default_value = "480x480", value_parser = parse_size)]
    size: [u32; 2],
    /// The picture: .png. With --slot all: a folder, in which each picture is called SLOT.png. Without it: SLOT.png, or
    /// the folder `sheets`.
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
    /// Time so many frames of each tile after one that is not counted; the quickest counts.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(0..=1000))]
    repeat: u32,
    /// Print one JSON array: {slot, out, tiles: [{choice, label, is_chosen, gpu_ms, passes, bytes, strands, problem}]}.
    #[arg(long)]
    json: bool,
}

/// One slot, or all of them.
#[derive(Debug, Clone, PartialEq, Eq)]
enum SlotArgument {
    All,
    One(&'static str),
}

fn parse_slot(text: &str) -> Result<SlotArgument, String> {
    if text == "all" {
        return Ok(SlotArgument::All);
    }
    let slots = sheet::slots();
    let found = slots.iter().find(|(key, ..)| *key == text);
    found.map(|(key, ..)| SlotArgument::One(key)).ok_or_else(|| {
        let keys: Vec<&str> = slots.iter().map(|(key, ..)| *key).collect();
        format!("use all or one of {}", keys.join(", "))
    })
}

pub fn run(arguments: &SheetArguments) -> Result<(), CliError> {
    if let (SlotArgument::One(_), Some(out)) = (&arguments.slot, &arguments.out) {
        super::check_png("--out", out)?;
    }
    let scene = arguments.scene.read(arguments.size, &[])?;
    for warning in &scene.warnings {
        eprintln!("warning: {warning}");
    }
    let gpu = Gpu::headless().map_err(CliError::failed)?;
    let input =
        SheetInput { groom: &scene.groom, camera: &scene.camera, size: arguments.size, n_frames: arguments.repeat };
    let mut rows = Vec::new();
    for name in sheet::slots() {
        let out = match &arguments.slot {
            SlotArgument::All => {
                arguments.out.clone().unwrap_or_else(|| "sheets".into()).join(format!("{}.png", name.0))
            }
            SlotArgument::One(key) if *key == name.0 => {
                arguments.out.clone().unwrap_or_else(|| format!("{key}.png").into())
            }
            SlotArgument::One(_) => continue,
        };
        let drawn = sheet::draw(&gpu, name, &input, Watch::default()).map_err(CliError::failed)?;
        let Some(drawn) = drawn else { continue };
        write(&drawn, &out)?;
        if arguments.json {
            rows.push(sheet_json(&drawn, &out));
            continue;
        }
        print_line(&format!("{}: {}", out.display(), drawn.subject))?;
        for tile in &drawn.tiles {
            print_line(&tile_text(&drawn, tile))?;
        }
    }
    if arguments.json {
        return print_line(&Value::Array(rows).to_string());
    }
    Ok(())
}

fn write(sheet: &Sheet, out: &Path) -> Result<(), CliError> {
    super::make_folder_of(out)?;
    let picture = sheet.picture();
    write_atomically(out, |file| picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other))
        .map_err(CliError::failed)
}

fn tile_text(sheet: &Sheet, tile: &Tile) -> String {
    let name = format!("{}={}", sheet.slot, tile.info.name);
    let cost = tile.gpu_ms.map_or_else(|| "no timestamps".to_owned(), |ms| format!("{ms:.2} ms GPU"));
    let problem = tile.picture.as_ref().err().map_or_else(String::new, |why| format!("  {why}"));
    format!("  {name:<36} {cost:>14} {:>8.1} MiB{problem}", tile.n_bytes as f64 / f64::from(1 << 20))
}

fn sheet_json(sheet: &Sheet, out: &Path) -> Value {
    let tiles: Vec<Value> = sheet
        .tiles
        .iter()
        .map(|tile| {
            let passes: serde_json::Map<String, Value> =
                tile.passes.iter().map(|(pass, ms)| (pass.clone(), json!(ms))).collect();
            json!({
                "choice": tile.info.name, "label": tile.info.label, "is_chosen": tile.is_chosen, "gpu_ms": tile.gpu_ms,
                "passes": passes, "bytes": tile.n_bytes, "strands": tile.n_strands,
                "problem": tile.picture.as_ref().err(),
            })
        })
        .collect();
    json!({ "slot": sheet.slot, "out": out, "tiles": tiles })
}
