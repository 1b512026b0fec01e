//! What can go wrong with a document.

use std::path::{Path, PathBuf};

use zip::result::ZipError;

use crate::io::{ReadError, WriteError};

/// A document that could not be opened or saved. Opening changes nothing; saving leaves the old file.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Write(WriteError),
    #[error("{}: is a {is}, not a Lorelei document. Import it instead of opening it", .path.display())]
    NotADocument { path: PathBuf, is: &'static str },
    #[error(
        "{}: was saved by a newer Lorelei ({made_by}, file version {version}); this one reads up to version {}. Update Lorelei to open it; the file was not changed",
        .path.display(), super::VERSION
    )]
    TooNew { path: PathBuf, version: u32, made_by: String },
    #[error("{}: {part}: {problem}. Open a backup or an autosave of it; it is a zip archive, so its parts can also be looked at", .path.display())]
    Corrupt { path: PathBuf, part: String, problem: String },
    #[error("{}: cannot be saved: {problem}. Undo the last change, or remove what is named; the file was not changed", .path.display())]
    Unsound { path: PathBuf, problem: String },
}

impl DocumentError {
    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Read(ReadError::Cancelled { .. }) | Self::Write(WriteError::Cancelled { .. }))
    }

    /// Damage of the archive itself.
    pub(super) fn archive(path: &Path, error: ZipError) -> Self {
        let problem = match error {
            ZipError::Io(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => source.to_string(),
            ZipError::Io(_) => "the file ends too early: it was cut off while it was copied or downloaded".to_owned(),
            ZipError::FileNotFound => "is missing from the archive".to_owned(),
            other => format!("{other} (the file may have been cut off)"),
        };
        Self::Corrupt { path: path.to_owned(), part: "the archive".to_owned(), problem }
    }

    /// The same, of one entry.
    pub(super) fn entry(path: &Path, name: &str, problem: impl std::fmt::Display) -> Self {
        Self::Corrupt { path: path.to_owned(), part: name.to_owned(), problem: problem.to_string() }
    }
}
