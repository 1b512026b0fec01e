//! `lorelei map`: a painted map out of a groom as a picture, or a picture into it.

use std::path::PathBuf;
use std::sync::Arc;

use lorelei_core::document;
use lorelei_core::edit::Edit;
use lorelei_core::io::{ImportOptions, Watch};
use lorelei_core::maps::picture::{PictureKind, read_map, write_map};
use lorelei_core::maps::{MapKind, ScalpMap};

use super::{CliError, print_line};
use crate::open;

const AFTER_HELP: &str = "\
Examples:
  lorelei map bob --kind density --out density.png           the density of the first layer, 0 black to 1 white
  lorelei map my.lorelei --list                              which maps each layer has
  lorelei map my.lorelei --kind length --in cut.exr --save my.lorelei
  lorelei map my.lorelei --kind dye --in streaks.png --save my.lorelei   where strands take the material's dye
  lorelei map my.lorelei --kind mask:fringe --layer 1 --in fringe.png --save out.lorelei

A PNG holds 0-1 as black to white of the map's range, an EXR holds the values themselves. Row 0 is v = 1.";

#[derive(Debug, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct MapArguments {
    /// A groom: .lorelei, or an embedded style: long, bob, curls.
    file: PathBuf,
    /// density, length, width, clump, curl, dye, tied, hold, mask:NAME, lod-density:LEVEL or lod-thickness:LEVEL.
    #[arg(long, required_unless_present = "list")]
    kind: Option<MapKind>,
    /// Number of the layer, from 0 in the order of the outliner.
    #[arg(long, value_name = "N", default_value_t = 0)]
    layer: usize,
    /// Write the map here: .png or .exr. A map that the layer lacks is written as its default.
    #[arg(long, value_name = "PICTURE")]
    out: Option<PathBuf>,
    /// Write a PNG with 16 bits.
    #[arg(long, requires = "out")]
    wide: bool,
    /// Read the map from here: .png (8 or 16 bits) or .exr, any size.
    #[arg(long = "in", value_name = "PICTURE", requires = "save")]
    from: Option<PathBuf>,
    /// The groom to write with the map in it: .lorelei.
    #[arg(long, value_name = "FILE", requires = "from")]
    save: Option<PathBuf>,
    /// List the maps of every layer, and do nothing.
    #[arg(long)]
    list: bool,
}

pub fn run(arguments: &MapArguments) -> Result<(), CliError> {
    let file = &arguments.file;
    let opened = open::open(file, None, ImportOptions::default(), Watch::default()).map_err(CliError::failed)?;
    let mut groom = opened.groom;
    if arguments.list {
        for (layer_idx, layer) in groom.layers.iter().enumerate() {
            print_line(&format!("{layer_idx} {}", layer.name))?;
            for (kind, map) in &layer.maps {
                print_line(&format!("  {kind}  {} x {}", map.width(), map.height()))?;
            }
        }
        return Ok(());
    }
    let Some(kind) = &arguments.kind else { return Ok(()) };
    let n_layers = groom.layers.len();
    let Some(layer) = groom.layers.get(arguments.layer) else {
        return Err(CliError::Usage(format!("--layer {}: {} has {n_layers} layers", arguments.layer, file.display())));
    };
    if arguments.out.is_none() && arguments.from.is_none() {
        return Err(CliError::Usage("say what to do: --out PICTURE, or --in PICTURE with --save FILE".to_owned()));
    }
    if let Some(out) = &arguments.out {
        let picture_kind = match (PictureKind::of_path(out), arguments.wide) {
            (Some(PictureKind::Png8), true) => PictureKind::Png16,
            (Some(picture_kind), _) => picture_kind,
            (None, _) => {
                return Err(CliError::Usage(format!("--out {}: let the name end in .png or .exr", out.display())));
            }
        };
        let map = layer.maps.get(kind).map_or_else(|| kind.empty_map(), |map| ScalpMap::clone(map));
        write_map(out, &map, kind, picture_kind).map_err(CliError::failed)?;
        print_line(&format!("{}: {kind} of {}, {} x {}", out.display(), layer.name, map.width(), map.height()))?;
    }
    if let (Some(from), Some(save)) = (&arguments.from, &arguments.save) {
        let map = read_map(from, kind).map_err(CliError::failed)?;
        let what = format!("{}: {kind} of {} is {} x {}", save.display(), layer.name, map.width(), map.height());
        let edit = Edit::SetMap { layer_idx: arguments.layer, kind: kind.clone(), map: Some(Arc::new(map)) };
        groom.apply(edit).map_err(CliError::failed)?;
        document::save(&groom, save).map_err(CliError::failed)?;
        print_line(&what)?;
    }
    Ok(())
}
