//! Undo and redo: a line of labelled steps, each holding the edit that crosses it.
//!
//! A step keeps one edit: while it is done, the edit that undoes it; while it is undone, the edit that does
//! it again. Crossing it swaps the two, since [`Groom::apply`] returns the inverse. A drag of a slider is
//! one step: see [`Merge`].

use std::collections::HashSet;

use crate::edit::{Edit, EditError};
use crate::groom::Groom;

/// Steps kept at most, and what they may keep alive beside the groom itself.
const MAX_STEPS: usize = 2000;
const MAX_BYTES: usize = 1 << 30;

/// Whether an edit goes on with the step before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Merge {
    /// A step of its own.
    New,
    /// One of many in a continuous drag: joins the last step where that was the same drag and wrote the
    /// same thing. The number names the drag, and [`History::end_drag`] closes it.
    Drag(u64),
}

#[derive(Debug, Clone)]
struct Step {
    label: String,
    edit: Edit,
    /// What state the groom is in after the step.
    state: u64,
    drag: Option<u64>,
}

/// The line of steps and where on it the groom stands.
#[derive(Debug, Clone, Default)]
pub struct History {
    steps: Vec<Step>,
    /// Steps `..n_done` are in the groom.
    n_done: usize,
    /// State before the first step that is kept.
    base_state: u64,
    last_state: u64,
    saved_state: u64,
}

impl History {
    /// Apply an edit and remember how to undo it. Steps that were undone are forgotten.
    pub fn apply(&mut self, groom: &mut Groom, label: &str, edit: Edit, merge: Merge) -> Result<(), EditError> {
        let drag = match merge {
            Merge::New => None,
            Merge::Drag(id) => Some(id),
        };
        let inverse = groom.apply(edit)?;
        self.steps.truncate(self.n_done);
        self.last_state += 1;
        let state = self.last_state;
        if let Some(last) = self.steps.last_mut()
            && drag.is_some()
            && last.drag == drag
            && last.edit.join(&inverse)
        {
            // The step's own inverse already leads to before the drag.
            last.state = state;
            return Ok(());
        }
        self.steps.push(Step { label: label.to_owned(), edit: inverse, state, drag });
        self.n_done += 1;
        self.forget_oldest();
        Ok(())
    }

    /// The next edit starts a new step, whatever drag it belongs to.
    pub fn end_drag(&mut self) {
        if let Some(last) = self.steps.last_mut() {
            last.drag = None;
        }
    }

    /// Undo the last step; returns its label, `None` where there is nothing to undo.
    pub fn undo(&mut self, groom: &mut Groom) -> Option<&str> {
        let step_idx = self.n_done.checked_sub(1)?;
        self.cross(groom, step_idx);
        self.n_done = step_idx;
        Some(&self.steps[step_idx].label)
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

    fn cross(&mut self, groom: &mut Groom, step_idx: usize) {
        let step = &mut self.steps[step_idx];
        step.drag = None;
        let edit = std::mem::replace(&mut step.edit, Edit::Batch(Vec::new()));
        step.edit = groom.apply(edit).expect("a step fits the groom on its side");
    }

    /// Drop the oldest steps until the limits hold; the newest always stays.
    fn forget_oldest(&mut self) {
        let mut seen = HashSet::new();
        let mut n_bytes = 0;
        let mut n_kept = 0;
        for step in self.steps.iter().rev() {
            step.edit.visit_shared(&mut |address, size| {
                if seen.insert(address) {
                    n_bytes += size;
                }
            });
            if n_kept > 0 && (n_bytes > MAX_BYTES || n_kept == MAX_STEPS) {
                break;
            }
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
        fn undo_and_redo_visit_the_same_grooms(edits in proptest::collection::vec((any_edit(), 0_u64..3), 1..30)) {
            let mut groom = small_groom();
            let mut history = History::default();
            let mut grooms = vec![groom.clone()];
            for (edit, drag) in edits {
                let merge = if drag == 0 { Merge::New } else { Merge::Drag(drag) };
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
