//! How much of the picture's quality a frame gets: all of it at rest, less while something moves and frames
//! are slow.
//!
//! Fewer strands are drawn wider. Where that is not enough, the picture has fewer pixels and its shadow maps
//! fewer texels: on a software driver a frame of few strands still costs what its pixels and texels cost.

use std::time::{Duration, Instant};

use lorelei_core::look::Look;

use super::thread::FrameRequest;

/// What one frame is drawn with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detail {
    /// Share of the strands.
    pub lod: f32,
    /// Each side of the picture is this many times smaller: 1, 2 or 3.
    pub coarseness: u32,
}

impl Detail {
    pub const FULL: Self = Self { lod: 1.0, coarseness: 1 };

    pub fn is_full(self) -> bool {
        self == Self::FULL
    }

    pub fn size(self, [width, height]: [u32; 2]) -> [u32; 2] {
        [(width / self.coarseness).max(1), (height / self.coarseness).max(1)]
    }

    /// The look with shadow maps as coarse as the picture.
    pub fn look(self, look: &Look) -> Look {
        let mut look = look.clone();
        if self.coarseness > 1 {
            let resolution = &mut look.shadows.resolution;
            *resolution = (*resolution / (2 * self.coarseness)).max(COARSEST_SHADOW.min(*resolution));
        }
        look
    }
}

/// After the last movement, before a full frame that would take long: a hand that rests for a moment goes on.
const SHORTEST_REST: Duration = Duration::from_millis(250);
const LONGEST_REST: Duration = Duration::from_millis(700);
/// Full frames quicker than this need no rest first.
pub const QUICK_MS: f32 = 100.0;
/// Fewer strands no longer look like the groom, and most of a slow frame's time is then in other passes.
const FEWEST_STRANDS: f32 = 2000.0;
const COARSEST: u32 = 3;
/// Texels of a shadow map's side.
const COARSEST_SHADOW: u32 = 192;

/// Decides the detail of the next frame from how long the last ones took.
pub struct Pacer {
    /// Detail of the next frame while something moves.
    moving: Detail,
    last: Option<Detail>,
    /// What a frame of full detail took, or is likely to take.
    full_ms: f32,
    last_drawn: Option<Instant>,
    last_tick: Option<Instant>,
}

impl Pacer {
    /// The first guess shows something at once: on a software driver that takes a coarser picture.
    pub fn new(is_software: bool) -> Self {
        let moving = if is_software { Detail { lod: 0.05, coarseness: 2 } } else { Detail { lod: 0.1, coarseness: 1 } };
        Self { moving, last: None, full_ms: f32::INFINITY, last_drawn: None, last_tick: None }
    }

    /// Seconds since the last frame of the same run of movement.
    pub fn tick(&mut self, now: Instant, is_playing: bool) -> f32 {
        let before = self.last_tick.replace(now);
        if !is_playing {
            self.last_tick = None;
        }
        before.map_or(0.0, |before| (now - before).as_secs_f32())
    }

    /// Detail of a frame; `is_new`: something was asked for that differs from what was drawn last.
    pub fn detail_for(&self, request: &FrameRequest, drawn: Option<&FrameRequest>, is_new: bool) -> Detail {
        let is_moving = request.is_interacting
            || request.playback.is_playing
            || drawn.is_none()
            || drawn.is_some_and(|drawn| drawn.camera != request.camera || drawn.size != request.size);
        let is_hurried = is_moving || (is_new && self.full_ms > QUICK_MS);
        if is_hurried { self.moving } else { Detail::FULL }
    }

