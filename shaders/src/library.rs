//! Every WGSL file by its stem: embedded in the program, or read from a folder and polled while developing.
//!
//! Polling modification times was chosen over a file-system watcher: some thirty files cost microseconds, and there
//! is no thread, no queue of events and no editor whose way of saving is missed.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::draw::{Draw, DrawDescriptor};
use crate::error::ShaderError;
use crate::gpu::Gpu;
use crate::kernel::Kernel;
use crate::link;

const EMBEDDED: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// What is chosen when a shader is linked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Link<'a> {
    /// `#import lorelei::NAME` means this file: `Slot("shadow", "shadow_off")`.
    Slot(&'a str, &'a str),
    /// `#ifdef NAME` holds.
    Def(&'a str),
    /// `#if NAME == 3`, and `#{NAME}` is replaced by it.
    DefU32(&'a str, u32),
}

/// Sources of shaders. A clone is the same library.
#[derive(Debug, Clone)]
pub struct ShaderLibrary {
    state: Arc<Mutex<State>>,
}

#[derive(Debug)]
struct State {
    sources: Arc<BTreeMap<String, Arc<str>>>,
    generation: u64,
    folder: Option<PathBuf>,
    stamps: BTreeMap<PathBuf, SystemTime>,
}

impl ShaderLibrary {
    /// The files as they were when the program was built.
    pub fn embedded() -> Self {
        Self::from_sources(EMBEDDED)
    }

    /// Files given as (stem, text), for tests and tools.
    pub fn from_sources(sources: &[(&str, &str)]) -> Self {
        let sources = sources.iter().map(|&(stem, text)| (stem.to_owned(), Arc::from(text))).collect();
        Self::new(State { sources: Arc::new(sources), generation: 0, folder: None, stamps: BTreeMap::new() })
    }

    /// The same files as they are now and one more, for tests and tools.
    #[must_use]
    pub fn with_file(&self, stem: &str, text: &str) -> Self {
        let mut sources = (*self.sources()).clone();
        sources.insert(stem.to_owned(), Arc::from(text));
        Self::new(State { sources: Arc::new(sources), generation: 0, folder: None, stamps: BTreeMap::new() })
    }

    /// The files of a folder, read again by [`ShaderLibrary::poll`] when they change.
    pub fn watching(folder: &Path) -> Result<Self, ShaderError> {
        let (sources, stamps) = read_folder(folder)?;
        Ok(Self::new(State { sources: Arc::new(sources), generation: 0, folder: Some(folder.to_owned()), stamps }))
    }

    /// Whether files are watched: only then [`ShaderLibrary::poll`] can find a change.
    pub fn is_watching(&self) -> bool {
        self.state().folder.is_some()
    }

    fn new(state: State) -> Self {
        Self { state: Arc::new(Mutex::new(state)) }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Look for changed files; call once a frame while developing. True where something changed. Embedded libraries
    /// never change.
    pub fn poll(&self) -> Result<bool, ShaderError> {
        let mut state = self.state();
        let Some(folder) = state.folder.clone() else { return Ok(false) };
        if stamps_of(&folder)? == state.stamps {
            return Ok(false);
        }
        let (sources, stamps) = read_folder(&folder)?;
        state.stamps = stamps;
        if *state.sources == sources {
            return Ok(false);
        }
        state.sources = Arc::new(sources);
        state.generation += 1;
        Ok(true)
    }

    /// Grows with every change of a source; see [`Hot`](crate::Hot).
    pub fn generation(&self) -> u64 {
        self.state().generation
    }

    /// Stems of all files, sorted.
    pub fn files(&self) -> Vec<String> {
        self.state().sources.keys().cloned().collect()
    }

    pub(crate) fn sources(&self) -> Arc<BTreeMap<String, Arc<str>>> {
        Arc::clone(&self.state().sources)
    }

    /// Link a compute entry point of a file into a pipeline. `overrides` sets pipeline-overridable constants by name.
    pub fn kernel(
        &self,
        gpu: &Gpu,
        file: &str,
        entry: &str,
        overrides: &[(&str, f64)],
        links: &[Link<'_>],
    ) -> Result<Kernel, ShaderError> {
        Kernel::new(gpu, &link::link(&self.sources(), file, links)?, entry, overrides)
    }

    /// Link the vertex and fragment entry points of a file into a render pipeline.
    pub fn draw(&self, gpu: &Gpu, file: &str, descriptor: &DrawDescriptor<'_>) -> Result<Draw, ShaderError> {
        Draw::new(gpu, &link::link(&self.sources(), file, descriptor.links)?, descriptor)
    }

    /// Link and validate without a device: the names of the entry points.
    pub fn validate(&self, file: &str, links: &[Link<'_>]) -> Result<Vec<String>, ShaderError> {
        let linked = link::link(&self.sources(), file, links)?;
        Ok(linked.module.entry_points.iter().map(|entry| entry.name.clone()).collect())
    }

    /// The import paths a file needs and no file defines: its slots, without `lorelei::`.
    pub fn slots_of(&self, file: &str) -> Result<Vec<String>, ShaderError> {
        link::slots_of(&self.sources(), file)
    }

    /// Stems of the files that say that they can stand in for a slot.
    pub fn files_for_slot(&self, slot: &str) -> Vec<String> {
        link::files_for_slot(&self.sources(), slot)
    }
}

fn folder_error(folder: &Path, error: &std::io::Error) -> ShaderError {
    ShaderError::Folder { folder: folder.display().to_string(), message: error.to_string() }
}

fn stamps_of(folder: &Path) -> Result<BTreeMap<PathBuf, SystemTime>, ShaderError> {
    let describe = |error: std::io::Error| folder_error(folder, &error);
    let mut stamps = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(describe)? {
        let path = entry.map_err(describe)?.path();
        if path.extension().is_none_or(|extension| extension != "wgsl") {
            continue;
        }
        // An editor may be replacing the file right now: it is there at the next poll.
        let Ok(stamp) = std::fs::metadata(&path).and_then(|metadata| metadata.modified()) else { continue };
        stamps.insert(path, stamp);
    }
    Ok(stamps)
}

type Folder = (BTreeMap<String, Arc<str>>, BTreeMap<PathBuf, SystemTime>);

fn read_folder(folder: &Path) -> Result<Folder, ShaderError> {
    let stamps = stamps_of(folder)?;
    let mut sources = BTreeMap::new();
    for path in stamps.keys() {
        let Some(stem) = path.file_stem() else { continue };
        let text = std::fs::read_to_string(path).map_err(|error| folder_error(path, &error))?;
        sources.insert(stem.to_string_lossy().into_owned(), Arc::from(text));
    }
    Ok((sources, stamps))
}
