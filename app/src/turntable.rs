//! Turntables: a groom from all around, picture by picture. For the command line and for the window alike.

use std::path::{Path, PathBuf};

use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::io::{Watch, WriteError, write_atomically};
use lorelei_shaders::Gpu;

use crate::stage::pacer::Detail;
use crate::stage::shown::Shown;
use crate::stage::{Playback, Stage, StageError};

/// Why a turntable was not made.
#[derive(Debug, thiserror::Error)]
pub enum TurntableError {
    #[error(transparent)]
    Stage(#[from] StageError),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// A camera of one picture of a turn to the model's left: the first is where it began, and one more would be there
/// again.
pub fn camera_at(camera: &Camera, picture_idx: u32, n_pictures: u32) -> Camera {
    let turned = camera.azimuth_deg + 360.0 * picture_idx as f32 / n_pictures.max(1) as f32;
    Camera { azimuth_deg: (turned + 180.0).rem_euclid(360.0) - 180.0, ..*camera }
}

/// Draw and write `NAME-000.png`, `NAME-001.png`, .. ; returns the paths, fewer where it was cancelled.
pub fn write(
    stage: &mut Stage,
    camera: &Camera,
    size: [u32; 2],
    n_pictures: u32,
    path_of: impl Fn(u32) -> PathBuf,
    watch: Watch<'_>,
) -> Result<Vec<PathBuf>, TurntableError> {
    let mut written = Vec::new();
    for picture_idx in 0..n_pictures {
        if watch.cancelled() {
            break;
        }
        let camera = camera_at(camera, picture_idx, n_pictures);
        stage.frame(&Playback::default(), 0.0, &camera, size, Detail::FULL)?;
        let picture = stage.read_pixels()?;
        let path = path_of(picture_idx);
        write_atomically(&path, |file| picture.write_to(file, image::ImageFormat::Png).map_err(std::io::Error::other))?;
        written.push(path);
        watch.progress((picture_idx + 1) as f32 / n_pictures as f32);
    }
    Ok(written)
}

/// As [`write`], on a device of its own, beside `path`: `NAME-000.png` where it is `NAME.png`.
pub fn write_beside(
    groom: &Groom,
    shown: &Shown,
    camera: &Camera,
    size: [u32; 2],
    n_pictures: u32,
    path: &Path,
    watch: Watch<'_>,
) -> Result<Vec<PathBuf>, TurntableError> {
    let mut stage = Stage::new(Gpu::headless().map_err(StageError::from)?)?;
    stage.set_groom(groom)?;
    stage.set_shown(shown);
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    write(&mut stage, camera, size, n_pictures, |idx| path.with_file_name(format!("{stem}-{idx:03}.png")), watch)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_begins_where_the_camera_is_and_goes_all_around_in_even_steps() {
        let camera = Camera { azimuth_deg: 100.0, ..Camera::default() };
        assert_eq!(camera_at(&camera, 0, 8), camera);
        let azimuths: Vec<f32> = (0..8).map(|idx| camera_at(&camera, idx, 8).azimuth_deg).collect();
        for pair in azimuths.windows(2) {
            let step = (pair[1] - pair[0]).rem_euclid(360.0);
            assert!((step - 45.0).abs() < 1e-3, "{azimuths:?}");
        }
        assert!((camera_at(&camera, 8, 8).azimuth_deg - 100.0).abs() < 1e-3);
    }
}
