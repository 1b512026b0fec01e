//! Maps as pictures: PNG with 8 or 16 bits, and EXR, in and out.
//!
//! A PNG holds 0-1 as its black to white, whatever the map's measure; an EXR holds the values themselves.
//! Only the first channel is read: a map is no colour, and a grey picture has all channels alike.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageBuffer, ImageFormat, ImageReader};

use super::{MapError, MapKind, ScalpMap};
use crate::io::{WriteError, write_atomically};

/// Extensions that a map is read from and written to.
pub const MAP_EXTENSIONS: [&str; 2] = ["png", "exr"];

/// Why a picture cannot be read as a map, or a map not written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    #[error("{}: {source}", .path.display())]
    Open { path: PathBuf, source: std::io::Error },
    #[error("{}: cannot be read as a picture: {source}. PNG and EXR can", .path.display())]
    Decode { path: PathBuf, source: image::ImageError },
    #[error("{}: {source}", .path.display())]
    Size { path: PathBuf, source: MapError },
    #[error("{}: a map is written as .png or .exr", .path.display())]
    Extension { path: PathBuf },
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// How a map is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureKind {
    Png8,
    Png16,
    Exr,
}

impl PictureKind {
    /// By the extension of a path; a PNG gets 8 bits, which is what a map holds.
    pub fn of_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match extension.as_str() {
            "png" => Some(Self::Png8),
            "exr" => Some(Self::Exr),
            _ => None,
        }
    }
}

/// Read a picture as a map of a kind.
pub fn read_map(path: &Path, kind: &MapKind) -> Result<ScalpMap, PictureError> {
    let open = |source| PictureError::Open { path: path.to_owned(), source };
    let decode = |source| PictureError::Decode { path: path.to_owned(), source };
    let size = |source| PictureError::Size { path: path.to_owned(), source };
    let bytes = std::fs::read(path).map_err(open)?;
    let reader = || ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(open);
    let (width, height) = reader()?.into_dimensions().map_err(decode)?;
    if width == 0 || height == 0 || width.max(height) > ScalpMap::MOST_SIDE {
        return Err(size(MapError::Size { width, height }));
    }
    let is_exr = reader()?.format() == Some(ImageFormat::OpenExr);
    let picture = reader()?.decode().map_err(decode)?;
    // Compute texels from values where the file holds values, from shares of white otherwise.
    let to_texel =
        |value: f32| if is_exr { kind.texel(value) } else { (255.0 * value).round().clamp(0.0, 255.0) as u8 };
    let texels: Vec<u8> = match &picture {
        DynamicImage::ImageLuma8(grey) => grey.as_raw().clone(),
        DynamicImage::ImageLuma16(grey) => grey.as_raw().iter().map(|&g| to_texel(f32::from(g) / 65535.0)).collect(),
        other => other.to_rgb32f().pixels().map(|pixel| to_texel(pixel[0])).collect(),
    };
    ScalpMap::from_texels(width, height, &texels).map_err(size)
}

/// Write a map of a kind as a picture; what was at the path stays until the new file is complete.
pub fn write_map(path: &Path, map: &ScalpMap, kind: &MapKind, picture_kind: PictureKind) -> Result<(), PictureError> {
    let (width, height, texels) = (map.width(), map.height(), map.texels());
    let fits = "as many texels as the size says";
    let (picture, format) = match picture_kind {
        PictureKind::Png8 => {
            (DynamicImage::ImageLuma8(ImageBuffer::from_raw(width, height, texels).expect(fits)), ImageFormat::Png)
        }
        PictureKind::Png16 => {
            let wide = texels.iter().map(|&texel| u16::from(texel) * 257).collect();
            (DynamicImage::ImageLuma16(ImageBuffer::from_raw(width, height, wide).expect(fits)), ImageFormat::Png)
        }
        PictureKind::Exr => {
            let values = texels.iter().flat_map(|&texel| [f32::from(texel) * kind.step(); 3]).collect();
            (DynamicImage::ImageRgb32F(ImageBuffer::from_raw(width, height, values).expect(fits)), ImageFormat::OpenExr)
        }
    };
    let mut bytes = Vec::new();
    let encoded = picture.write_to(&mut Cursor::new(&mut bytes), format);
    encoded.map_err(|source| PictureError::Decode { path: path.to_owned(), source })?;
    Ok(write_atomically(path, |file| std::io::Write::write_all(file, &bytes))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_comes_back_from_every_kind_of_picture() {
        let folder = tempfile::tempdir().unwrap();
        let map = ScalpMap::from_fn(130, 70, |x, y| (x * 2 + y * 3) as u8).unwrap();
        for kind in [MapKind::Density, MapKind::Width, MapKind::LodThickness(2)] {
            for (picture_kind, name) in
                [(PictureKind::Png8, "8.png"), (PictureKind::Png16, "16.png"), (PictureKind::Exr, "values.exr")]
            {
                let path = folder.path().join(name);
                write_map(&path, &map, &kind, picture_kind).unwrap();
                assert_eq!(read_map(&path, &kind).unwrap(), map, "{kind} as {name}");
            }
        }
    }

    #[test]
    fn an_exr_holds_the_values_themselves() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("width.exr");
        let half = MapKind::Width.texel(0.5);
        write_map(&path, &ScalpMap::filled(4, 4, half), &MapKind::Width, PictureKind::Exr).unwrap();
        assert_eq!(read_map(&path, &MapKind::Length).unwrap().texel(0, 0), MapKind::Length.texel(0.5));
    }

    #[test]
    fn what_is_no_picture_is_refused_with_the_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none.png");
        assert!(matches!(read_map(&path, &MapKind::Curl), Err(PictureError::Open { .. })));
        std::fs::write(&path, b"no picture").unwrap();
        assert!(read_map(&path, &MapKind::Curl).unwrap_err().to_string().contains("none.png"));
        assert!(PictureKind::of_path(Path::new("map.jpg")).is_none());
    }
}
