//! Writing a file so that it is either all there or not touched.
//!
//! A temporary file beside the target, synced to the disk, then renamed over it: a crash, a full disk or
//! a cancelled export leaves what was there before.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use super::error::WriteError;

/// Names that were tried before giving up.
const N_TRIES: u32 = 100;

static N_TEMPORARY: AtomicU32 = AtomicU32::new(0);

/// Let `write` fill a new file, then put it in place of `path`. On an error what was there is untouched.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    let error = |what: &'static str| move |source| WriteError::Io { path: path.to_owned(), what, source };
    // A link keeps being a link: what it points to is replaced.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.is_dir() {
        return Err(error("the target")(io::Error::from(io::ErrorKind::IsADirectory)));
    }
    let Some(file_name) = target.file_name() else {
        return Err(error("the name")(io::Error::from(io::ErrorKind::InvalidFilename)));
    };
    let before = fs::metadata(&target).ok();
    if let Some(before) = &before {
        if !before.is_file() {
            return Err(WriteError::Refused {
                path: path.to_owned(),
                problem: "is a device or pipe, not a file".to_owned(),
                next: "Choose another name".to_owned(),
            });
        }
        if before.permissions().readonly() {
            return Err(error("it is read-only")(io::Error::from(io::ErrorKind::PermissionDenied)));
        }
    }
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    remove_stale(folder, file_name);
    let (temporary, file) = create_beside(folder, file_name).map_err(error("its folder"))?;
    let filled = fill(file, write).and_then(|()| match &before {
        Some(before) => fs::set_permissions(&temporary, before.permissions()),
        None => Ok(()),
    });
    if let Err(source) = filled.and_then(|()| fs::rename(&temporary, &target)) {
        // Nothing to be done where even this fails; the first error is the one to tell.
        let _ = fs::remove_file(&temporary);
        return Err(error("nothing was changed")(source));
    }
    // The rename itself must survive a power cut too; some file systems cannot sync a folder.
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// What the names of a file's temporaries begin with. Long names stay within the file system's limit.
fn temporary_start(file_name: &std::ffi::OsStr) -> String {
    let start: String = file_name.to_string_lossy().chars().take(40).collect();
    format!(".{start}.")
}

/// Remove temporary files that processes which were killed while they wrote the same file have left. Where
/// it cannot be known whether a process still runs, nothing is removed.
fn remove_stale(folder: &Path, file_name: &std::ffi::OsStr) {
    let start = temporary_start(file_name);
    let Some(entries) = fs::read_dir(folder).ok().filter(|_| Path::new("/proc/self").exists()) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let process = name.strip_prefix(&start).and_then(|rest| rest.strip_suffix(".tmp")?.split_once('-'));
        let process = process.and_then(|(process, n)| n.parse::<u32>().ok().and(process.parse::<u32>().ok()));
        if process.is_some_and(|process| !Path::new(&format!("/proc/{process}")).exists()) {
            // Somebody else may have been quicker.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn create_beside(folder: &Path, file_name: &std::ffi::OsStr) -> io::Result<(PathBuf, File)> {
    let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
    for _ in 0..N_TRIES {
        let n = N_TEMPORARY.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(format!("{}{}-{n}.tmp", temporary_start(file_name), std::process::id()));
        match OpenOptions::new().write(true).read(true).create_new(true).open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}

fn fill(file: File, write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, file);
    write(&mut out)?;
    out.flush()?;
    out.get_ref().sync_all()
}
