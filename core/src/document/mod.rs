//! The `.lorelei` file: a groom in one zip archive that a person can open.
//!
//! `manifest.ron` holds everything that is small, as text; large arrays lie beside it as plain
//! little-endian numbers (`layers/0/strands/points.f32`), painted maps as PNG. The whole groom as RON was
//! rejected: 100 MB of digits; a database was rejected: nobody can look into it without a program.
//!
//! The manifest says the version, and how many values every array has; an archive that holds other sizes
//! is refused before it is unpacked, so a small file cannot fill the memory.

mod arrays;
mod check;
mod error;
mod manifest;

#[cfg(test)]
mod tests;

use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use zip::ZipArchive;

pub use error::DocumentError;
pub use manifest::VERSION;

use crate::groom::Groom;
use crate::io::{Format, Source, Watch, detect, write_atomically};
use manifest::Manifest;

/// The extension of documents.
pub const EXTENSION: &str = "lorelei";

const MANIFEST: &str = "manifest.ron";

/// The manifest is text about layers and lights; this is a thousand times what any needs.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;

/// Save a groom. What was at `path` stays until the new file is complete on the disk.
pub fn save(groom: &Groom, path: &Path) -> Result<(), DocumentError> {
    save_watched(groom, path, Watch::default())
}

/// As [`save`], with progress; a cancelled save leaves what was at `path`.
pub fn save_watched(groom: &Groom, path: &Path, watch: Watch<'_>) -> Result<(), DocumentError> {
    check::check(groom).map_err(|problem| DocumentError::Unsound { path: path.to_owned(), problem })?;
    let parts = manifest::split(groom);
    write_atomically(path, |out| {
        let mut archive = zip::ZipWriter::new(out);
        arrays::write(&mut archive, &parts, watch).map_err(io::Error::other)?;
        archive.finish().map_err(io::Error::other)?;
        Ok(())
    })
    .map_err(|error| {
        let cancelled = crate::io::WriteError::Cancelled { path: path.to_owned() };
        DocumentError::Write(if watch.cancelled() { cancelled } else { error })
    })
}

/// Open a document.
pub fn open(path: &Path) -> Result<Groom, DocumentError> {
    open_watched(path, Watch::default())
}

/// As [`open`], with progress and cancel.
pub fn open_watched(path: &Path, watch: Watch<'_>) -> Result<Groom, DocumentError> {
    // Asks for a file that is there, readable, not empty, and a document.
    let format = detect(path)?;
    if format != Format::Lorelei {
        return Err(DocumentError::NotADocument { path: path.to_owned(), is: format.label() });
    }
    let file =
        std::fs::File::open(path).map_err(|source| crate::io::ReadError::Open { path: path.to_owned(), source })?;
    read(BufReader::new(file), path, watch)
}

/// Open a document from memory; `name` stands for the path in errors.
pub fn open_bytes(name: &str, bytes: &[u8]) -> Result<Groom, DocumentError> {
    Source::from_bytes(name, bytes, Watch::default())?;
    read(io::Cursor::new(bytes), Path::new(name), Watch::default())
}

fn read<R: Read + Seek>(reader: R, path: &Path, watch: Watch<'_>) -> Result<Groom, DocumentError> {
    let mut archive = ZipArchive::new(reader).map_err(|error| DocumentError::archive(path, error))?;
    let text = arrays::read_text(&mut archive, path, MANIFEST, MAX_MANIFEST_BYTES)?;
    let manifest = Manifest::parse(&text, path)?;
    let mut groom = arrays::join(&mut archive, path, manifest, watch)?;
    groom.share_equal_sources();
    check::check(&groom).map_err(|problem| DocumentError::Corrupt {
        path: path.to_owned(),
        part: "its contents".to_owned(),
        problem,
    })?;
    Ok(groom)
}
