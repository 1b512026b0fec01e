//! What a picture without a window is made of: the arguments that name a groom, its camera and its lights, and change
//! them. The same for every command that draws.

use std::path::{Path, PathBuf};

use lorelei_core::binding::MOST_STRANDS;
use lorelei_core::camera::Camera;
use lorelei_core::groom::{Groom, Layer, Source};
use lorelei_core::io::Watch;
use lorelei_core::lod::LodChoice;
use lorelei_core::look::Look;
use lorelei_core::look::presets::{LookPreset, look_preset, look_presets};

use lorelei_core::panorama::read::read_panorama;
use lorelei_core::simulation::Wind;
use lorelei_core::wind::RESOLUTIONS;

use super::read_as::ReadAs;
use super::render::{View, camera_of, parse_view};
use super::wind_source::SourceArgument;
use super::{CliError, set, setup, wind_source};
use crate::open;

#[derive(Debug, clap::Args)]
pub struct SceneArguments {
    /// A groom or hair: .lorelei, .hair, .tfx, .data, .bin, .ply; or an embedded style: long, bob, curls,
    /// crop, ponytail, bun, braid, knot.
    /// Without it: long.
    file: Option<PathBuf>,
    /// An embedded style by its name, where a file is called that too.
    #[arg(long, value_name = "NAME", conflicts_with = "file")]
    template: Option<String>,
    /// The head that the hair belongs to: .obj, .glb, .gltf, .ply.
    #[arg(long, value_name = "MESH")]
    head: Option<PathBuf>,
    /// front, side, back, three-quarter, top, or AZ,EL,DIST: degrees around (0 front, 90 the model's left) and up,
    /// and centimetres from the middle. Without DIST (AZ,EL) all of it fills the picture.
    #[arg(long, default_value = "three-quarter", value_parser = parse_view, allow_hyphen_values = true)]
    camera: View,
    #[command(flatten)]
    read_as: ReadAs,
    /// Camera and lights from a file; --camera then only counts where the file has none.
    #[arg(long, value_name = "FILE.ron")]
    setup: Option<PathBuf>,
    /// Light from all around from a picture, .hdr or .exr: by spherical harmonics, unless --set says otherwise.
    #[arg(long, value_name = "PICTURE")]
    environment: Option<PathBuf>,
    /// Level of detail: off (the finest), auto (by size in the picture), or a level such as 1.5, between two of them.
    #[arg(long, value_name = "LEVEL", value_parser = parse_lod)]
    lod: Option<LodChoice>,
    /// Strands in all, shared out over the layers as they are now.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_STRANDS)))]
    strands: Option<u32>,
    /// A whole look, before --set: a file as `Save look` writes it, or one of the studio's: neutral, fast, reference, rim,
    /// clay, "single scattering".
    #[arg(long, value_name = "FILE|NAME", value_parser = parse_look)]
    look: Option<Look>,
    /// A choice or a number of the look, the fibre (hair.*), the layers (layer.*, style.*) or movement (sim.*):
    /// `lorelei looks` lists them.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = set::parse_assignment)]
    assignments: Vec<(String, String)>,
}

/// A groom as it is to be drawn, from where, and what is to be said about it.
pub struct Scene {
    pub groom: Groom,
    pub camera: Camera,
    pub warnings: Vec<String>,
}

