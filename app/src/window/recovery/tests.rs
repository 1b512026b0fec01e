//! What a run leaves when it dies at any moment leads back to its document, bit for bit.

use std::time::Duration;

use lorelei_core::document;
use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, Layer};
use lorelei_core::history::Merge;
use lorelei_core::io::Watch;
use lorelei_core::look::Look;
use lorelei_core::strands::Strands;

use super::*;

/// A folder in which a run of ours is found as that of another process, which is dead: no process has this
/// id, since Linux ids end at 2^22.
fn as_left(folder: &Path) -> Vec<Left> {
    let copy = folder.with_extension("copy");
    std::fs::remove_dir_all(&copy).ok();
    std::fs::create_dir_all(&copy).unwrap();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().into_string().unwrap();
        let name = name.replace(&format!("{}-", std::process::id()), "4294967295-");
        std::fs::copy(entry.path(), copy.join(name)).unwrap();
    }
    restore::left_in(&copy).unwrap()
}

fn exposure(exposure: f32) -> Edit {
    Edit::SetLook(Box::new(Look { exposure, ..Look::default() }))
}

fn layer(n_points: usize) -> Box<Layer> {
    let mut strands = Strands::default();
    strands.push(&(0..n_points).map(|k| glam::Vec3::new(k as f32, 0.1, -0.0)).collect::<Vec<_>>());
    Box::new(Layer::from_strands("long", strands))
}

/// A document in a file, with its recovery.
struct Run {
    _folder: tempfile::TempDir,
    recovery: Recovery,
    document: Document,
}

impl Run {
    fn new(interval: Duration) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("groom.lorelei");
        let groom = Groom { layers: vec![*layer(3)], ..Groom::default() };
        document::save(&groom, &file).unwrap();
        let recovery = Recovery::new(folder.path().join("recovery"), interval).unwrap();
        let mut run = Self { recovery, document: Document::new(groom, Some(file), false), _folder: folder };
        run.frame();
        run
    }

    fn frame(&mut self) {
        let records = self.document.history.take_records();
        self.recovery.keep(&self.document, &records);
    }

    fn edit(&mut self, edit: Edit) {
        self.document.edit("edit", edit, Merge::New);
        self.frame();
    }

    /// What is offered once the process is dead.
    fn left(&mut self) -> Vec<Left> {
        // Everything that was handed over is written, then the thread starts anew.
        self.recovery.end(false);
        self.recovery.writer = Writer::start(&self.recovery.folder).unwrap();
        as_left(&self.recovery.folder)
    }

    fn assert_restores(&mut self) -> Restored {
        let left = self.left();
        assert_eq!(left.len(), 1);
        let restored = restore(&left[0], Watch::default()).unwrap();
        assert!(restored.groom == self.document.groom);
        assert_eq!(ron::to_string(&restored.groom).unwrap(), ron::to_string(&self.document.groom).unwrap());
        restored
    }
}

