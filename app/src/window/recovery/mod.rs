//! Work is not lost by a crash: every step goes to a journal, and the next start offers what it leads to. A
//! studio that ends normally removes its files.
//!
//! In the recovery folder a studio keeps, under the number of its process:
//!
//! - `PID-K.journal`: what was done since its base, one record a line ([`lorelei_core::record`]). The base is
//!   the document's own file, an embedded style, or
//! - `PID-K.lorelei`: an autosave, with which a journal begins anew.
//!
//! A journal rolls over into an autosave when it is large, once a minute, when a step is too large to be
//! written as text, and where the document is in no file yet. While an autosave is being written, steps go to
//! the old journal and to the new one, so that at every moment a base and its journal are complete.
//!
//! A record is handed to the system as soon as its step has happened, which is what survives the death of
//! the process; it is synced to the disk at most two seconds later, which is what survives a power cut.
//!
//! Keeping the whole groom after each step was rejected: a groom of a hundred megabytes takes seconds.

mod restore;
mod writer;

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use lorelei_core::record::Record;

use super::document::Document;
pub use restore::{Restored, forget_own_run, restore};
use writer::{Message, Writer};

/// Bytes of a journal that make it roll over into an autosave: a second or two of replaying.
const MAX_JOURNAL_BYTES: u64 = 16 << 20;
/// Bytes of arrays in one record that are not written as text but kept by an autosave.
const MAX_RECORD_BYTES: usize = 4 << 20;
/// Between two records of a drag that goes on.
const DRAG_INTERVAL: Duration = Duration::from_secs(1);

/// What a journal's records are applied to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Base {
    /// The document's file, as long as it is the one that was read or written then.
    File { n_bytes: u64, modified_secs: u64, modified_nanos: u32 },
    /// An embedded style of the same version of the studio.
    Style(String),
    /// The autosave of the journal's number.
    Autosave,
}

impl Base {
    /// The document's file as it is now; `None` where it cannot be told from another.
    pub fn of_file(path: &Path) -> Option<Self> {
        let metadata = std::fs::metadata(path).ok()?;
        let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
        Some(Self::File {
            n_bytes: metadata.len(),
            modified_secs: modified.as_secs(),
            modified_nanos: modified.subsec_nanos(),
        })
    }
}

/// The first line of a journal.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    pub version: u32,
    /// Program and version that wrote it.
    pub made_by: String,
    pub base: Base,
    /// The document's file.
    pub path: Option<PathBuf>,
}

const JOURNAL_VERSION: u32 = 1;
const MADE_BY: &str = concat!("Lorelei ", env!("CARGO_PKG_VERSION"));

/// This run's journal, and what crashed runs left.
pub struct Recovery {
    folder: PathBuf,
    /// Runs that did not end: their files, newest run first.
    pub left: Vec<Left>,
    writer: Writer,
    /// The document that is kept, by its generation.
    generation: u64,
    /// What the next journal begins with; `None`: an autosave.
    base: Option<Base>,
    /// The number that the next journal gets.
    next: u32,
    /// The journal that records go to.
    open: Option<u32>,
    last_autosave: Instant,
    last_records: Instant,
    kept_state: Option<(u64, u64)>,
    /// Between two autosaves of unsaved changes.
    interval: Duration,
}

/// What one run left: its files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    pub files: Vec<PathBuf>,
}

impl Recovery {
    /// Look for files of earlier runs in a folder. Those of studios that still run are left alone.
    pub fn new(folder: PathBuf, interval: Duration) -> std::io::Result<Self> {
        std::fs::create_dir_all(&folder)?;
        let left = restore::left_in(&folder)?;
        Ok(Self {
            writer: Writer::start(&folder)?,
            folder,
            left,
            generation: 0,
            base: None,
            next: 0,
            open: None,
            last_autosave: Instant::now(),
            last_records: Instant::now(),
            kept_state: None,
            interval,
        })
    }

    /// Whether what was done should be asked for now: between steps, and now and then within a drag.
    pub fn wants_records(&self, is_dragging: bool) -> bool {
        !is_dragging || self.last_records.elapsed() >= DRAG_INTERVAL
    }