impl SceneArguments {
    /// Read what the arguments name, with what blows besides. `size`: of the picture, in pixels.
    pub fn read(&self, size: [u32; 2], wind_sources: &[SourceArgument]) -> Result<Scene, CliError> {
        let (mut groom, mut warnings) = self.groom()?;
        if let Some(look) = &self.look {
            groom.look.clone_from(look);
        }
        if let Some(path) = &self.environment {
            let panorama = read_panorama(path).map_err(CliError::failed)?;
            let edit = groom.lit_by(panorama);
            groom.apply(edit).map_err(CliError::failed)?;
        }
        wind_source::apply(&mut groom, wind_sources);
        set::apply(&mut groom, &self.assignments)?;
        if let Some(n_strands) = self.strands {
            set_strand_count(&mut groom, n_strands);
        }
        if let Some(choice) = self.lod {
            groom.lod.choice = choice;
        }
        let setup = self.setup.as_deref().map(setup::read).transpose()?.unwrap_or_default();
        if let Some(lights) = setup.lights {
            groom.lights = lights;
        }
        let camera = setup.camera.unwrap_or_else(|| camera_of(&groom, self.camera, size));
        warnings.extend(groom.lacks_panorama());
        let (asked, taken) = (groom.simulation.air.resolution, groom.simulation.air.n_cells());
        if asked != taken && groom.simulation.wind == Wind::Grid {
            let sizes = RESOLUTIONS.map(|n| n.to_string()).join(", ");
            warnings.push(format!("wind.resolution={asked}: the grid has {taken} cells a side; it can have {sizes}"));
        }
        Ok(Scene { groom, camera, warnings })
    }

    fn groom(&self) -> Result<(Groom, Vec<String>), CliError> {
        let template = self.template.as_deref().map(|name| {
            lorelei_assets::hairstyle(name).ok_or_else(|| {
                let names = lorelei_assets::hairstyle_names().join(", ");
                CliError::Usage(format!("--template {name}: use one of {names}"))
            })
        });
        if let Some(groom) = template.transpose()? {
            return with_head(groom, self.head.as_deref());
        }
        let Some(file) = self.file.as_deref() else {
            return with_head(lorelei_assets::default_groom(), self.head.as_deref());
        };
        match open::open(file, self.head.as_deref(), self.read_as.options(), Watch::default()) {
            Ok(opened) => Ok((opened.groom, opened.notes)),
            Err(why @ open::OpenError::IsMesh(_)) => Err(CliError::Usage(why.to_string())),
            Err(why) => Err(CliError::failed(why)),
        }
    }
}

fn with_head(mut groom: Groom, head: Option<&Path>) -> Result<(Groom, Vec<String>), CliError> {
    let put_on = |head| open::put_on(&mut groom, head, Watch::default()).map_err(CliError::failed);
    let warnings = head.map(put_on).transpose()?.unwrap_or_default();
    Ok((groom, warnings))
}

/// A look by its name or its file.
pub fn parse_look(text: &str) -> Result<Look, String> {
    if let Some(preset) = look_preset(text) {
        return Ok(preset.look);
    }
    let path = Path::new(text);
    if path.exists() {
        return LookPreset::open(path).map(|preset| preset.look).map_err(|why| why.to_string());
    }
    let names: Vec<String> = look_presets().into_iter().map(|preset| preset.name).collect();
    Err(format!("there is no such file, and no look of that name; the studio's are: {}", names.join(", ")))
}

fn parse_lod(text: &str) -> Result<LodChoice, String> {
    match text {
        "off" => Ok(LodChoice::Finest),
        "auto" => Ok(LodChoice::Automatic),
        _ => {
            let level = text.parse::<f32>().ok().filter(|level| (0.0..8.0).contains(level));
            level.map(LodChoice::Level).ok_or_else(|| "off, auto, or a level from 0 on".to_owned())
        }
    }
}

/// Share `n_strands` out over the visible layers in proportion to what they have. Imported strands are as
/// many as they are: of them fewer are drawn by the level of detail.
pub(super) fn set_strand_count(groom: &mut Groom, n_strands: u32) {
    let n_now = groom.n_strands().max(1) as f64;
    let share = f64::from(n_strands) / n_now;
    let are_fixed = groom.layers.iter().all(|layer| matches!(layer.source, Source::Strands(_)));
    if are_fixed {
        groom.look.lod = (share as f32).clamp(0.0, 1.0);
        return;
    }
    let is_counted = |layer: &&mut Layer| layer.visible && !matches!(layer.source, Source::Strands(_));
    for layer in groom.layers.iter_mut().filter(is_counted) {
        layer.n_strands = ((f64::from(layer.n_strands) * share).round() as u32).max(1);
    }
}
