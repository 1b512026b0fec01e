//! Undo and redo: a line of labelled steps, each holding the edit that crosses it.
//!
//! A step keeps one edit: while it is done, the edit that undoes it; while it is undone, the edit that does
//! it again. Crossing it swaps the two, since [`Groom::apply`] returns the inverse. A drag of a slider or a
//! stroke of a brush is one step: see [`Merge`].
//!
//! What happens to the groom can be written down meanwhile, crossings included: see [`History::record`].

use std::collections::HashSet;

use crate::edit::{Edit, EditError};
use crate::groom::Groom;
use crate::record::{Record, RecordKind, put};

/// Steps kept at most.
const MAX_STEPS: usize = 2000;
/// What steps may keep alive beside the groom itself where nobody set another limit: a gigabyte, some
/// hundred strokes over a map of 1024 x 1024 or thousand states of a hair mesh.
const MAX_BYTES: usize = 1 << 30;

/// Whether an edit goes on with the step before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Merge {
    /// A step of its own.
    New,
    /// One of many in a continuous drag: joins the last step where that was the same drag and wrote the
    /// same thing. The number names the drag, and [`History::end_drag`] closes it.
    Drag(u64),
    /// One of many in a stroke: joins the last step where that was the same stroke, whatever it wrote.
    /// The number names the stroke, and [`History::end_drag`] closes it.
    Stroke(u64),
}

#[derive(Debug, Clone)]
struct Step {
    label: String,
    edit: Edit,
    /// What state the groom is in after the step.
    state: u64,
    /// The drag or stroke that may still go on.
    open: Merge,
}

/// The line of steps and where on it the groom stands.
#[derive(Debug, Clone)]
pub struct History {
    steps: Vec<Step>,
    /// Steps `..n_done` are in the groom.
    n_done: usize,
    /// State before the first step that is kept.
    base_state: u64,
    last_state: u64,
    saved_state: u64,
    /// What all steps keep alive, and may.
    n_bytes: usize,
    max_bytes: usize,
    /// What was done since it was last asked; `None`: nobody asks.
    records: Option<Vec<Record>>,
    /// Where in `records` those begin that are held back.
    held_from: Option<usize>,
}

impl Default for History {
    fn default() -> Self {
        Self {
            steps: Vec::new(),
            n_done: 0,
            base_state: 0,
            last_state: 0,
            saved_state: 0,
            n_bytes: 0,
            max_bytes: MAX_BYTES,
            records: None,
            held_from: None,
        }
    }
}

impl History {
    /// Apply an edit and remember how to undo it. Steps that were undone are forgotten.
    pub fn apply(&mut self, groom: &mut Groom, label: &str, edit: Edit, merge: Merge) -> Result<(), EditError> {
        let written = self.records.is_some().then(|| edit.clone());
        let inverse = groom.apply(edit)?;
        self.steps.truncate(self.n_done);
        self.last_state += 1;
        let state = self.last_state;
        let last = self.steps.last_mut().filter(|last| merge != Merge::New && last.open == merge);
        let joined = last.is_some_and(|last| last.join(&inverse, state));
        if !joined {
            self.steps.push(Step { label: label.to_owned(), edit: inverse, state, open: merge });
            self.n_done += 1;
        }
        if let Some((records, edit)) = self.records.as_mut().zip(written) {
            let kind = if joined { RecordKind::Joined } else { RecordKind::Did };
            put(records, Record { kind, label: label.to_owned(), edit });
        }
        self.forget_oldest();
        Ok(())
    }

    /// The next edit starts a new step, whatever drag or stroke it belongs to.
    pub fn end_drag(&mut self) {
        if let Some(last) = self.steps.last_mut() {
            last.open = Merge::New;
        }
    }

    /// From now on write down what is done to the groom, for [`History::take_records`].
    pub fn record(&mut self) {
        self.records.get_or_insert_default();
    }