    /// Keep what was done to the document since the last call.
    pub fn keep(&mut self, document: &Document, records: &[Record]) {
        if document.is_none() {
            return;
        }
        let state = document.state();
        if self.generation != state.0 {
            self.forget_own();
            self.generation = state.0;
            // A document that was set aside and came back has changes that its base lacks.
            self.base = document.base.clone().filter(|_| !document.history.is_unsaved());
        }
        if !records.is_empty() {
            self.last_records = Instant::now();
            if !document.is_unsaved() {
                self.forget_own();
                self.base.clone_from(&document.base);
                return;
            }
            let is_large = records.iter().any(|record| {
                let mut n_bytes = 0;
                record.edit.visit_shared(&mut |_, size| n_bytes += size);
                n_bytes > MAX_RECORD_BYTES
            });
            if is_large {
                // What follows cannot be replayed without it: the old journal ends here.
                self.close();
            }
            if self.open.is_none()
                && !is_large
                && let Some(base) = self.base.take()
            {
                self.begin(base, document.path.clone());
            }
            match self.open {
                Some(_) => self.writer.send(Message::Append(records.to_vec())),
                None => self.autosave(document, Vec::new()),
            }
        }
        let is_due = self.last_autosave.elapsed() >= self.interval && self.kept_state != Some(state);
        let is_long = self.writer.n_bytes() > MAX_JOURNAL_BYTES;
        if document.is_unsaved() && (is_due || is_long) {
            self.autosave(document, Vec::new());
        }
    }

    /// Write the document as it is on a thread; what was done before is no longer needed once it is there,
    /// and neither are the files of `replaces`.
    fn autosave(&mut self, document: &Document, replaces: Vec<PathBuf>) {
        self.last_autosave = Instant::now();
        self.kept_state = Some(document.state());
        self.base = None;
        let number = self.begin(Base::Autosave, document.path.clone());
        self.writer.send(Message::Autosave { number, groom: Box::new(document.groom.clone()), replaces });
    }

    /// Write the document at once, where there is something to recover.
    pub fn keep_now(&mut self, document: &Document) {
        self.take_over(document, Vec::new());
    }

    /// A recovered document is kept under this run's name; what the crashed run left goes once it is.
    pub fn take_over(&mut self, document: &Document, replaces: Vec<PathBuf>) {
        self.keep(document, &[]);
        if document.is_unsaved() && !document.is_none() {
            self.autosave(document, replaces);
        }
    }

    fn begin(&mut self, base: Base, path: Option<PathBuf>) -> u32 {
        let number = self.next;
        self.next += 1;
        self.open = Some(number);
        let header = Header { version: JOURNAL_VERSION, made_by: MADE_BY.to_owned(), base, path };
        self.writer.send(Message::Begin { number, header });
        number
    }

    fn close(&mut self) {
        self.open = None;
        self.writer.send(Message::Close);
    }

    /// The document was saved or thrown away on purpose: nothing is to be recovered.
    pub fn forget_own(&mut self) {
        self.open = None;
        self.kept_state = None;
        self.writer.send(Message::Forget { before: self.next });
    }

    /// The document's file holds the document, as of now or as of a moment ago.
    pub fn saved(&mut self, document: &Document) {
        if document.is_unsaved() {
            // Steps came while it was saved: they are in no file.
            self.base = None;
            self.autosave(document, Vec::new());
        } else {
            self.forget_own();
            self.base.clone_from(&document.base);
        }
    }

    /// What crashed runs left was refused.
    pub fn forget_left(&mut self) {
        self.left.drain(..).flat_map(|left| left.files).for_each(|file| remove(&file));
    }

    /// Where a window that ends badly leaves its groom: offered like what a crash left, should nobody go on.
    pub fn file_for_loss(&self) -> PathBuf {
        self.folder.join("lost-gpu.lorelei")
    }

    /// Records that were handed to the system in this run.
    pub fn n_records(&self) -> u64 {
        self.writer.n_records()
    }

    /// Why steps are not kept any more, once.
    pub fn problem(&mut self) -> Option<String> {
        self.writer.problem()
    }

    /// The studio ends: with `is_well`, nothing is to be recovered. Returns when the files are gone.
    pub fn end(&mut self, is_well: bool) {
        if is_well {
            self.forget_own();
        }
        self.writer.finish();
    }
}

fn remove(path: &Path) {
    if let Err(why) = std::fs::remove_file(path)
        && why.kind() != std::io::ErrorKind::NotFound
    {
        log::warn!("{}: {why}", path.display());
    }
}

#[cfg(test)]
mod tests;
