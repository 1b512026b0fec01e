//! Arrays into the archive and out of it, each checked against what the manifest says.

use std::collections::HashMap;
use std::io::{Cursor, Read, Seek, Write};
use std::path::Path;
use std::sync::Arc;

use bytemuck::Pod;
use image::{ImageEncoder, ImageFormat, ImageReader};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::error::DocumentError;
use super::manifest::{
    Content, Manifest, PANORAMA, Parts, faces_of, group_name, hair_mesh_name, map_name, sculpt_name, strands_name,
};
use super::{MANIFEST, MAX_MANIFEST_BYTES};
use crate::groom::{Groom, Source};
use crate::hair_mesh::HairMesh;
use crate::io::{ReadError, Watch, usable_memory};
use crate::maps::ScalpMap;
use crate::mesh::TriMesh;
use crate::panorama::Panorama;
use crate::sculpt::{Sculpt, SculptRoots, SculptStrokes};
use crate::strands::Strands;

/// Deflate packs 1032 bytes into one at most (zlib's technical notes).
const MAX_DEFLATE_RATIO: u64 = 1032;

/// An array larger than this is marked as such; zip's plain sizes end at 4 GiB.
const LARGE_BYTES: u64 = 3 << 30;

/// Bytes between two looks at the cancel flag.
const CHUNK: usize = 4 << 20;

pub(super) fn write<W: Write + Seek>(
    archive: &mut ZipWriter<W>,
    parts: &Parts<'_>,
    watch: Watch<'_>,
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let options = |n_bytes: u64, method| {
        // No date: the same groom gives the same file.
        SimpleFileOptions::default()
            .compression_method(method)
            .compression_level(None)
            .large_file(n_bytes > LARGE_BYTES)
    };
    let text = parts.manifest.to_text()?;
    archive.start_file(MANIFEST, options(text.len() as u64, CompressionMethod::Deflated))?;
    archive.write_all(text.as_bytes())?;
    let n_all: u64 = parts.arrays.iter().map(|part| part.content.n() * 4).sum();
    let mut n_written = 0;
    let mut put = |archive: &mut ZipWriter<W>, bytes: &[u8]| -> std::io::Result<()> {
        for piece in bytes.chunks(CHUNK) {
            if watch.cancelled() {
                return Err(std::io::Error::other("cancelled"));
            }
            archive.write_all(piece)?;
            n_written += piece.len() as u64;
            watch.progress((n_written as f64 / n_all.max(1) as f64).min(1.0) as f32);
        }
        Ok(())
    };
    for part in &parts.arrays {
        let n_bytes = part.content.n() * 4;
        match &part.content {
            Content::Floats(values) => {
                archive.start_file(&part.name, options(n_bytes, CompressionMethod::Deflated))?;
                put(archive, bytemuck::cast_slice(values))?;
            }
            Content::Whole(values) => {
                archive.start_file(&part.name, options(n_bytes, CompressionMethod::Deflated))?;
                put(archive, bytemuck::cast_slice(values))?;
            }
            Content::Map(map) => {
                // A PNG is packed already.
                archive.start_file(&part.name, options(n_bytes, CompressionMethod::Stored))?;
                let mut png = Vec::new();
                image::codecs::png::PngEncoder::new(&mut png).write_image(
                    &map.texels(),
                    map.width(),
                    map.height(),
                    image::ExtendedColorType::L8,
                )?;
                put(archive, &png)?;
            }
        }
    }
    Ok(())
}

/// The text of an entry.
pub(super) fn read_text<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    path: &Path,
    name: &str,
    max_bytes: u64,
) -> Result<String, DocumentError> {
    let entry = archive.by_name(name).map_err(|error| DocumentError::entry(path, name, error))?;
    let mut text = String::new();
    entry.take(max_bytes + 1).read_to_string(&mut text).map_err(|error| DocumentError::entry(path, name, error))?;
    if text.len() as u64 > max_bytes {
        return Err(DocumentError::entry(path, name, format!("has more than {} MiB", MAX_MANIFEST_BYTES >> 20)));
    }
    Ok(text)
}