    /// What was done since this was last called, but for what is held back; nothing where [`History::record`] never
    /// was.
    pub fn take_records(&mut self) -> Vec<Record> {
        let Some(records) = &mut self.records else { return Vec::new() };
        let n_taken = self.held_from.map_or(records.len(), |from| from.min(records.len()));
        if self.held_from.is_some() {
            self.held_from = Some(0);
        }
        records.drain(..n_taken).collect()
    }

    /// Hold back what is written down from here on: it is the beginning of something that has a better name once it
    /// is complete ([`History::release`]), as the guides that a stroke moved are the stroke.
    pub fn hold(&mut self) {
        self.end_drag();
        self.held_from = self.records.as_ref().map(Vec::len);
    }

    /// Write down what was held back: as `edit`, which comes to the same, where it is given and what was held back is
    /// one step and all that was done meanwhile.
    pub fn release(&mut self, edit: Option<Edit>) {
        let Some(from) = self.held_from.take() else { return };
        let (Some(records), Some(edit)) = (&mut self.records, edit) else { return };
        let held = records.get(from..).unwrap_or_default();
        let is_one_step = held.first().is_some_and(|first| first.kind == RecordKind::Did)
            && held[1..].iter().all(|record| record.kind == RecordKind::Joined);
        if is_one_step {
            records.truncate(from + 1);
            records[from].edit = edit;
        }
    }

    /// Do what a record says, so that groom and history become what they were when it was written. Steps
    /// from before the first record that is replayed are unknown here: those that were crossed since come
    /// into the history where they belong.
    pub fn replay(&mut self, groom: &mut Groom, record: Record) -> Result<(), EditError> {
        let Record { kind, label, edit } = record;
        let inverse = groom.apply(edit)?;
        self.last_state += 1;
        let state = self.last_state;
        let step = |edit| Step { label, edit, state, open: Merge::New };
        match kind {
            RecordKind::Joined if self.n_done > 0 => {
                self.steps.truncate(self.n_done);
                self.steps[self.n_done - 1].join_stroke(inverse, state);
            }
            RecordKind::Did | RecordKind::Joined => {
                self.steps.truncate(self.n_done);
                self.steps.push(step(inverse));
                self.n_done += 1;
            }
            RecordKind::Undid if self.n_done > 0 => {
                self.n_done -= 1;
                self.steps[self.n_done].edit = inverse;
            }
            RecordKind::Undid => {
                self.base_state = state;
                self.last_state += 1;
                self.steps.insert(0, Step { state: self.last_state, ..step(inverse) });
            }
            RecordKind::Redid => {
                match self.steps.get_mut(self.n_done) {
                    Some(next) => next.edit = inverse,
                    None => self.steps.push(step(inverse)),
                }
                self.n_done += 1;
            }
        }
        self.forget_oldest();
        Ok(())
    }

    /// Undo the last step; returns its label, `None` where there is nothing to undo.
    pub fn undo(&mut self, groom: &mut Groom) -> Option<&str> {
        let step_idx = self.n_done.checked_sub(1)?;
        self.cross(groom, step_idx);
        self.n_done = step_idx;
        Some(&self.steps[step_idx].label)
    }

    /// Undo the last step and forget it: what a drag did before it was given up.
    pub fn take_back(&mut self, groom: &mut Groom) {
        if self.undo(groom).is_some() {
            self.steps.truncate(self.n_done);
        }
    }

    /// Do the next undone step again; returns its label, `None` where there is none.
    pub fn redo(&mut self, groom: &mut Groom) -> Option<&str> {
        let step_idx = self.n_done;
        if step_idx == self.steps.len() {
            return None;
        }
        self.cross(groom, step_idx);
        self.n_done += 1;
        Some(&self.steps[step_idx].label)
    }

    /// Undo or redo until `n_done` steps are in the groom.
    pub fn go_to(&mut self, groom: &mut Groom, n_done: usize) {
        while self.n_done > n_done && self.undo(groom).is_some() {}
        while self.n_done < n_done && self.redo(groom).is_some() {}
    }

