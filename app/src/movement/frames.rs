//! Frames of a movement that are kept in memory, so that going back in time costs nothing and gives the very same frame.
//!
//! Kept frames are always those of one run from the first frame with the inputs as they are. What a person does by hand
//! while it plays is no function of time: such frames are not kept.

use std::ops::RangeInclusive;
use std::sync::Arc;

use lorelei_sim::SolverState;

use super::Shot;

/// Frames by their number, within a budget.
#[derive(Debug, Clone, Default)]
pub struct Frames {
    /// Number of the first.
    start: u32,
    shots: Vec<Option<Arc<Shot>>>,
    n_bytes: usize,
    /// A frame from which a solver can go on.
    state: Option<(u32, Arc<SolverState>)>,
}

impl Frames {
    /// None yet, of a range that begins at `start`.
    pub fn new(start: u32) -> Self {
        Self { start, ..Self::default() }
    }

    pub fn get(&self, frame_idx: u32) -> Option<&Arc<Shot>> {
        self.shots.get(frame_idx.checked_sub(self.start)? as usize)?.as_ref()
    }

    /// Keep a frame, unless it would take more bytes in all than the budget; false where it was not kept.
    pub fn keep(&mut self, frame_idx: u32, shot: Arc<Shot>, budget: usize) -> bool {
        let Some(at) = frame_idx.checked_sub(self.start) else { return false };
        if self.get(frame_idx).is_some() {
            return true;
        }
        let n_bytes = shot.n_bytes();
        if self.n_bytes + n_bytes > budget {
            return false;
        }
        if self.shots.len() <= at as usize {
            self.shots.resize(at as usize + 1, None);
        }
        self.shots[at as usize] = Some(shot);
        self.n_bytes += n_bytes;
        true
    }

    /// Go on from here where no solver is at the last frame.
    pub fn keep_state(&mut self, frame_idx: u32, state: SolverState) {
        self.state = Some((frame_idx, Arc::new(state)));
    }

    /// The frame that a solver can go on from to reach another.
    pub fn state_before(&self, frame_idx: u32) -> Option<(u32, &SolverState)> {
        self.state.as_ref().filter(|(at, _)| *at < frame_idx).map(|(at, state)| (*at, &**state))
    }

    pub fn n_bytes(&self) -> usize {
        self.n_bytes
    }

    /// Runs of frames without a gap.
    pub fn runs(&self) -> Vec<RangeInclusive<u32>> {
        let mut runs: Vec<RangeInclusive<u32>> = Vec::new();
        for (at, _) in self.shots.iter().enumerate().filter(|(_, shot)| shot.is_some()) {
            let frame_idx = self.start + at as u32;
            match runs.last_mut() {
                Some(run) if *run.end() + 1 == frame_idx => *run = *run.start()..=frame_idx,
                _ => runs.push(frame_idx..=frame_idx),
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Vec3};

    use super::*;

    fn shot(x: f32) -> Arc<Shot> {
        Arc::new(Shot { world_from_head: Affine3A::IDENTITY, positions: vec![vec![Vec3::splat(x); 10]] })
    }

    impl Frames {
        pub fn n_frames(&self) -> usize {
            self.shots.iter().flatten().count()
        }
    }

    #[test]
    fn frames_come_back_as_they_were_and_the_budget_holds() {
        let mut frames = Frames::new(5);
        let budget = 4 * shot(0.0).n_bytes();
        for frame_idx in [5, 6, 9, 7] {
            assert!(frames.keep(frame_idx, shot(frame_idx as f32), budget));
        }
        assert!(!frames.keep(8, shot(8.0), budget) && !frames.keep(4, shot(4.0), usize::MAX));
        assert!(frames.keep(9, shot(0.0), budget), "it is kept already");
        assert_eq!(frames.get(9).unwrap().positions[0][0].x, 9.0);
        assert!(frames.get(8).is_none() && frames.get(4).is_none() && frames.get(100).is_none());
        assert_eq!(frames.runs(), [5..=7, 9..=9]);
        assert_eq!((frames.n_bytes(), frames.n_frames()), (budget, 4));
    }
}
