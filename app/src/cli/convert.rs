//! `lorelei convert IN OUT`.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
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
    /// What to write; the name decides the format: .hair, .tfx, .data, .usda, .lorelei.
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
    let converted = convert(&arguments.input, &arguments.output, options)?;
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
    print_line(&format!(
        "{}: {} strands, {} points",
        arguments.output.display(),
        converted.n_strands,
        converted.n_points
    ))
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
        let points = |layer: &lorelei_core::groom::Layer| layer.n_strands as usize * layer.vertices_per_strand as usize;
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
