//! `--setup FILE.ron`: camera and lights for `render`, so that a picture can be made again.

use std::path::Path;

use lorelei_core::camera::Camera;
use lorelei_core::light::Light;
use serde::{Deserialize, Serialize};

use super::CliError;

/// What a set-up file holds; what it leaves out stays as it is.
///
/// ```ron
/// (
///     camera: Some((target: (0.0, 160.0, 0.0), azimuth_deg: 35.0, elevation_deg: 5.0, distance: 85.0, fov_y_deg: 24.0)),
///     lights: Some([(name: "key", on: true, kind: Directional(azimuth_deg: 40.0, elevation_deg: 40.0),
///         colour: (1.0, 1.0, 1.0), intensity: 2.6, casts_shadow: true)]),
/// )
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Setup {
    pub camera: Option<Camera>,
    pub lights: Option<Vec<Light>>,
}

/// Read a set-up file.
pub fn read(path: &Path) -> Result<Setup, CliError> {
    let text = std::fs::read_to_string(path).map_err(|why| CliError::Failed(format!("{}: {why}", path.display())))?;
    parse(&text).map_err(|why| {
        CliError::Failed(format!(
            "{}: {why}\n`lorelei render --help` shows what a set-up file looks like",
            path.display()
        ))
    })
}

pub(super) fn parse(text: &str) -> Result<Setup, ron::error::SpannedError> {
    ron::from_str(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_up_reads_back_and_a_misspelt_one_is_refused() {
        let setup = Setup { camera: Some(Camera::default()), lights: Some(lorelei_core::light::three_point_rig()) };
        let text = ron::ser::to_string_pretty(&setup, ron::ser::PrettyConfig::default()).unwrap();
        assert_eq!(parse(&text).unwrap(), setup);
        assert_eq!(parse("()").unwrap(), Setup::default());
        let error = parse("(\n  camra: None,\n)").unwrap_err();
        assert!(error.to_string().starts_with('2') || error.to_string().contains("2:"), "names the line: {error}");
    }
}
