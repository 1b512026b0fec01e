//! The contents of a folder as the file dialog lists them, read on a thread so that a slow disk blocks nothing.

use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::SystemTime;

/// One file or folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    pub name: String,
    pub path: PathBuf,
    pub is_folder: bool,
    pub n_bytes: u64,
    pub modified: Option<SystemTime>,
}

/// By what the list is sorted. Folders always come first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    Name,
    Size,
    Modified,
}

/// A listing that is being read or was read.
#[derive(Debug)]
pub enum Listing {
    Reading(mpsc::Receiver<Result<Vec<Entry>, String>>),
    Read(Vec<Entry>),
    Failed(String),
}

impl Listing {
    /// Start to read a folder; `on_done` is called from the thread when there is something to show.
    pub fn start(folder: &Path, on_done: impl FnOnce() + Send + 'static) -> Self {
        let folder = folder.to_owned();
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            // The dialog may have moved on to another folder: then nobody listens.
            let _ = sender.send(read(&folder));
            on_done();
        });
        Self::Reading(receiver)
    }

    /// Take over what the thread has read.
    pub fn poll(&mut self) {
        let Self::Reading(receiver) = self else { return };
        match receiver.try_recv() {
            Ok(Ok(entries)) => *self = Self::Read(entries),
            Ok(Err(why)) => *self = Self::Failed(why),
            Err(mpsc::TryRecvError::Empty) => {}
            Err(mpsc::TryRecvError::Disconnected) => *self = Self::Failed("the folder could not be read".to_owned()),
        }
    }
}

fn read(folder: &Path) -> Result<Vec<Entry>, String> {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let entry_of = |entry: std::fs::DirEntry| {
        let path = entry.path();
        // Follows links: a link to a folder opens as one. A dangling link is left out.
        let metadata = std::fs::metadata(&path).ok()?;
        Some(Entry {
            name: entry.file_name().to_string_lossy().into_owned(),
            is_folder: metadata.is_dir(),
            n_bytes: metadata.len(),
            modified: metadata.modified().ok(),
            path,
        })
    };
    Ok(entries.flatten().filter_map(entry_of).collect())
}

/// Entries to show: no hidden ones, only the wanted extensions, folders first.
pub fn shown<'a>(
    entries: &'a [Entry],
    extensions: &[String],
    show_hidden: bool,
    order: Order,
    is_descending: bool,
) -> Vec<&'a Entry> {
    let is_wanted = |entry: &&Entry| {
        (show_hidden || !entry.name.starts_with('.'))
            && (entry.is_folder || extensions.is_empty() || has_extension(&entry.path, extensions))
    };
    let mut shown: Vec<&Entry> = entries.iter().filter(is_wanted).collect();
    shown.sort_by(|a, b| {
        let by_name = || a.name.to_lowercase().cmp(&b.name.to_lowercase());
        let ordering = match order {
            Order::Name => by_name(),
            Order::Size => a.n_bytes.cmp(&b.n_bytes).then_with(by_name),
            Order::Modified => a.modified.cmp(&b.modified).then_with(by_name),
        };
        let ordering = if is_descending { ordering.reverse() } else { ordering };
        b.is_folder.cmp(&a.is_folder).then(ordering)
    });
    shown
}

/// Whether a path ends in one of the extensions, in any case.
pub fn has_extension(path: &Path, extensions: &[String]) -> bool {
    let Some(extension) = path.extension() else { return false };
    let extension = extension.to_string_lossy().to_lowercase();
    extensions.contains(&extension)
}

/// A size as people read it.
pub fn size_text(n_bytes: u64) -> String {
    match n_bytes {
        n if n < 1 << 10 => format!("{n} B"),
        n if n < 1 << 20 => format!("{:.1} KiB", n as f64 / 1024.0),
        n if n < 1 << 30 => format!("{:.1} MiB", n as f64 / f64::from(1 << 20)),
        n => format!("{:.2} GiB", n as f64 / f64::from(1 << 30)),
    }
}

/// `2026-11-22 07:06`, in UTC.
pub fn date_text(time: SystemTime) -> String {
    let Ok(since) = time.duration_since(SystemTime::UNIX_EPOCH) else { return String::new() };
    let minutes = since.as_secs() / 60;
    let (year, month, day) = civil_from_days((minutes / 1440) as i64);
    format!("{year:04}-{month:02}-{day:02} {:02}:{:02}", minutes / 60 % 24, minutes % 60)
}

/// Year, month and day of a number of days since 1970-01-01, in the proleptic Gregorian calendar.
/// Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", civil_from_days.
fn civil_from_days(days: i64) -> (i64, i64, i64) {
    let z = days + 719_468;
    let era = z.div_euclid(146_097);
    let day_of_era = z.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    (year_of_era + era * 400 + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn entry(name: &str, is_folder: bool, n_bytes: u64) -> Entry {
        Entry { name: name.to_owned(), path: PathBuf::from(name), is_folder, n_bytes, modified: None }
    }

    #[test]
    fn folders_come_first_and_only_wanted_files_are_shown() {
        let entries = [
            entry("b.hair", false, 5),
            entry("z", true, 0),
            entry("A.HAIR", false, 9),
            entry("c.png", false, 1),
            entry(".git", true, 0),
        ];
        let names = |order, is_descending| -> Vec<&str> {
            let shown = shown(&entries, &["hair".to_owned()], false, order, is_descending);
            shown.iter().map(|entry| entry.name.as_str()).collect()
        };
        assert_eq!(names(Order::Name, false), ["z", "A.HAIR", "b.hair"]);
        assert_eq!(names(Order::Size, false), ["z", "b.hair", "A.HAIR"]);
        assert_eq!(names(Order::Name, true), ["z", "b.hair", "A.HAIR"]);
    }

    #[test]
    fn dates_are_right_at_leap_days_and_year_ends() {
        let at = |secs| date_text(SystemTime::UNIX_EPOCH + Duration::from_secs(secs));
        assert_eq!(at(0), "1970-01-01 00:00");
        assert_eq!(at(951_782_400), "2000-02-29 00:00");
        assert_eq!(at(1_798_761_599), "2026-12-31 23:59");
    }
}