/// Put the arrays back into the manifest's groom.
pub(super) fn join<R: Read + Seek>(
    archive: &mut ZipArchive<R>,
    path: &Path,
    manifest: Manifest,
    watch: Watch<'_>,
) -> Result<Groom, DocumentError> {
    let mut groom = manifest.groom;
    let needed = manifest.arrays.iter().fold(0u64, |sum, info| sum.saturating_add(info.n.saturating_mul(4)));
    let allowed = usable_memory();
    if needed > allowed {
        return Err(ReadError::TooLarge { path: path.to_owned(), needed, allowed }.into());
    }
    let n_of = manifest.arrays.into_iter().map(|info| (info.name, info.n)).collect();
    let mut arrays = Arrays { archive, path, watch, n_bytes: needed, n_read: 0, n_of };
    if let Some(head) = &mut groom.head {
        head.mesh = Arc::new(arrays.mesh(&head.mesh)?);
    }
    if let Some(panorama) = &mut groom.panorama {
        *panorama = Arc::new(Panorama { texels: arrays.array(PANORAMA)?, ..Panorama::clone(panorama) });
    }
    for (layer_idx, layer) in groom.layers.iter_mut().enumerate() {
        layer.source = match &layer.source {
            Source::HairMesh(hair_mesh) => Source::HairMesh(Arc::new(arrays.hair_mesh(layer_idx, hair_mesh)?)),
            Source::Guides(_) => Source::Guides(Arc::new(arrays.strands(layer_idx)?)),
            Source::Strands(_) => Source::Strands(Arc::new(arrays.strands(layer_idx)?)),
        };
        arrays.sculpt(layer_idx, &mut layer.sculpt)?;
        for (kind, map) in &mut layer.maps {
            *map = Arc::new(arrays.map(&map_name(layer_idx, kind), map)?);
        }
    }
    Ok(groom)
}

struct Arrays<'r, R> {
    archive: &'r mut ZipArchive<R>,
    path: &'r Path,
    watch: Watch<'r>,
    /// Bytes of all arrays, and of those that were read.
    n_bytes: u64,
    n_read: u64,
    /// Values of each array by its name; what is not listed is empty.
    n_of: HashMap<String, u64>,
}

