//! The frames of a whole range, in the background: into memory, into a file, or both. What was cancelled or interrupted is
//! gone on with.

use std::path::Path;
use std::sync::Arc;

use lorelei_core::io::Watch;
use lorelei_core::motion::Movement;

use super::file::{Contents, FileError, Header, Writer};
use super::frames::Frames;
use super::key::key_of;
use super::solver::{On, SolverError};
use super::{Course, Run, Subject};

/// Why a range was not simulated.
#[derive(Debug, thiserror::Error)]
pub enum RangeError {
    #[error(transparent)]
    Solver(#[from] SolverError),
    #[error(transparent)]
    File(#[from] FileError),
}

/// Frames that belong to the inputs that a key stands for.
#[derive(Debug, Clone)]
pub struct Ranged {
    pub key: u128,
    pub frames: Frames,
    /// All frames of the range are there.
    pub is_whole: bool,
}

/// What a file of this movement begins with.
pub fn header_of(subject: &Subject, course: &Course, movement: &Movement, device: &str) -> Header {
    let layers = subject.hair.iter().map(|hair| hair.n_shown() as u32).collect();
    let Movement { fps, start, end, .. } = *movement;
    Header { key: key_of(subject, course, movement), fps, start, end, layers, device: device.to_owned() }
}

/// Simulate a range. In memory frames end where `budget` bytes do; without a file, so does the work.
pub fn simulate_range(
    on: On,
    subject: &Subject,
    course: &Course,
    movement: &Movement,
    budget: usize,
    path: Option<&Path>,
    watch: Watch<'_>,
) -> Result<Ranged, RangeError> {
    let movement = movement.bounded();
    let header = header_of(subject, course, &movement, &on.device());
    let opened = path.map(|path| Writer::open(path, &header)).transpose()?;
    let (mut writer, left) = opened.map_or((None, None), |(writer, left)| (Some(writer), left));
    let mut frames = Frames::new(movement.start);
    let mut run = Run::start(on, subject, course.clone(), &movement)?;
    let is_resumed = left.is_some_and(|left| take_up(left, &mut run, &mut frames, budget));
    if !is_resumed {
        let shot = run.shot()?;
        if let Some(writer) = &mut writer {
            writer.frame(run.frame_idx(), &shot)?;
        }
        frames.keep(run.frame_idx(), Arc::new(shot), budget);
    }
    let mut has_room = true;
    while run.frame_idx() < movement.end && !watch.cancelled() && (has_room || writer.is_some()) {
        run.next_frame()?;
        let shot = run.shot()?;
        if let Some(writer) = &mut writer
            && writer.frame(run.frame_idx(), &shot)?
        {
            writer.state(run.frame_idx(), &run.read_state()?)?;
        }
        has_room &= frames.keep(run.frame_idx(), Arc::new(shot), budget);
        watch.progress((run.frame_idx() - movement.start) as f32 / (movement.end - movement.start) as f32);
    }
    let is_whole = run.frame_idx() == movement.end;
    let state = run.read_state()?;
    if let Some(mut writer) = writer {
        writer.state(run.frame_idx(), &state)?;
        if is_whole {
            writer.finish()?;
        }
    }
    frames.keep_state(run.frame_idx(), state);
    Ok(Ranged { key: header.key, frames, is_whole: is_whole && has_room })
}

/// Go on where a file ends.
fn take_up(left: Contents, run: &mut Run, frames: &mut Frames, budget: usize) -> bool {
    let Some((frame_idx, state)) = left.state else { return false };
    if !run.go_on_from(frame_idx, &state) {
        return false;
    }
    for (frame_idx, shot) in left.shots {
        frames.keep(frame_idx, Arc::new(shot), budget);
    }
    true
}

/// The frames of a file that is whole, as many as fit into `budget` bytes.
pub fn open(path: &Path, budget: usize) -> Result<Ranged, FileError> {
    let Contents { header, shots, state, .. } = super::file::read(path)?;
    let mut frames = Frames::new(header.start);
    let mut is_whole = true;
    for (frame_idx, shot) in shots {
        is_whole &= frames.keep(frame_idx, Arc::new(shot), budget);
    }
    if let Some((frame_idx, state)) = state {
        frames.keep_state(frame_idx, state);
    }
    Ok(Ranged { key: header.key, frames, is_whole })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::atomic::{AtomicBool, Ordering};

    use lorelei_core::motion::Motion;

    use super::*;
    use crate::movement::run::tests::{shake, two_strands};

    fn movement() -> Movement {
        Movement { motion: Motion::Shake, fps: 50.0, start: 2, end: 300, ..Movement::default() }
    }

    fn range(path: Option<&Path>, budget: usize, watch: Watch<'_>) -> Ranged {
        simulate_range(On::Cpu, &two_strands(), &shake(), &movement(), budget, path, watch).unwrap()
    }

    fn same(a: &Frames, b: &Frames) -> bool {
        (2..=300).all(|frame_idx| a.get(frame_idx).is_some() && a.get(frame_idx) == b.get(frame_idx))
    }

    #[test]
    fn a_file_gives_back_the_very_frames_and_an_interrupted_one_is_gone_on_with() {
        let folder = tempfile::tempdir().unwrap();
        let whole = range(None, usize::MAX, Watch::default());
        assert!(whole.is_whole && whole.frames.n_frames() == 299);
        let path = folder.path().join("shake.frames");
        // Cancelled half way, and cut off in the middle of a record besides.
        let cancel = AtomicBool::new(false);
        let on_progress = |share: f32| cancel.store(share > 0.5, Ordering::Relaxed);
        let half = range(Some(&path), usize::MAX, Watch { on_progress: Some(&on_progress), cancel: Some(&cancel) });
        assert!(!half.is_whole && half.frames.n_frames() < 200 && !path.exists());
        let part = folder.path().join("shake.frames.part");
        let mut bytes = std::fs::read(&part).unwrap();
        bytes.truncate(bytes.len() - 7);
        std::fs::write(&part, bytes).unwrap();
        let n_steps = Cell::new(0);
        let count = |_: f32| n_steps.set(n_steps.get() + 1);
        let rest = range(Some(&path), usize::MAX, Watch { on_progress: Some(&count), cancel: None });
        assert!(n_steps.get() < 250, "{} frames were simulated, though some were there", n_steps.get());
        assert!(rest.is_whole && path.exists() && !part.exists());
        let opened = open(&path, usize::MAX).unwrap();
        assert!(same(&whole.frames, &rest.frames) && same(&whole.frames, &opened.frames));
        assert_eq!((opened.key, opened.is_whole), (whole.key, true));
        let n_bytes = std::fs::metadata(&path).unwrap().len();
        assert!((n_bytes as usize) < whole.frames.n_bytes(), "{n_bytes} of {}", whole.frames.n_bytes());
    }

    #[test]
    fn memory_ends_where_its_budget_does_and_files_that_are_none_are_refused() {
        let most = range(None, 20_000, Watch::default());
        assert!(!most.is_whole && most.frames.n_bytes() <= 20_000 && most.frames.n_frames() > 10);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.frames");
        std::fs::write(&path, b"LRLEFRMS\x09\0\0\0").unwrap();
        assert!(matches!(open(&path, 0), Err(FileError::TooNew { version: 9, .. })));
        std::fs::write(&path, b"something else").unwrap();
        assert!(matches!(open(&path, 0), Err(FileError::WrongKind { .. })));
        std::fs::write(&path, b"LRLEFRMS\x01\0\0\0\x05").unwrap();
        assert!(matches!(open(&path, 0), Err(FileError::Damaged { .. })));
        assert!(matches!(open(&folder.path().join("none"), 0), Err(FileError::Io { .. })));
    }

    #[test]
    fn what_changes_frames_changes_the_key_and_only_that() {
        let (subject, course) = (two_strands(), shake());
        let key = key_of(&subject, &course, &movement());
        assert_eq!(key, key_of(&two_strands(), &shake(), &Movement { end: 9, ..movement() }));
        let mut stiffer = shake();
        stiffer.settings.gravity = 0.0;
        let other = Course { motion: Motion::Nod, ..shake() };
        for changed in [
            key_of(&subject, &stiffer, &movement()),
            key_of(&subject, &other, &movement()),
            key_of(&subject, &course, &Movement { fps: 24.0, ..movement() }),
            key_of(&Subject { hair: Vec::new(), field: None }, &course, &movement()),
        ] {
            assert_ne!(changed, key);
        }
    }
}
