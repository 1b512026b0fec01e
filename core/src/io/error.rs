//! What can go wrong with files: each error says what, where in the file, and what to do next.
//!
//! One enum for reading and one for writing, because a person acts differently on them: a file that
//! cannot be read needs another file, a file that cannot be written needs another place.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Where in a file something was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// Offset from the file's first byte.
    Byte(u64),
    /// Line of a text file, from 1.
    Line(u64),
    /// Strand by its index in the file, and its point where that is known, both from 0.
    Strand(u64, Option<u64>),
    /// Vertex of a mesh, from 0.
    Vertex(u64),
    /// A named part: a glTF accessor, an entry of a container.
    Part(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Byte(offset) => write!(f, "at byte {offset}"),
            Self::Line(line) => write!(f, "in line {line}"),
            Self::Strand(strand, None) => write!(f, "in strand {strand}"),
            Self::Strand(strand, Some(point)) => write!(f, "in strand {strand}, point {point}"),
            Self::Vertex(vertex) => write!(f, "in vertex {vertex}"),
            Self::Part(name) => write!(f, "in {name}"),
        }
    }
}

/// A file that could not be read. Nothing of it was kept.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    #[error("{}: cannot be opened: {source}. {}", .path.display(), after_io(.source))]
    Open { path: PathBuf, source: io::Error },
    #[error("{}: is {what}, not a file. Give the path of a file inside it or beside it", .path.display())]
    NotAFile { path: PathBuf, what: &'static str },
    #[error("{}: is empty (0 bytes). Export it again: the program that wrote it did not finish", .path.display())]
    Empty { path: PathBuf },
    #[error("{}: {what}. {next}", .path.display())]
    WrongKind { path: PathBuf, what: String, next: String },
    #[error("{}: reading failed {place}: {source}. Copy the file to a local disk and try again", .path.display())]
    Io { path: PathBuf, place: Place, source: io::Error },
    #[error(
        "{}: ends too early {place}, before {part}: {needed} bytes are due, {has} are left. The file is cut off or its counts are wrong: copy or export it again",
        .path.display()
    )]
    Truncated { path: PathBuf, place: Place, part: String, needed: u64, has: u64 },
    #[error("{}: {problem} {place}. {next}", .path.display())]
    Corrupt { path: PathBuf, place: Place, problem: String, next: String },
    #[error(
        "{}: needs about {} MiB of memory, {} MiB can be used. Close other programs, or thin the groom out where it was made",
        .path.display(), .needed >> 20, .allowed >> 20
    )]
    TooLarge { path: PathBuf, needed: u64, allowed: u64 },
    #[error("{}: {what}. {next}", .path.display())]
    Nothing { path: PathBuf, what: String, next: String },
    #[error("{}: loading was cancelled", .path.display())]
    Cancelled { path: PathBuf },
}

impl ReadError {
    /// The file that the error is about.
    pub fn path(&self) -> &Path {
        match self {
            Self::Open { path, .. }
            | Self::NotAFile { path, .. }
            | Self::Empty { path }
            | Self::WrongKind { path, .. }
            | Self::Io { path, .. }
            | Self::Truncated { path, .. }
            | Self::Corrupt { path, .. }
            | Self::TooLarge { path, .. }
            | Self::Nothing { path, .. }
            | Self::Cancelled { path } => path,
        }
    }

    pub fn is_cancelled(&self) -> bool {
        matches!(self, Self::Cancelled { .. })
    }
}

/// A file that could not be written. What was there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    #[error("{}: cannot be written ({what}): {source}. {}", .path.display(), after_io(.source))]
    Io { path: PathBuf, what: &'static str, source: io::Error },
    #[error("{}: {problem}. {next}", .path.display())]
    Refused { path: PathBuf, problem: String, next: String },
    #[error("{}: writing was cancelled; nothing was changed", .path.display())]
    Cancelled { path: PathBuf },
}

/// What a person can do about an error of the operating system.
fn after_io(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "Check the spelling, and that the folder exists",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "You lack the permission: change it, or use a copy in a folder of your own"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => "The disk is full: free some space and try again",
        io::ErrorKind::IsADirectory => "That is a folder: give the path of a file",
        io::ErrorKind::NotADirectory => "A part of the path is a file, not a folder: check the path",
        io::ErrorKind::InvalidFilename => "The name is not possible on this disk: choose a shorter or plainer one",
        _ => "Try a copy on a local disk",
    }
}
