//! What was done to a groom, as a list that can be written down and done again: what the crash journal and
//! macros are made of.
//!
//! A record holds the edit that was applied, for an undo the one that undid. So a list of records leads from
//! its first groom to its last without the history that it came from, and [`History::replay`] rebuilds of
//! that history what happened since. Records without edits for undo were rejected: the step may be older
//! than the list.
//!
//! In a journal file each record is a line, `LENGTH HASH RON`: a line that a crash or a power cut left
//! incomplete is noticed, and what is before it counts. RON writes the shortest text that reads back as the
//! same number, so nothing changes by a bit.
//!
//! [`History::replay`]: crate::history::History::replay

use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use crate::edit::Edit;
use crate::script::{Step, Work};

/// One change of the groom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub kind: RecordKind,
    /// Of the history's step.
    pub label: String,
    /// What was applied to the groom.
    pub edit: Edit,
}

/// What a change meant to the history.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordKind {
    /// A new step.
    Did,
    /// More of the step before: the same drag or stroke.
    Joined,
    Undid,
    Redid,
}

/// Add a record; within a drag only the last value counts.
pub(crate) fn put(records: &mut Vec<Record>, record: Record) {
    if record.kind == RecordKind::Joined
        && let Some(last) = records.last_mut()
        && matches!(last.kind, RecordKind::Did | RecordKind::Joined)
        && record.edit.overwrites(&last.edit)
    {
        last.edit = record.edit;
        return;
    }
    records.push(record);
}

/// Write a record as a line of a journal; returns its bytes.
pub fn write_line(out: &mut impl Write, record: &Record) -> io::Result<usize> {
    let record = Record { edit: record.edit.clone().with_named_heads(), ..record.clone() };
    let text = ron::to_string(&record).map_err(io::Error::other)?;
    let line = format!("{} {:016x} {text}\n", text.len(), hash(text.as_bytes()));
    out.write_all(line.as_bytes())?;
    Ok(line.len())
}

/// The records of a journal's lines, and whether all of it could be read: after a crash the last line may be
/// incomplete, and reading ends before the first that is.
pub fn read_lines(bytes: &[u8]) -> (Vec<Record>, bool) {
    let mut records = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let Some((record, after)) = read_line(rest) else { return (records, false) };
        records.push(record);
        rest = after;
    }
    (records, true)
}

fn read_line(bytes: &[u8]) -> Option<(Record, &[u8])> {
    // A length has 20 digits at most.
    let end = bytes.iter().take(21).position(|&b| b == b' ')?;
    let n_bytes: usize = std::str::from_utf8(&bytes[..end]).ok()?.parse().ok()?;
    let (sum, rest) = bytes[end + 1..].split_at_checked(17)?;
    let (text, rest) = rest.split_at_checked(n_bytes)?;
    let rest = rest.strip_prefix(b"\n")?;
    let expected = u64::from_str_radix(std::str::from_utf8(&sum[..16]).ok()?, 16).ok()?;
    if expected != hash(text) {
        return None;
    }
    let record = ron::from_str(std::str::from_utf8(text).ok()?).ok()?;
    Some((record, rest))
}

/// FNV-1a, 64 bits (Fowler, Noll and Vo): tells a torn line from a whole one.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// A macro that is being recorded: steps as they were done, without what was undone again.
#[derive(Debug, Clone, Default)]
pub struct Macro {
    steps: Vec<Recorded>,
    /// Steps `..n_done` were not undone.
    n_done: usize,
}

#[derive(Debug, Clone)]
struct Recorded {
    label: String,
    edits: Vec<Edit>,
    /// It began within the macro, so an undo takes all of it back.
    is_whole: bool,
}

impl Macro {
    pub fn add(&mut self, record: Record) {
        let Record { kind, label, edit } = record;
        let n_steps = self.steps.len();
        let last = self.n_done.checked_sub(1).map(|last| &mut self.steps[last]);
        match (kind, last) {
            (RecordKind::Undid, Some(last)) if last.is_whole => self.n_done -= 1,
            (RecordKind::Redid, _) if self.n_done < n_steps => self.n_done += 1,
            (RecordKind::Joined, Some(last)) => match last.edits.last_mut() {
                Some(before) if edit.overwrites(before) => *before = edit,
                Some(_) | None => last.edits.push(edit),
            },
            (RecordKind::Did, _) => self.push(label, edit, true),
            (RecordKind::Joined, None) => self.push(label, edit, false),
            // From before the macro: what it did to the groom belongs to the macro all the same.
            (RecordKind::Undid, _) => self.push(format!("Undo {label}"), edit, false),
            (RecordKind::Redid, _) => self.push(format!("Redo {label}"), edit, false),
        }
    }

