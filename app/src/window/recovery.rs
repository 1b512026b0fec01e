//! Work is not lost by a crash: unsaved changes go to a recovery file every minute, and the next start
//! offers them. A studio that ends normally removes its file.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lorelei_core::groom::Groom;

/// This run's recovery file, and what a crashed run left.
pub struct Recovery {
    folder: PathBuf,
    own: PathBuf,
    /// Left by a run that did not end; newest first.
    pub left: Vec<PathBuf>,
    last_write: Instant,
    written_state: Option<(u64, u64)>,
    /// Between two writes of unsaved changes.
    interval: Duration,
}

impl Recovery {
    /// Look for files of earlier runs in a folder. Those of studios that still run are left alone.
    pub fn new(folder: PathBuf, interval: Duration) -> std::io::Result<Self> {
        std::fs::create_dir_all(&folder)?;
        let own = folder.join(format!("{}.lorelei", std::process::id()));
        let mut left = Vec::new();
        for entry in std::fs::read_dir(&folder)?.flatten() {
            let path = entry.path();
            let is_document = path.extension().is_some_and(|extension| extension == "lorelei");
            if is_document && path != own && !is_running(&path) {
                let modified = entry.metadata().and_then(|metadata| metadata.modified()).ok();
                left.push((modified, path));
            }
        }
        left.sort();
        let left = left.into_iter().rev().map(|(_, path)| path).collect();
        Ok(Self { folder, own, left, last_write: Instant::now(), written_state: None, interval })
    }

    /// Whether unsaved changes should be written now.
    pub fn is_due(&self, state: (u64, u64), is_unsaved: bool) -> bool {
        is_unsaved && self.written_state != Some(state) && self.last_write.elapsed() >= self.interval
    }

    /// Write on a thread; a failure is logged, the next minute tries again.
    pub fn write(&mut self, groom: &Groom, state: (u64, u64)) {
        self.last_write = Instant::now();
        self.written_state = Some(state);
        let (groom, path) = (groom.clone(), self.own.clone());
        std::thread::spawn(move || {
            if let Err(why) = lorelei_core::document::save(&groom, &path) {
                log::warn!("no recovery file was written: {why}");
            }
        });
    }

    /// Where a window that ends badly leaves its groom: offered like what a crash left, should nobody go on.
    pub fn file_for_loss(&self) -> PathBuf {
        self.folder.join("lost-gpu.lorelei")
    }

    /// The new window has it: it is not offered again.
    pub fn forget_loss(&mut self) {
        let file = self.file_for_loss();
        self.left.retain(|path| *path != file);
        remove(&file);
    }

    /// The document was saved or thrown away on purpose: nothing is to be recovered.
    pub fn forget_own(&mut self) {
        remove(&self.own);
        self.written_state = None;
    }

    /// What a crashed run left was taken or refused.
    pub fn forget_left(&mut self) {
        for path in std::mem::take(&mut self.left) {
            remove(&path);
        }
    }
}

fn remove(path: &Path) {
    if let Err(why) = std::fs::remove_file(path)
        && why.kind() != std::io::ErrorKind::NotFound
    {
        log::warn!("{}: {why}", path.display());
    }
}

/// Whether the process that a recovery file is named after still runs.
fn is_running(path: &Path) -> bool {
    let Some(id) = path.file_stem().and_then(|stem| stem.to_string_lossy().parse::<u32>().ok()) else { return false };
    cfg!(target_os = "linux") && Path::new(&format!("/proc/{id}")).exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_dead_run_left_is_offered_and_forgotten_on_request() {
        let folder = tempfile::tempdir().unwrap();
        // No process has this id: Linux ids end at 2^22.
        let dead = folder.path().join("4294967295.lorelei");
        std::fs::write(&dead, b"x").unwrap();
        let own = folder.path().join(format!("{}.lorelei", std::process::id()));
        std::fs::write(&own, b"x").unwrap();
        let mut recovery = Recovery::new(folder.path().to_owned(), Duration::ZERO).unwrap();
        assert_eq!(recovery.left, std::slice::from_ref(&dead));
        recovery.forget_left();
        assert!(!dead.exists() && own.exists());
        recovery.forget_own();
        assert!(!own.exists());
    }
}
