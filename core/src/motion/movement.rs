//! What happens to a groom and when: plain data of the document, beside how its hair moves.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{Motion, PoseTrack};
use crate::look::{Choice, ChoiceInfo, choices};

choices! {
    /// What playing does at the end of the range.
    #[derive(Default)]
    AtEnd {
        #[default]
        Loop = "loop", "Loop", "From the first frame again";
        Stop = "stop", "Stop", "Stays at the last frame";
        GoOn = "go-on", "Go on", "Time runs on behind the last frame; what is there is not kept";
    }
}

/// Frames of the longest range.
const MOST_FRAMES: u32 = 100_000;

/// The movement of a groom on its timeline.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Movement {
    pub motion: Motion,
    /// Moves the body beneath the preset: keyed poses that came from a file.
    pub track: Option<Arc<PoseTrack>>,
    /// Frames a second.
    pub fps: f32,
    /// First and last frame. Hair is at rest at the first, after the warm-up; frame n is n / fps seconds into the motion.
    pub start: u32,
    pub end: u32,
    pub at_end: AtEnd,
    /// Seconds that the hair settles before the first frame.
    pub warm_up_secs: f32,
}

impl Default for Movement {
    fn default() -> Self {
        // Sixty frames a second are what a screen shows; ten seconds hold every preset once.
        Self {
            motion: Motion::None,
            track: None,
            fps: 60.0,
            start: 0,
            end: 600,
            at_end: AtEnd::Loop,
            warm_up_secs: 0.0,
        }
    }
}

impl Movement {
    /// As in the document, whatever its numbers are: frames a second from 1 to 240, a range of at least a frame and at
    /// most 100,000, a warm-up of at most a minute.
    pub fn bounded(&self) -> Self {
        let fps = if self.fps.is_finite() { self.fps.clamp(1.0, 240.0) } else { Self::default().fps };
        let end = self.end.clamp(1, u32::MAX - MOST_FRAMES);
        let start = self.start.min(end - 1).max(end.saturating_sub(MOST_FRAMES));
        let warm_up_secs = if self.warm_up_secs.is_finite() { self.warm_up_secs.clamp(0.0, 60.0) } else { 0.0 };
        Self { fps, start, end, warm_up_secs, ..self.clone() }
    }

    /// Time of a frame, seconds.
    pub fn secs_of(&self, frame_idx: u32) -> f64 {
        f64::from(frame_idx) / f64::from(self.fps)
    }

    /// Frames of the range.
    pub fn n_frames(&self) -> u32 {
        self.end.saturating_sub(self.start) + 1
    }

    /// Whether frames of one are frames of the other: only how far the range goes and what happens then may differ.
    pub fn moves_like(&self, other: &Self) -> bool {
        let Self { motion, track, fps, start, end: _, at_end: _, warm_up_secs } = self;
        let is_same_track = match (track, &other.track) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        is_same_track
            && (*motion, *fps, *start) == (other.motion, other.fps, other.start)
            && *warm_up_secs == other.warm_up_secs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_from_a_file_are_made_harmless() {
        let broken = Movement { fps: f32::NAN, start: 9, end: 0, warm_up_secs: -4.0, ..Movement::default() }.bounded();
        assert_eq!((broken.fps, broken.start, broken.end, broken.warm_up_secs), (60.0, 0, 1, 0.0));
        let huge = Movement { fps: 1e9, start: 0, end: u32::MAX, ..Movement::default() }.bounded();
        assert!(huge.fps == 240.0 && huge.n_frames() <= MOST_FRAMES + 1 && huge.start < huge.end);
        assert_eq!(Movement::default().bounded(), Movement::default());
    }

    #[test]
    fn only_what_changes_frames_makes_them_others() {
        let movement = Movement::default();
        assert!(movement.moves_like(&Movement { end: 30, at_end: AtEnd::Stop, ..movement.clone() }));
        for other in [
            Movement { motion: Motion::Nod, ..movement.clone() },
            Movement { track: Some(Arc::default()), ..movement.clone() },
            Movement { fps: 24.0, ..movement.clone() },
            Movement { start: 3, ..movement.clone() },
            Movement { warm_up_secs: 1.0, ..movement.clone() },
        ] {
            assert!(!movement.moves_like(&other), "{other:?}");
        }
    }
}