    /// Labels of all steps, oldest first; the first [`History::n_done`] of them are done.
    pub fn labels(&self) -> impl ExactSizeIterator<Item = &str> {
        self.steps.iter().map(|step| step.label.as_str())
    }

    pub fn n_done(&self) -> usize {
        self.n_done
    }

    pub fn can_undo(&self) -> bool {
        self.n_done > 0
    }

    pub fn can_redo(&self) -> bool {
        self.n_done < self.steps.len()
    }

    /// A number that names the groom's state: the same number, the same groom.
    pub fn state(&self) -> u64 {
        self.n_done.checked_sub(1).map_or(self.base_state, |last| self.steps[last].state)
    }

    /// The state that is in the file now.
    pub fn mark_saved(&mut self, state: u64) {
        self.saved_state = state;
    }

    /// Whether the groom differs from what was saved last.
    pub fn is_unsaved(&self) -> bool {
        self.state() != self.saved_state
    }

    /// What all steps keep alive, in bytes: what the groom itself also has is counted too.
    pub fn n_bytes(&self) -> usize {
        self.n_bytes
    }

    /// What steps may keep alive, in bytes; the oldest are forgotten beyond it, never the last.
    pub fn set_max_bytes(&mut self, max_bytes: usize) {
        if self.max_bytes != max_bytes {
            self.max_bytes = max_bytes;
            self.forget_oldest();
        }
    }

    /// Forget every step; the groom stays as it is.
    pub fn clear(&mut self) {
        self.base_state = self.state();
        self.steps.clear();
        self.n_done = 0;
        self.n_bytes = 0;
    }

    fn cross(&mut self, groom: &mut Groom, step_idx: usize) {
        let kind = if step_idx < self.n_done { RecordKind::Undid } else { RecordKind::Redid };
        let step = &mut self.steps[step_idx];
        step.open = Merge::New;
        let edit = std::mem::replace(&mut step.edit, Edit::Batch(Vec::new()));
        if let Some(records) = &mut self.records {
            put(records, Record { kind, label: step.label.clone(), edit: edit.clone() });
        }
        step.edit = groom.apply(edit).expect("a step fits the groom on its side");
    }

    /// Drop the oldest steps until the limits hold; the newest always stays.
    fn forget_oldest(&mut self) {
        let mut seen = HashSet::new();
        let mut n_bytes = 0;
        let mut n_kept = 0;
        self.n_bytes = 0;
        for step in self.steps.iter().rev() {
            n_bytes += size_of::<Step>() + step.label.len();
            step.edit.visit_shared(&mut |address, size| {
                if seen.insert(address) {
                    n_bytes += size;
                }
            });
            // What is done no more is of the newest; it goes when something else is done.
            let is_undone = n_kept + self.n_done < self.steps.len();
            if n_kept > 0 && !is_undone && (n_bytes > self.max_bytes || n_kept == MAX_STEPS) {
                break;
            }
            self.n_bytes = n_bytes;
            n_kept += 1;
        }
        let n_forgotten = self.steps.len() - n_kept;
        if n_forgotten > 0 {
            self.base_state = self.steps[n_forgotten - 1].state;
            self.steps.drain(..n_forgotten);
            self.n_done -= n_forgotten;
        }
    }
}

impl Step {
    /// Take another edit's inverse in; `false` where it needs a step of its own.
    fn join(&mut self, inverse: &Edit, state: u64) -> bool {
        match self.open {
            Merge::New => return false,
            Merge::Drag(_) if !self.edit.join(inverse) => return false,
            Merge::Drag(_) => self.state = state,
            Merge::Stroke(_) => self.join_stroke(inverse.clone(), state),
        }
        true
    }

