//! The open groom with its history, its file, and whether it was changed since it was saved.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use lorelei_core::edit::Edit;
use lorelei_core::groom::Groom;
use lorelei_core::history::{History, Merge};

use super::recovery::Base;

/// One open document.
#[derive(Debug, Default)]
pub struct Document {
    pub groom: Groom,
    pub history: History,
    /// `None` until it was saved, or where it came from a file of another program.
    pub path: Option<PathBuf>,
    /// Where the groom is as it was when it was opened or saved last; `None`: in no file.
    pub base: Option<Base>,
    /// Numbers documents, so that a state number of one is never taken for another's; 0: none was opened yet.
    generation: u64,
    /// A recovered or imported document is worth saving though nothing was edited.
    never_saved: bool,
}

static N_DOCUMENTS: AtomicU64 = AtomicU64::new(0);

impl Document {
    /// A document of its own. `path` is the `.lorelei` file that it is in, if it is in one.
    pub fn new(groom: Groom, path: Option<PathBuf>, is_unsaved: bool) -> Self {
        let generation = 1 + N_DOCUMENTS.fetch_add(1, Ordering::Relaxed);
        let base = path.as_deref().filter(|_| !is_unsaved).and_then(Base::of_file);
        let mut history = History::default();
        history.record();
        Self { groom, history, path, base, generation, never_saved: is_unsaved }
    }

    /// Nothing was opened yet.
    pub fn is_none(&self) -> bool {
        self.generation == 0
    }

    /// Apply an edit that a panel made. A panel shows the groom as it is, so an edit that does not fit is
    /// a fault of the panel: it is logged and nothing changes.
    pub fn edit(&mut self, label: &str, edit: Edit, merge: Merge) {
        if let Err(why) = self.history.apply(&mut self.groom, label, edit, merge) {
            log::error!("`{label}` was left out: {why}");
        }
    }

    pub fn undo(&mut self) -> Option<String> {
        self.history.undo(&mut self.groom).map(str::to_owned)
    }

    /// Undo the last step as if it had never been: a drag was given up.
    pub fn take_back(&mut self) {
        self.history.take_back(&mut self.groom);
    }

    pub fn redo(&mut self) -> Option<String> {
        self.history.redo(&mut self.groom).map(str::to_owned)
    }

    pub fn go_to(&mut self, n_done: usize) {
        self.history.go_to(&mut self.groom, n_done);
    }

    /// Names the groom's content: the same pair, the same groom.
    pub fn state(&self) -> (u64, u64) {
        (self.generation, self.history.state())
    }

    pub fn is_unsaved(&self) -> bool {
        self.never_saved || self.history.is_unsaved()
    }

    /// The groom of `state` is now in the file.
    pub fn mark_saved(&mut self, state: (u64, u64), path: &Path) {
        if state.0 == self.generation {
            self.history.mark_saved(state.1);
            self.never_saved = false;
            self.path = Some(path.to_owned());
            self.base = Base::of_file(path);
        }
    }

    /// For the title bar and the file dialog.
    pub fn title(&self) -> String {
        match &self.path {
            Some(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            None => self.groom.name.clone(),
        }
    }
}
