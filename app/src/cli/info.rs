//! `lorelei info FILE`.

use std::path::PathBuf;

use lorelei_core::io::{self, Watch};

use super::{CliError, print_line};

#[derive(Debug, clap::Args)]
pub struct InfoArguments {
    /// A groom, hair of another program, or a head.
    file: PathBuf,
    /// As one JSON object: strands, points, bounds (min, max), unit, up, attributes, warnings, ..
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &InfoArguments) -> Result<(), CliError> {
    let info = io::info(&arguments.file, Watch::default()).map_err(CliError::failed)?;
    if arguments.json {
        return print_line(&serde_json::to_string_pretty(&info).map_err(CliError::failed)?);
    }
    print_line(&format!("{}: {}", arguments.file.display(), info.format))?;
    if info.strands > 0 {
        print_line(&format!("strands     {}", info.strands))?;
    }
    print_line(&format!("points      {}", info.points))?;
    if info.triangles > 0 {
        print_line(&format!("triangles   {}", info.triangles))?;
    }
    print_line(&format!("bounds      {} to {}", info.bounds.min, info.bounds.max))?;
    print_line(&format!("in cm       {} to {}", info.bounds_cm.min, info.bounds_cm.max))?;
    print_line(&format!(
        "unit, axes  {}, {} up, {} front: {}",
        info.unit.name(),
        info.up.name(),
        info.front.name(),
        info.space_reason
    ))?;
    if !info.attributes.is_empty() {
        print_line(&format!("attributes  {}", info.attributes.join(", ")))?;
    }
    for warning in &info.warnings {
        print_line(&format!("warning     {warning}"))?;
    }
    Ok(())
}
