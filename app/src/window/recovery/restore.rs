//! From what a crashed run left to the document that it had: a base, and the journal's records replayed.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use lorelei_core::groom::Groom;
use lorelei_core::history::History;
use lorelei_core::io::Watch;
use lorelei_core::record;

use super::{Base, Header, JOURNAL_VERSION, Left, MADE_BY, remove};
use crate::{open, script};

/// A document that a crashed run had.
#[derive(Debug)]
pub struct Restored {
    pub groom: Groom,
    /// What was done since the base, so that it can be undone.
    pub history: History,
    /// The document's file.
    pub path: Option<PathBuf>,
    pub notes: Vec<String>,
}

pub(super) fn journal_file(folder: &Path, process: u32, number: u32) -> PathBuf {
    folder.join(format!("{process}-{number}.journal"))
}

pub(super) fn autosave_file(folder: &Path, process: u32, number: u32) -> PathBuf {
    folder.join(format!("{process}-{number}.lorelei"))
}

/// Process and number of a file of ours. Files of one number only are of older studios.
fn numbers_of(path: &Path) -> Option<(u32, u32)> {
    let stem = path.file_stem()?.to_str()?;
    let (process, number) = stem.split_once('-').unwrap_or((stem, "0"));
    Some((process.parse().ok()?, number.parse().ok()?))
}

/// What ended runs left in a folder, newest first. Temporary files of theirs are removed.
pub(super) fn left_in(folder: &Path) -> io::Result<Vec<Left>> {
    let mut runs: BTreeMap<Option<u32>, (Option<SystemTime>, Vec<PathBuf>)> = BTreeMap::new();
    for entry in std::fs::read_dir(folder)?.flatten() {
        let path = entry.path();
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        if extension == "tmp" {
            let process =
                path.file_stem().and_then(|stem| stem.to_str()?.rsplit('.').next()?.split('-').next()?.parse().ok());
            if !process.is_some_and(is_running) {
                remove(&path);
            }
            continue;
        }
        let process = numbers_of(&path).map(|(process, _)| process);
        if !matches!(extension, "lorelei" | "journal") || process.is_some_and(is_running) {
            continue;
        }
        let modified = entry.metadata().and_then(|metadata| metadata.modified()).ok();
        let (newest, files) = runs.entry(process).or_default();
        *newest = (*newest).max(modified);
        files.push(path);
    }
    let mut runs: Vec<_> = runs.into_values().collect();
    runs.sort();
    Ok(runs.into_iter().rev().map(|(_, files)| Left { files }).collect())
}

/// Remove what this process kept: another went on with its document.
pub fn forget_own_run(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)?.flatten() {
        if numbers_of(&entry.path()).is_some_and(|(process, _)| process == std::process::id()) {
            remove(&entry.path());
        }
    }
    Ok(())
}

/// Whether a process still runs; of this one it is asked as well.
fn is_running(process: u32) -> bool {
    process == std::process::id() || cfg!(target_os = "linux") && Path::new(&format!("/proc/{process}")).exists()
}

/// Rebuild the document that a run had: from its newest base that is complete.
pub fn restore(left: &Left, watch: Watch<'_>) -> Result<Restored, String> {
    let mut numbers: Vec<u32> = left.files.iter().filter_map(|file| Some(numbers_of(file)?.1)).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let mut problems = Vec::new();
    for number in numbers.into_iter().rev() {
        match restore_number(left, number, watch) {
            Ok(restored) => return Ok(restored),
            Err(why) => problems.push(why),
        }
    }
    // A window that lost its GPU leaves a groom without a number.
    for file in left.files.iter().filter(|file| numbers_of(file).is_none()) {
        match open::document(file, watch) {
            Ok((groom, notes)) => return Ok(Restored { groom, history: History::default(), path: None, notes }),
            Err(why) => problems.push(why.to_string()),
        }
    }
    problems.push("The files are kept: move them elsewhere to look into them".to_owned());
    Err(problems.join("\n"))
}

fn restore_number(left: &Left, number: u32, watch: Watch<'_>) -> Result<Restored, String> {
    let file = |extension: &str| {
        let is_it = |file: &&PathBuf| {
            file.extension().is_some_and(|e| e == extension) && numbers_of(file).is_some_and(|(_, n)| n == number)
        };
        left.files.iter().find(is_it)
    };
    let read = |path: &Path| open::document(path, watch).map_err(|why| why.to_string());
    let Some(journal) = file("journal") else {
        let autosave = file("lorelei").ok_or("no file of that number")?;
        let (groom, notes) = read(autosave)?;
        return Ok(Restored { groom, history: History::default(), path: None, notes });
    };
    let bytes = std::fs::read(journal).map_err(|why| format!("{}: {why}", journal.display()))?;
    let failed = |why: &str| format!("{}: {why}", journal.display());
    let end = bytes.iter().position(|&b| b == b'\n').ok_or_else(|| failed("was cut off at once"))?;
    let header = std::str::from_utf8(&bytes[..end]).ok().and_then(|text| ron::from_str::<Header>(text).ok());
    let header = header.filter(|header| header.version == JOURNAL_VERSION);
    let header = header.ok_or_else(|| failed("is of another version of Lorelei"))?;
    let (mut groom, mut notes) = match &header.base {
        Base::Autosave => read(file("lorelei").ok_or_else(|| failed("its autosave was not complete"))?)?,
        Base::Style(key) if header.made_by == MADE_BY => {
            (lorelei_assets::hairstyle(key).ok_or_else(|| failed("its style is not embedded"))?, Vec::new())
        }
        Base::Style(_) => return Err(failed("is of another version of Lorelei, whose style may be another")),
        Base::File { .. } => {
            let path = header.path.as_deref().ok_or_else(|| failed("does not say its document"))?;
            if Base::of_file(path).as_ref() != Some(&header.base) {
                return Err(format!("{} was changed or removed since", path.display()));
            }
            read(path)?
        }
    };
    let (records, is_whole) = record::read_lines(&bytes[end + 1..]);
    if !is_whole {
        notes.push("The very last step was not complete when the studio ended: it is missing".to_owned());
    }
    let mut history = History::default();
    for (n, mut record) in records.into_iter().enumerate() {
        script::complete(&mut record.edit);
        let label = record.label.clone();
        if let Err(why) = history.replay(&mut groom, record) {
            notes.push(format!("Step {} (`{label}`) and what came after it are missing: {why}", n + 1));
            break;
        }
    }
    Ok(Restored { groom, history, path: header.path, notes })
}