    /// Learn from a frame. `n_strands`: of the groom.
    pub fn drew(&mut self, detail: Detail, frame_ms: f32, budget_ms: f32, n_strands: usize) {
        self.last = Some(detail);
        self.last_drawn = Some(Instant::now());
        let coarsest = (FEWEST_STRANDS / n_strands.max(1) as f32).min(1.0);
        if detail.is_full() {
            self.full_ms = frame_ms;
        } else {
            let pixels = (detail.coarseness * detail.coarseness) as f32;
            self.full_ms = self.full_ms.min(frame_ms / detail.lod * pixels);
        }
        let Detail { lod, coarseness } = detail;
        // Part of a frame's time has nothing to do with strands, so the step is damped.
        let wanted = (budget_ms / frame_ms.max(0.1)).clamp(0.5, 1.6) * lod;
        self.moving = if budget_ms >= self.full_ms {
            Detail::FULL
        } else if detail.is_full() {
            // What a slow full frame takes says little about a frame of a tenth of the strands.
            self.moving
        } else if wanted < coarsest && frame_ms > 1.3 * budget_ms && coarseness < COARSEST {
            Detail { lod: coarsest, coarseness: coarseness + 1 }
        } else if coarseness > 1 && frame_ms < 0.3 * budget_ms {
            Detail { lod, coarseness: coarseness - 1 }
        } else if (0.75..1.4).contains(&(budget_ms / frame_ms.max(0.1))) {
            // Near enough: strands that come and go from frame to frame would be seen.
            detail
        } else {
            Detail { lod: wanted.clamp(coarsest, 1.0), coarseness }
        };
    }

    /// What a frame of full detail is likely to take, milliseconds.
    pub fn expects_ms(&self) -> f32 {
        if self.full_ms.is_finite() { self.full_ms } else { 0.0 }
    }

    pub fn wants_full(&self) -> bool {
        self.last.is_some_and(|last| !last.is_full())
    }

    /// How long to wait for further movement before a full frame.
    pub fn rest_left(&self, now: Instant) -> Duration {
        let rest = if self.full_ms > QUICK_MS {
            Duration::from_secs_f32(0.25e-3 * self.full_ms.min(1e6)).clamp(SHORTEST_REST, LONGEST_REST)
        } else {
            Duration::ZERO
        };
        self.last_drawn.map_or(Duration::ZERO, |at| rest.saturating_sub(now.saturating_duration_since(at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Details that a pacer settles on where a frame takes `cost` milliseconds.
    fn settled(cost: impl Fn(Detail) -> f32) -> (Pacer, Detail) {
        let mut pacer = Pacer::new(false);
        let mut detail = pacer.moving;
        for _ in 0..30 {
            pacer.drew(detail, cost(detail), 50.0, 100_000);
            detail = pacer.moving;
        }
        (pacer, detail)
    }

    #[test]
    fn slow_frames_lose_strands_until_they_fit_and_fast_ones_lose_none() {
        let (slow, detail) = settled(|detail| 10.0 + 200.0 * detail.lod);
        assert!((10.0 + 200.0 * detail.lod) < 67.0 && detail.lod > 0.1 && detail.coarseness == 1, "{detail:?}");
        assert!(slow.wants_full());
        let (fast, detail) = settled(|detail| 2.0 * detail.lod);
        assert!(detail.is_full() && !fast.wants_full());
    }

    #[test]
    fn where_few_strands_are_still_slow_the_picture_gets_coarser_and_fine_again() {
        let cost = |detail: Detail| 100.0 / (detail.coarseness * detail.coarseness) as f32 + 400.0 * detail.lod;
        let (mut pacer, detail) = settled(cost);
        assert!(detail.coarseness > 1 && cost(detail) < 66.0, "{detail:?} takes {}", cost(detail));
        // A smaller groom, a larger GPU: full detail comes back step by step.
        for _ in 0..30 {
            let detail = pacer.moving;
            pacer.drew(detail, 0.05 * cost(detail), 50.0, 100_000);
        }
        assert!(pacer.moving.is_full(), "{:?}", pacer.moving);
    }

    #[test]
    fn a_coarse_frame_has_fewer_pixels_and_shadow_texels_but_never_none() {
        let detail = Detail { lod: 0.1, coarseness: 3 };
        assert_eq!(detail.size([1200, 601]), [400, 200]);
        assert_eq!(detail.size([1, 2]), [1, 1]);
        let mut look = Look::default();
        look.shadows.resolution = 1024;
        assert_eq!(detail.look(&look).shadows.resolution, COARSEST_SHADOW);
        look.shadows.resolution = 128;
        assert_eq!(detail.look(&look).shadows.resolution, 128);
        assert_eq!(Detail::FULL.look(&look), look);
    }
}