#[test]
fn every_step_since_the_file_was_saved_comes_back_with_its_undo() {
    let mut run = Run::new(Duration::from_hours(1));
    run.edit(exposure(1.0));
    run.edit(Edit::AddLayer { layer_idx: 1, layer: layer(5) });
    run.edit(Edit::SetName("another".to_owned()));
    run.document.undo();
    run.document.undo();
    run.frame();
    run.document.redo();
    run.edit(exposure(2.0));
    run.document.go_to(1);
    run.frame();
    run.document.go_to(3);
    run.frame();
    let start = Instant::now();
    while run.recovery.n_records() <= 6 {
        assert!(start.elapsed() < Duration::from_secs(30), "every step and every undo is a record");
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut restored = run.assert_restores();
    assert_eq!(restored.path, run.document.path);
    assert_eq!(restored.notes, Vec::<String>::new());
    assert_eq!(restored.history.labels().len(), 3);
    // No autosave was needed for any of it.
    assert!(!run.recovery.folder.join(format!("{}-0.lorelei", std::process::id())).exists());
    restored.history.go_to(&mut restored.groom, 0);
    run.document.go_to(0);
    assert!(restored.groom == run.document.groom);
}

#[test]
fn a_step_that_is_too_large_and_a_journal_that_is_too_long_become_autosaves() {
    let mut run = Run::new(Duration::from_hours(1));
    run.edit(exposure(1.0));
    let n_points = MAX_RECORD_BYTES / 12 + 1;
    run.edit(Edit::AddLayer { layer_idx: 1, layer: layer(n_points) });
    run.edit(exposure(2.0));
    let restored = run.assert_restores();
    assert_eq!(restored.history.labels().len(), 1, "what came after the autosave");
    // Undoing it is as large.
    run.document.go_to(0);
    run.frame();
    run.edit(exposure(3.0));
    run.assert_restores();
}

#[test]
fn an_autosave_that_was_not_complete_leaves_the_base_before_it() {
    let mut run = Run::new(Duration::from_hours(1));
    run.edit(exposure(1.0));
    run.left();
    // The next autosave has begun: its journal is there, its document is not; steps go to both.
    run.recovery.end(false);
    let folder = run.recovery.folder.clone();
    let process = std::process::id();
    std::fs::copy(restore::journal_file(&folder, process, 0), restore::journal_file(&folder, process, 1)).unwrap();
    let header = Header { version: JOURNAL_VERSION, made_by: MADE_BY.to_owned(), base: Base::Autosave, path: None };
    std::fs::write(restore::journal_file(&folder, process, 1), format!("{}\n", ron::to_string(&header).unwrap()))
        .unwrap();
    run.recovery.writer = Writer::start(&folder).unwrap();
    run.assert_restores();
}

#[test]
fn a_torn_last_record_is_told_and_the_others_count() {
    let mut run = Run::new(Duration::from_hours(1));
    run.edit(exposure(1.0));
    run.edit(exposure(2.0));
    run.left();
    let journal = restore::journal_file(&run.recovery.folder, std::process::id(), 0);
    let mut bytes = std::fs::read(&journal).unwrap();
    bytes.truncate(bytes.len() - 7);
    std::fs::write(&journal, bytes).unwrap();
    let left = run.left();
    let restored = restore(&left[0], Watch::default()).unwrap();
    assert_eq!(restored.groom.look.exposure, 1.0);
    assert!(restored.notes[0].contains("last step"), "{:?}", restored.notes);
}

#[test]
fn nothing_is_left_where_nothing_would_be_lost() {
    let mut run = Run::new(Duration::from_hours(1));
    run.frame();
    assert_eq!(run.left(), []);
    // Undone to what is in the file.
    run.edit(exposure(1.0));
    run.document.undo();
    run.frame();
    assert_eq!(run.left(), []);
    // Saved.
    run.edit(exposure(2.0));
    let path = run.document.path.clone().unwrap();
    document::save(&run.document.groom, &path).unwrap();
    run.document.mark_saved(run.document.state(), &path);
    run.recovery.saved(&run.document);
    assert_eq!(run.left(), []);
    // And steps after that stand on the file as it is now.
    run.edit(exposure(3.0));
    run.assert_restores();
    // Which somebody else then changes.
    document::save(&Groom::default(), &path).unwrap();
    let left = run.left();
    let why = restore(&left[0], Watch::default()).unwrap_err();
    assert!(why.contains("changed or removed"), "{why}");
    // Ended well.
    run.recovery.end(true);
    assert_eq!(as_left(&run.recovery.folder), []);
}

#[test]
fn steps_that_came_while_the_document_was_saved_are_kept() {
    let mut run = Run::new(Duration::from_hours(1));
    run.edit(exposure(1.0));
    let (state, path) = (run.document.state(), run.document.path.clone().unwrap());
    document::save(&run.document.groom, &path).unwrap();
    run.edit(exposure(2.0));
    run.document.mark_saved(state, &path);
    run.recovery.saved(&run.document);
    run.edit(exposure(3.0));
    run.assert_restores();
}

#[test]
fn a_document_in_no_file_is_autosaved_and_an_embedded_style_stands_for_itself() {
    for style in [None, Some("bob")] {
        let mut run = Run::new(Duration::from_hours(1));
        run.document = Document::new(lorelei_assets::hairstyle("bob").unwrap(), None, style.is_none());
        run.document.base = style.map(|key| Base::Style(key.to_owned()));
        run.frame();
        run.edit(exposure(1.0));
        run.edit(exposure(2.0));
        run.assert_restores();
        let autosave = run.recovery.folder.join(format!("{}-0.lorelei", std::process::id()));
        assert_eq!(autosave.exists(), style.is_none());
    }
}

#[test]
fn what_older_studios_and_dead_runs_left_is_offered_newest_first() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    document::save(&Groom::default(), &file("4294967295.lorelei")).unwrap();
    document::save(&Groom::default(), &file("lost-gpu.lorelei")).unwrap();
    std::fs::write(file(&format!("{}-0.lorelei", std::process::id())), b"x").unwrap();
    std::fs::write(file(".4294967294-1.lorelei.4294967294-0.tmp"), b"x").unwrap();
    let mut recovery = Recovery::new(folder.path().to_owned(), Duration::ZERO).unwrap();
    assert!(!file(".4294967294-1.lorelei.4294967294-0.tmp").exists());
    let files: Vec<PathBuf> = recovery.left.iter().flat_map(|left| left.files.clone()).collect();
    assert_eq!(files.len(), 2, "{files:?}");
    for left in &recovery.left {
        restore(left, Watch::default()).unwrap();
    }
    recovery.forget_left();
    assert!(!file("4294967295.lorelei").exists() && file(&format!("{}-0.lorelei", std::process::id())).exists());
    recovery.end(true);
}
