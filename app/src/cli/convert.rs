//! `lorelei convert IN OUT`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use lorelei_core::groom::{Groom, Layer};
use lorelei_core::io::{self, Axis, ConvertOptions, Converted, Format, Unit, Watch, What, WriteOptions};

use super::read_as::ReadAs;
use super::{CliError, print_line};
use crate::open;

#[derive(Debug, clap::Args)]
pub struct ConvertArguments {
    /// A groom or hair: .lorelei, .hair, .tfx, .data, .bin, .ply; or an embedded style: long, bob, curls,
    /// crop, ponytail, bun, braid, knot.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// What to write; the name decides the format: .hair, .tfx, .data, .usda, .lorelei; .obj and .glb for the first
    /// hair mesh that a groom has.
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// The axis that points up in OUT. Without it: what OUT's format is used to (z for .hair, else y).
    #[arg(long, value_enum)]
    up: Option<Up>,
    /// The unit of OUT's numbers. Without it: cm.
    #[arg(long, value_enum)]
    unit: Option<OutputUnit>,
    #[command(flatten)]
    read_as: ReadAs,
    /// The curves that strands are made from, or every strand as it is drawn.
    #[arg(long, value_enum, default_value = "strands")]
    what: Curves,
    /// Take IN's polygons (.obj, .glb, .gltf) for a hair mesh: layers named layer_0, layer_1, .., parts that are
    /// alike, or locks of quads that stand on the scalp. OUT may be .lorelei, .obj, .glb or strands.
    #[arg(long)]
    hair_mesh: bool,
    /// The head that the hair mesh stands on. Without it: the mannequin.
    #[arg(long, value_name = "MESH", requires = "hair_mesh")]
    head: Option<PathBuf>,
    /// As one JSON object: strands, points, warnings, out.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Up {
    Y,
    Z,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum OutputUnit {
    Cm,
    M,
    Mm,
    In,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Curves {
    Guides,
    Strands,
}

pub fn run(arguments: &ConvertArguments) -> Result<(), CliError> {
    let options = ConvertOptions {
        output: WriteOptions {
            unit: arguments.unit.map(|unit| match unit {
                OutputUnit::Cm => Unit::Centimetre,
                OutputUnit::M => Unit::Metre,
                OutputUnit::Mm => Unit::Millimetre,
                OutputUnit::In => Unit::Inch,
            }),
            up: arguments.up.map(|up| match up {
                Up::Y => Axis::Y,
                Up::Z => Axis::Z,
            }),
        },
        what: match arguments.what {
            Curves::Guides => What::Guides,
            Curves::Strands => What::Strands,
        },
        input: arguments.read_as.options(),
    };
    let converted = if arguments.hair_mesh || is_hair_mesh_output(&arguments.output) {
        convert_hair_mesh(arguments, options)?
    } else {
        convert(&arguments.input, &arguments.output, options)?
    };
    if arguments.json {
        let json = serde_json::json!({
            "strands": converted.n_strands,
            "points": converted.n_points,
            "space": converted.space_reason,
            "warnings": converted.warnings,
            "out": arguments.output,
        });
        return print_line(&json.to_string());
    }
    for warning in &converted.warnings {
        eprintln!("warning: {warning}");
    }
    if !converted.space_reason.is_empty() {
        eprintln!("read as: {}", converted.space_reason);
    }
    if is_hair_mesh_output(&arguments.output) {
        return print_line(&format!("{}: a hair mesh of {} vertices", arguments.output.display(), converted.n_points));
    }
    print_line(&format!(
        "{}: {} strands, {} points",
        arguments.output.display(),
        converted.n_strands,
        converted.n_points
    ))
}

fn is_hair_mesh_output(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| io::HAIR_MESH_EXTENSIONS.contains(&extension.as_str()))
}

/// A hair mesh from polygons or from a groom, as polygons, a document or the strands that grow in it.
fn convert_hair_mesh(arguments: &ConvertArguments, options: ConvertOptions) -> Result<Converted, CliError> {
    let (input, output) = (&arguments.input, &arguments.output);
    let mut space_reason = String::new();
    let (groom, mut warnings) = if arguments.hair_mesh {
        let (head, notes) = match &arguments.head {
            Some(path) => open::read_head(path, Watch::default()).map_err(CliError::failed)?,
            None => (lorelei_assets::mannequin(), Vec::new()),
        };
        let (layer, found) =
            open::hair_mesh_layer(input, &head, options.input, Watch::default()).map_err(CliError::failed)?;
        space_reason = found.join("; ");
        let groom = Groom { name: layer.name.clone(), head: Some(head), layers: vec![layer], ..Groom::default() };
        (groom, notes)
    } else {
        let opened = open::open(input, None, options.input, Watch::default()).map_err(CliError::failed)?;
        (opened.groom, opened.notes)
    };
    if is_hair_mesh_output(output) {
        let Some(mesh) = open::hair_mesh_of(&groom, None) else {
            return Err(CliError::Failed(format!(
                "{}: no layer is made of a hair mesh. Write strands instead: .hair, .tfx, .data or .usda",
                input.display()
            )));
        };
        io::write_hair_mesh(output, mesh).map_err(CliError::failed)?;
        return Ok(Converted { n_strands: 0, n_points: mesh.n_vertices(), space_reason, warnings });
    }
    if Format::of_output(output) == Some(Format::Lorelei) {
        lorelei_core::document::save(&groom, output).map_err(CliError::failed)?;
        let points = |layer: &Layer| layer.n_strands as usize * layer.vertices_per_strand as usize;
        let n_points = groom.layers.iter().map(points).sum();
        return Ok(Converted { n_strands: groom.n_strands(), n_points, space_reason, warnings });
    }
    let strands = io::strands_of(&groom, options.what);
    let written = io::write_strands(output, &strands, options.output, Watch::default()).map_err(CliError::failed)?;
    warnings.extend(written);
    Ok(Converted { n_strands: strands.n_strands(), n_points: strands.n_points(), space_reason, warnings })
}

/// Grooms are opened here, since the strands of one may grow on an embedded head, which `core` does not have.
fn convert(input: &Path, output: &Path, options: ConvertOptions) -> Result<Converted, CliError> {
    let is_style = open::hairstyle_named(input).is_some();
    let is_document = is_style || io::detect(input).is_ok_and(|format| format.contents() == io::Contents::Document);
    // A name that says no format is refused by the converter, which knows what to say.
    let into = Format::of_output(output);
    if !is_document || into.is_none() {
        return io::convert(input, output, options, Watch::default()).map_err(CliError::failed);
    }
    let opened = open::open(input, None, options.input, Watch::default()).map_err(CliError::failed)?;
    let mut warnings = opened.notes;
    if into == Some(Format::Lorelei) {
        lorelei_core::document::save(&opened.groom, output).map_err(CliError::failed)?;
        let points = |layer: &Layer| layer.n_strands as usize * layer.vertices_per_strand as usize;
        let n_points = opened.groom.layers.iter().map(points).sum();
        let n_strands = opened.groom.n_strands();
        return Ok(Converted { n_strands, n_points, space_reason: String::new(), warnings });
    }
    let strands = io::strands_of(&opened.groom, options.what);
    let written = io::write_strands(output, &strands, options.output, Watch::default()).map_err(CliError::failed)?;
    warnings.extend(written);
    let (n_strands, n_points) = (strands.n_strands(), strands.n_points());
    Ok(Converted { n_strands, n_points, space_reason: String::new(), warnings })
}