impl<R: Read + Seek> Arrays<'_, R> {
    /// An array of `T`, each made of numbers of four bytes.
    fn array<T: Pod>(&mut self, name: &str) -> Result<Vec<T>, DocumentError> {
        let path = self.path;
        let bad = |problem: String| DocumentError::entry(path, name, problem);
        let Some(n) = self.n_of.remove(name) else { return Ok(Vec::new()) };
        let per_value = size_of::<T>() as u64 / 4;
        if n % per_value != 0 {
            return Err(bad(format!("{n} numbers do not make whole values of {per_value}")));
        }
        let n_bytes = n * 4;
        let mut entry = self.archive.by_name(name).map_err(|error| bad(error.to_string()))?;
        // The sizes are claims; they must agree before memory is taken, and be possible.
        if entry.size() != n_bytes
            || entry.compressed_size().saturating_mul(MAX_DEFLATE_RATIO).saturating_add(64) < n_bytes
        {
            return Err(bad(format!("holds {} bytes where the manifest announces {n_bytes}", entry.size())));
        }
        let mut values: Vec<T> = Vec::new();
        values.try_reserve_exact((n / per_value) as usize).map_err(|_| ReadError::TooLarge {
            path: path.to_owned(),
            needed: n_bytes,
            allowed: usable_memory(),
        })?;
        values.resize((n / per_value) as usize, T::zeroed());
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        for piece in bytes.chunks_mut(CHUNK) {
            if self.watch.cancelled() {
                return Err(ReadError::Cancelled { path: path.to_owned() }.into());
            }
            entry.read_exact(piece).map_err(|error| bad(error.to_string()))?;
            self.n_read += piece.len() as u64;
            self.watch.progress((self.n_read as f64 / self.n_bytes.max(1) as f64) as f32);
        }
        // Reading on to the end is what compares the checksum.
        let n_more = std::io::copy(&mut entry.take(1), &mut std::io::sink()).map_err(|error| bad(error.to_string()))?;
        if n_more > 0 {
            return Err(bad(format!("holds more than the {n_bytes} bytes that it announces")));
        }
        Ok(values)
    }

    fn mesh(&mut self, light: &TriMesh) -> Result<TriMesh, DocumentError> {
        let mut mesh = TriMesh {
            positions: self.array("head/positions.f32")?,
            normals: self.array("head/normals.f32")?,
            uvs: self.array("head/uvs.f32")?,
            triangles: self.array("head/triangles.u32")?,
            groups: light.groups.clone(),
        };
        for (group_idx, group) in mesh.groups.iter_mut().enumerate() {
            group.triangles = self.array(&group_name(group_idx))?;
        }
        Ok(mesh)
    }

    fn strands(&mut self, layer_idx: usize) -> Result<Strands, DocumentError> {
        let name = |name: &str| strands_name(layer_idx, name);
        let mut strands = Strands {
            points: self.array(&name("points.f32"))?,
            offsets: self.array(&name("offsets.u32"))?,
            ids: self.array(&name("ids.u32"))?,
            radii_um: self.array(&name("radii_um.f32"))?,
            colours: self.array(&name("colours.f32"))?,
            opacities: self.array(&name("opacities.f32"))?,
            root_uvs: self.array(&name("root_uvs.f32"))?,
        };
        if strands.offsets.is_empty() {
            strands.offsets.push(0);
        }
        Ok(strands)
    }

    fn sculpt(&mut self, layer_idx: usize, sculpt: &mut Sculpt) -> Result<(), DocumentError> {
        let positions = self.array(&sculpt_name(layer_idx, "roots.f32"))?;
        let uvs = self.array(&sculpt_name(layer_idx, "uvs.f32"))?;
        sculpt.roots = Arc::new(SculptRoots { positions, uvs });
        for (sculpt_idx, layer) in sculpt.layers.iter_mut().enumerate() {
            let ids = self.array(&sculpt_name(layer_idx, &format!("{sculpt_idx}/ids.u32")))?;
            let guides = self.array(&sculpt_name(layer_idx, &format!("{sculpt_idx}/guides.f32")))?;
            layer.strokes = Arc::new(SculptStrokes { ids, guides });
        }
        Ok(())
    }

    fn hair_mesh(&mut self, layer_idx: usize, light: &HairMesh) -> Result<HairMesh, DocumentError> {
        let mut hair_mesh = light.clone();
        for (k, layer) in hair_mesh.layers.iter_mut().enumerate() {
            layer.positions = self.array(&hair_mesh_name(layer_idx, k, "positions.f32"))?;
            layer.pinned = self.array(&hair_mesh_name(layer_idx, k, "pinned.u32"))?;
            let name = hair_mesh_name(layer_idx, k, "faces.u32");
            let flat: Vec<u32> = self.array(&name)?;
            layer.faces = faces_of(&flat).ok_or_else(|| {
                DocumentError::entry(self.path, &name, "the corner counts of its faces do not add up")
            })?;
        }
        Ok(hair_mesh)
    }

    fn map(&mut self, name: &str, light: &ScalpMap) -> Result<ScalpMap, DocumentError> {
        let path = self.path;
        let bad = |problem: String| DocumentError::entry(path, name, problem);
        let n = self.n_of.remove(name).unwrap_or(0);
        if u64::from(light.width()) * u64::from(light.height()) != n {
            return Err(bad(format!("{n} texels are no map of {} x {}", light.width(), light.height())));
        }
        let mut png = Vec::new();
        let entry = self.archive.by_name(name).map_err(|error| bad(error.to_string()))?;
        // A PNG is never much larger than its texels; 64 KiB leave room for what editors add.
        let most = n + n / 8 + (1 << 16);
        entry.take(most + 1).read_to_end(&mut png).map_err(|error| bad(error.to_string()))?;
        if png.len() as u64 > most {
            return Err(bad(format!("is larger than {n} texels can be")));
        }
        let size = ImageReader::with_format(Cursor::new(&png), ImageFormat::Png).into_dimensions();
        let size = size.map_err(|error| bad(error.to_string()))?;
        if size != (light.width(), light.height()) {
            return Err(bad(format!("is {} x {} where {} x {} is due", size.0, size.1, light.width(), light.height())));
        }
        let picture =
            image::load_from_memory_with_format(&png, ImageFormat::Png).map_err(|error| bad(error.to_string()))?;
        ScalpMap::from_texels(light.width(), light.height(), &picture.into_luma8().into_raw())
            .map_err(|error| bad(error.to_string()))
    }
}
