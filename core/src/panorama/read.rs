//! Panoramas out of `.hdr` (Radiance RGBE) and `.exr` files.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{ImageFormat, ImageReader, Limits};

use super::Panorama;
use crate::io::usable_memory;

/// Extensions that a panorama is read from.
pub const PANORAMA_EXTENSIONS: [&str; 2] = ["hdr", "exr"];

/// The widest file that is read, in texels; more is a mistake in its header.
const MOST_FILE_WIDTH: u32 = 32_768;

/// Why a file cannot be an environment. Nothing has changed.
#[derive(Debug, thiserror::Error)]
pub enum PanoramaError {
    #[error("{}: cannot be opened: {source}", .path.display())]
    Open { path: PathBuf, source: std::io::Error },
    #[error(
        "{}: is {is}, and an environment is a .hdr or an .exr picture: it must hold more than 256 steps of light",
        .path.display()
    )]
    Format { path: PathBuf, is: String },
    #[error("{}: cannot be read: {source}. The file is cut off or damaged: copy or export it again", .path.display())]
    Decode { path: PathBuf, source: image::ImageError },
    #[error(
        "{}: is {width} x {height} texels, and an environment is twice as wide as high, at most {MOST_FILE_WIDTH} across. \
         Export it as an equirectangular (latitude-longitude) picture",
        .path.display()
    )]
    Shape { path: PathBuf, width: u32, height: u32 },
    #[error(
        "{}: needs about {} MiB of memory, {} MiB can be used. Make it smaller: more than {} texels across are not kept",
        .path.display(), .needed >> 20, .allowed >> 20, Panorama::MOST_WIDTH
    )]
    TooLarge { path: PathBuf, needed: u64, allowed: u64 },
    #[error(
        "{}: texel ({column}, {row}) is {value}, which is no amount of light ({n} such in all). Repair it where it was made, \
         or clamp it on export",
        .path.display()
    )]
    NotLight { path: PathBuf, column: usize, row: usize, value: f32, n: usize },
}

/// Read an equirectangular picture and reduce it to what is kept. Negative numbers, which filters leave, count as no light.
pub fn read_panorama(path: &Path) -> Result<Panorama, PanoramaError> {
    let bytes = std::fs::read(path).map_err(|source| PanoramaError::Open { path: path.to_owned(), source })?;
    from_bytes(path, &bytes)
}

/// As [`read_panorama`], from memory.
pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Panorama, PanoramaError> {
    let path = path.to_owned();
    let decode = |source| PanoramaError::Decode { path: path.clone(), source };
    let format = match image::guess_format(bytes) {
        Ok(format @ (ImageFormat::Hdr | ImageFormat::OpenExr)) => format,
        Ok(other) => return Err(PanoramaError::Format { path, is: format!("a {other:?} picture") }),
        Err(_) if bytes.is_empty() => return Err(PanoramaError::Format { path, is: "empty".to_owned() }),
        Err(_) => return Err(PanoramaError::Format { path, is: "of another kind".to_owned() }),
    };
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(decode)?;
    // A row or two more or less is a matter of taste.
    let is_equirectangular = width > 1 && width.abs_diff(height.saturating_mul(2)) <= 2 + width / 64;
    if !is_equirectangular || width > MOST_FILE_WIDTH {
        return Err(PanoramaError::Shape { path, width, height });
    }
    // Four floats a texel while it is decoded, three of them after that.
    let (needed, allowed) = (u64::from(width) * u64::from(height) * 28, usable_memory());
    if needed > allowed {
        return Err(PanoramaError::TooLarge { path, needed, allowed });
    }
    let mut reader = reader();
    // What it may take was asked above.
    reader.limits(Limits::no_limits());
    let mut texels = reader.decode().map_err(decode)?.into_rgb32f().into_raw();
    let n = texels.chunks_exact(3).filter(|texel| !texel.iter().all(|v| v.is_finite())).count();
    if let Some(at) = texels.iter().position(|v| !v.is_finite()) {
        let (texel, value) = (at / 3, texels[at]);
        let (column, row) = (texel % width as usize, texel / width as usize);
        return Err(PanoramaError::NotLight { path, column, row, value, n });
    }
    for value in &mut texels {
        *value = value.max(0.0);
    }
    Ok(Panorama { path, file_size: [width, height], width, height, texels }.reduced(Panorama::MOST_WIDTH))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use image::{DynamicImage, Rgb, Rgb32FImage};

    use super::*;

    fn encoded(format: ImageFormat, width: u32, height: u32, at: impl Fn(u32, u32) -> [f32; 3]) -> Vec<u8> {
        let picture = Rgb32FImage::from_fn(width, height, |x, y| Rgb(at(x, y)));
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::ImageRgb32F(picture).write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn both_formats_come_back_with_their_light() {
        for (format, tolerance) in [(ImageFormat::Hdr, 0.01), (ImageFormat::OpenExr, 1e-6)] {
            let bytes = encoded(format, 64, 32, |x, y| [x as f32, 100.0 + y as f32, 0.5]);
            let picture = from_bytes(Path::new("sky"), &bytes).unwrap();
            assert_eq!((picture.file_size, picture.width, picture.path.as_path()), ([64, 32], 64, Path::new("sky")));
            let expected = Vec3::new(40.0, 107.0, 0.5);
            assert!((picture.texel(40, 7) / expected - 1.0).abs().max_element() < tolerance, "{format:?}");
        }
    }

    #[test]
    fn bad_files_are_refused_with_what_where_and_what_next() {
        let why = |bytes: &[u8]| from_bytes(Path::new("bad.hdr"), bytes).unwrap_err().to_string();
        let hdr = encoded(ImageFormat::Hdr, 64, 32, |x, _| [x as f32, 1.0, 2.0]);
        let exr = encoded(ImageFormat::OpenExr, 64, 32, |x, _| [x as f32, 1.0, 2.0]);
        for whole in [&hdr, &exr] {
            for share in [3, 9] {
                let cut = why(&whole[..whole.len() * share / 10]);
                assert!(cut.contains("bad.hdr") && cut.contains("export it again"), "{cut}");
            }
        }
        let wild = encoded(ImageFormat::OpenExr, 8, 4, |x, y| if (x, y) == (5, 2) { [f32::NAN; 3] } else { [1.0; 3] });
        assert!(why(&wild).contains("texel (5, 2) is NaN"), "{}", why(&wild));
        assert!(why(&encoded(ImageFormat::OpenExr, 32, 32, |_, _| [1.0; 3])).contains("twice as wide as high"));
        let png = encoded_png();
        assert!(why(&png).contains("a Png picture"), "{}", why(&png));
        assert!(why(b"").contains("empty"));
        assert!(why(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4000000 +X 8000000\n").contains("8000000 x 4000000"));
    }

    fn encoded_png() -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        DynamicImage::new_rgb8(64, 32).write_to(&mut bytes, ImageFormat::Png).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_large_file_is_kept_small_and_negative_light_is_none() {
        let bytes = encoded(ImageFormat::OpenExr, 2048, 1024, |_, _| [2.0, -1.0, 0.5]);
        let picture = from_bytes(Path::new("large.exr"), &bytes).unwrap();
        assert_eq!((picture.width, picture.height, picture.file_size), (1024, 512, [2048, 1024]));
        assert!(picture.texel(700, 300).distance(Vec3::new(2.0, 0.0, 0.5)) < 1e-5);
    }
}