    /// Put the inverse of a later edit before those of the earlier ones.
    fn join_stroke(&mut self, inverse: Edit, state: u64) {
        self.state = state;
        if self.edit.join(&inverse) {
            return;
        }
        self.edit = match std::mem::replace(&mut self.edit, Edit::Batch(Vec::new())) {
            Edit::Batch(mut edits) => {
                if !edits.first_mut().is_some_and(|latest| latest.join(&inverse)) {
                    edits.insert(0, inverse);
                }
                Edit::Batch(edits)
            }
            edit => Edit::Batch(vec![inverse, edit]),
        };
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::edit::tests::{any_edit, small_groom};
    use crate::look::Look;
    use crate::maps::{MapKind, Tile, TileChange};

    fn exposure(exposure: f32) -> Edit {
        Edit::SetLook(Box::new(Look { exposure, ..Look::default() }))
    }

    proptest! {
        #[test]
        fn undo_and_redo_visit_the_same_grooms(edits in proptest::collection::vec((any_edit(), 0_u64..4), 1..30)) {
            let mut groom = small_groom();
            let mut history = History::default();
            let mut grooms = vec![groom.clone()];
            for (edit, drag) in edits {
                let merge = [Merge::New, Merge::Drag(1), Merge::Drag(2), Merge::Stroke(1)][drag as usize];
                if history.apply(&mut groom, "edit", edit, merge).is_ok() {
                    grooms.truncate(history.n_done());
                    grooms.push(groom.clone());
                }
            }
            while history.undo(&mut groom).is_some() {
                prop_assert_eq!(&groom, &grooms[history.n_done()]);
            }
            prop_assert_eq!(&groom, &small_groom());
            while history.redo(&mut groom).is_some() {
                prop_assert_eq!(&groom, &grooms[history.n_done()]);
            }
        }
    }

    #[test]
    fn what_is_held_back_is_written_down_by_its_better_name_only_where_that_is_all_of_it() {
        let (mut groom, mut history) = (small_groom(), History::default());
        history.record();
        history.apply(&mut groom, "before", exposure(0.5), Merge::New).unwrap();
        history.hold();
        let merge = Merge::Stroke(7);
        history.apply(&mut groom, "stroke", exposure(1.0), merge).unwrap();
        assert_eq!(history.take_records().len(), 1, "only what was before");
        history.apply(&mut groom, "stroke", Edit::SetName("a".to_owned()), merge).unwrap();
        assert!(history.take_records().is_empty());
        let better = Edit::Batch(vec![exposure(1.0), Edit::SetName("a".to_owned())]);
        history.release(Some(better.clone()));
        let records = history.take_records();
        assert_eq!(records.iter().map(|record| &record.edit).collect::<Vec<_>>(), [&better]);
        // Another step came between: all of it is written down as it was.
        history.hold();
        history.apply(&mut groom, "stroke", exposure(2.0), Merge::Stroke(8)).unwrap();
        history.apply(&mut groom, "import", Edit::SetName("b".to_owned()), Merge::New).unwrap();
        history.release(Some(better.clone()));
        assert_eq!(history.take_records().len(), 2);
        // Given up: what was done and undone.
        history.hold();
        history.apply(&mut groom, "stroke", exposure(3.0), Merge::Stroke(9)).unwrap();
        history.take_back(&mut groom);
        history.release(None);
        let kinds: Vec<_> = history.take_records().iter().map(|record| record.kind).collect();
        assert_eq!(kinds, [RecordKind::Did, RecordKind::Undid]);
    }

    /// What can happen to a document.
    #[derive(Debug, Clone)]
    enum Event {
        Apply(Edit, Merge),
        EndDrag,
        Undo,
        Redo,
        GoTo(usize),
        Clear,
    }

    fn any_event() -> impl Strategy<Value = Event> {
        let merge = prop_oneof![Just(Merge::New), Just(Merge::Drag(1)), Just(Merge::Stroke(2))];
        prop_oneof![
            8 => (any_edit(), merge).prop_map(|(edit, merge)| Event::Apply(edit, merge)),
            1 => Just(Event::EndDrag),
            2 => Just(Event::Undo),
            2 => Just(Event::Redo),
            1 => (0_usize..12).prop_map(Event::GoTo),
            1 => Just(Event::Clear),
        ]
    }

    fn happen(groom: &mut Groom, history: &mut History, event: Event) {
        match event {
            Event::Apply(edit, merge) => {
                // Refused edits are part of the game.
                let _ = history.apply(groom, "edit", edit, merge);
            }
            Event::EndDrag => history.end_drag(),
            Event::Undo => drop(history.undo(groom).map(str::to_owned)),
            Event::Redo => drop(history.redo(groom).map(str::to_owned)),
            Event::GoTo(n_done) => history.go_to(groom, n_done),
            Event::Clear => history.clear(),
        }
    }

    proptest! {
        #[test]
        fn what_was_recorded_replays_to_the_same_groom_whenever_recording_began(
            before in proptest::collection::vec(any_event(), 0..8),
            after in proptest::collection::vec(any_event(), 0..24),
            taken_at in 0_usize..24,
        ) {
            let (mut groom, mut history) = (small_groom(), History::default());
            for event in before {
                happen(&mut groom, &mut history, event);
            }
            let base = groom.clone();
            history.record();
            let mut records = Vec::new();
            for (n, event) in after.into_iter().enumerate() {
                happen(&mut groom, &mut history, event);
                if n % (taken_at + 1) == 0 {
                    records.extend(history.take_records());
                }
            }
            records.extend(history.take_records());
            let (mut again, mut replayed) = (base.clone(), History::default());
            for record in records {
                let text = ron::to_string(&record).unwrap();
                replayed.replay(&mut again, ron::from_str(&text).unwrap()).unwrap();
            }
            prop_assert_eq!(&again, &groom);
            prop_assert_eq!(ron::to_string(&again).unwrap(), ron::to_string(&groom).unwrap());
            // What was undone is there to be done again, as in the history that was lost.
            while replayed.can_redo() && history.can_redo() {
                replayed.redo(&mut again);
                history.redo(&mut groom);
                prop_assert_eq!(&again, &groom);
            }
            while replayed.undo(&mut again).is_some() {}
        }
    }

    #[test]
    fn a_stroke_is_one_step_whatever_it_wrote() {
        let mut groom = small_groom();
        let mut history = History::default();
        for n in 0..5 {
            let edit = if n % 2 == 0 { exposure(n as f32) } else { Edit::SetName(format!("{n}")) };
            history.apply(&mut groom, "stroke", edit, Merge::Stroke(3)).unwrap();
        }
        history.end_drag();
        history.apply(&mut groom, "stroke", exposure(9.0), Merge::Stroke(3)).unwrap();
        assert_eq!(history.labels().len(), 2);
        history.undo(&mut groom);
        assert_eq!((groom.look.exposure, groom.name.as_str()), (4.0, "3"));
        history.undo(&mut groom);
        assert_eq!(groom, small_groom());
        history.redo(&mut groom);
        assert_eq!((groom.look.exposure, groom.name.as_str()), (4.0, "3"));
    }

    #[test]
    fn memory_is_counted_once_a_part_and_bounded() {
        let mut groom = small_groom();
        let mut history = History::default();
        let points: Vec<glam::Vec3> = (0..10_000).map(|k| glam::Vec3::splat(k as f32)).collect();
        let layer = |n: usize| {
            let mut strands = crate::strands::Strands::default();
            strands.push(&points[n..]);
            Box::new(crate::groom::Layer::from_strands("long", strands))
        };
        for n in 0..10 {
            let edit = Edit::SetLayer { layer_idx: 0, layer: layer(n) };
            history.apply(&mut groom, "long", edit, Merge::New).unwrap();
        }
        // The first step keeps the small layer, nine keep 120 kB each.
        assert!((1_080_000..1_100_000).contains(&history.n_bytes()), "{}", history.n_bytes());
        history.set_max_bytes(500_000);
        assert_eq!(history.labels().len(), 4);
        assert!(history.n_bytes() <= 500_000);
        history.go_to(&mut groom, 0);
        history.set_max_bytes(1);
        assert_eq!(history.labels().len(), 4, "what was undone is not forgotten by a limit");
        history.clear();
        assert_eq!((history.labels().len(), history.n_bytes()), (0, 0));
        assert!(history.is_unsaved());
    }

    #[test]
    fn a_drag_is_one_step_and_two_drags_are_two() {
        let mut groom = small_groom();
        let mut history = History::default();
        for value in [0.1, 0.2, 0.3] {
            history.apply(&mut groom, "exposure", exposure(value), Merge::Drag(7)).unwrap();
        }
        history.end_drag();
        history.apply(&mut groom, "exposure", exposure(1.0), Merge::Drag(7)).unwrap();
        assert_eq!(history.labels().len(), 2);
        history.undo(&mut groom);
        assert_eq!(groom.look.exposure, 0.3);
        history.undo(&mut groom);
        assert_eq!(groom, small_groom());
        assert!(!history.is_unsaved());
    }

    #[test]
    fn a_stroke_over_more_and_more_tiles_is_one_step_that_keeps_each_once() {
        let mut groom = small_groom();
        let kind = MapKind::Length;
        groom.layers[0].maps.insert(kind.clone(), Arc::new(kind.empty_map()));
        let first = groom.clone();
        let mut history = History::default();
        for n in 1..20 {
            let change = |tile_idx| TileChange { tile_idx, tile: Arc::new(Tile::filled(n as u8)) };
            let edit = Edit::PaintTiles { layer_idx: 0, kind: kind.clone(), tiles: (n / 2..n).map(change).collect() };
            history.apply(&mut groom, "Paint", edit, Merge::Drag(3)).unwrap();
        }
        let last = groom.clone();
        assert_eq!(history.labels().len(), 1);
        let mut n_bytes = 0;
        history.steps[0].edit.visit_shared(&mut |_, size| n_bytes += size);
        assert_eq!(n_bytes, 19 * Tile::N_BYTES, "nineteen tiles of the map's 256");
        history.undo(&mut groom);
        assert_eq!(groom, first);
        history.redo(&mut groom);
        assert_eq!(groom, last);
    }

    #[test]
    fn what_is_taken_back_cannot_be_done_again() {
        let mut groom = small_groom();
        let mut history = History::default();
        history.apply(&mut groom, "kept", exposure(1.0), Merge::New).unwrap();
        let state = history.state();
        history.apply(&mut groom, "given up", exposure(2.0), Merge::Drag(3)).unwrap();
        history.take_back(&mut groom);
        assert_eq!((groom.look.exposure, history.state(), history.can_redo()), (1.0, state, false));
    }

    #[test]
    fn saved_is_a_place_on_the_line_that_undo_can_come_back_to() {
        let mut groom = small_groom();
        let mut history = History::default();
        history.apply(&mut groom, "a", exposure(1.0), Merge::New).unwrap();
        history.mark_saved(history.state());
        history.apply(&mut groom, "b", exposure(2.0), Merge::New).unwrap();
        assert!(history.is_unsaved());
        history.undo(&mut groom);
        assert!(!history.is_unsaved());
        history.undo(&mut groom);
        assert!(history.is_unsaved());
        // Another way to the same number of steps is another state.
        history.apply(&mut groom, "c", exposure(3.0), Merge::New).unwrap();
        assert!(history.is_unsaved());
    }

    #[test]
    fn the_oldest_steps_are_forgotten_at_the_limit() {
        let mut groom = small_groom();
        let mut history = History::default();
        for i in 0..MAX_STEPS + 5 {
            history.apply(&mut groom, "step", exposure(i as f32 * 1e-3), Merge::New).unwrap();
        }
        assert_eq!(history.labels().len(), MAX_STEPS);
        while history.undo(&mut groom).is_some() {}
        assert!((groom.look.exposure - 4e-3).abs() < 1e-9);
        assert!(history.is_unsaved());
    }
}