    fn push(&mut self, label: String, edit: Edit, is_whole: bool) {
        self.steps.truncate(self.n_done);
        self.steps.push(Recorded { label, edits: vec![edit], is_whole });
        self.n_done += 1;
    }

    pub fn n_steps(&self) -> usize {
        self.n_done
    }

    /// The steps that were not undone, in order.
    pub fn into_steps(mut self) -> Vec<Step> {
        self.steps.truncate(self.n_done);
        let step = |Recorded { label, mut edits, .. }: Recorded| {
            let edit = if edits.len() == 1 { edits.remove(0) } else { Edit::Batch(edits) };
            Step { label, work: Work::Edit(edit) }
        };
        self.steps.into_iter().map(step).collect()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::edit::tests::{any_edit, small_groom};
    use crate::history::{History, Merge};

    fn record(kind: RecordKind, name: &str) -> Record {
        Record { kind, label: format!("call it {name}"), edit: Edit::SetName(name.to_owned()) }
    }

    proptest! {
        #[test]
        fn lines_read_back_and_a_torn_one_ends_them(edits in proptest::collection::vec(any_edit(), 1..6), cut in any::<prop::sample::Index>()) {
            let records: Vec<Record> =
                edits.into_iter().map(|edit| Record { kind: RecordKind::Did, label: "a\n\"b\"".to_owned(), edit }).collect();
            let mut bytes = Vec::new();
            let mut ends = vec![0];
            for record in &records {
                write_line(&mut bytes, record).unwrap();
                ends.push(bytes.len());
            }
            prop_assert_eq!(read_lines(&bytes), (records.clone(), true));
            let cut = cut.index(bytes.len());
            let n_whole = ends.iter().filter(|&&end| end <= cut).count() - 1;
            let (read, is_whole) = read_lines(&bytes[..cut]);
            prop_assert_eq!(&read[..], &records[..n_whole]);
            prop_assert_eq!(is_whole, ends.contains(&cut));
            let mut damaged = bytes.clone();
            damaged[cut] ^= 1;
            let (read, _) = read_lines(&damaged);
            prop_assert!(read.len() <= records.len() && read.iter().zip(&records).take(n_whole).all(|(a, b)| a == b));
        }
    }

    #[test]
    fn bytes_that_are_no_journal_give_nothing() {
        for bytes in [
            &b"x"[..],
            b"99999999999999999999 0123456789abcdef x\n",
            b"5 zz",
            b"18446744073709551615 0123456789abcdef x",
        ] {
            assert_eq!(read_lines(bytes), (Vec::new(), false));
        }
        assert_eq!(read_lines(b""), (Vec::new(), true));
    }

    #[test]
    fn within_a_drag_only_the_last_value_is_kept() {
        let mut records = Vec::new();
        put(&mut records, record(RecordKind::Did, "a"));
        put(&mut records, record(RecordKind::Joined, "b"));
        put(&mut records, record(RecordKind::Joined, "c"));
        put(&mut records, record(RecordKind::Undid, ""));
        put(&mut records, record(RecordKind::Joined, "d"));
        let kept: Vec<_> = records.iter().map(|r| (r.kind, r.edit.clone())).collect();
        let name = |name: &str| Edit::SetName(name.to_owned());
        assert_eq!(
            kept,
            [(RecordKind::Did, name("c")), (RecordKind::Undid, name("")), (RecordKind::Joined, name("d"))]
        );
    }

    proptest! {
        #[test]
        fn a_macro_leads_from_its_first_groom_to_its_last(events in proptest::collection::vec((any_edit(), 0_u8..5), 0..30), start in 0_usize..6) {
            let (mut groom, mut history) = (small_groom(), History::default());
            let mut recorder = Macro::default();
            let mut first = groom.clone();
            prop_assume!(start < events.len());
            for (n, (edit, event)) in events.into_iter().enumerate() {
                if n == start {
                    first = groom.clone();
                    history.record();
                }
                match event {
                    0 => drop(history.undo(&mut groom).map(str::to_owned)),
                    1 => drop(history.redo(&mut groom).map(str::to_owned)),
                    2 => drop(history.apply(&mut groom, "stroke", edit, Merge::Stroke(1))),
                    _ => drop(history.apply(&mut groom, "edit", edit, Merge::New)),
                }
                history.take_records().into_iter().for_each(|record| recorder.add(record));
            }
            let mut again = first;
            for step in recorder.into_steps() {
                let Work::Edit(edit) = step.work else { panic!("a recording is made of edits") };
                again.apply(edit).unwrap();
            }
            prop_assert_eq!(&again, &groom);
        }
    }
}
