//! A stroke as data, and how it becomes dabs: evenly spaced along the pointer's way, however many events the way
//! came in, so that the same stroke on a slow machine is the same stroke.

use glam::Vec2;
use serde::{Deserialize, Serialize};

use super::brushes::SculptBrush;
use super::view::StrokeView;
use crate::brush::Brush;

/// A whole stroke, to be replayed.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Stroke {
    pub kind: SculptBrush,
    pub brush: Brush,
    /// The brush does the opposite.
    pub is_inverted: bool,
    pub view: StrokeView,
    pub points: Vec<StrokePoint>,
}

/// Where the pointer was.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StrokePoint {
    /// Points of the window from the viewport's upper left corner.
    pub at: [f32; 2],
    /// 0-1; a mouse presses with 1.
    pub pressure: f32,
    /// Since the stroke began.
    pub secs: f32,
}

impl Default for StrokePoint {
    fn default() -> Self {
        Self::new(0.0, 0.0)
    }
}

impl StrokePoint {
    pub fn new(x: f32, y: f32) -> Self {
        Self { at: [x, y], pressure: 1.0, secs: 0.0 }
    }
}

/// Dabs a radius: enough that falloffs overlap into one even band.
pub const DABS_PER_RADIUS: f32 = 8.0;

/// Where the brush comes down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footstep {
    pub before: Vec2,
    pub at: Vec2,
    pub pressure: f32,
}

/// Walks along the pointer's way in even steps.
#[derive(Debug, Clone, Copy)]
pub struct Walker {
    spacing: f32,
    last: Option<(Vec2, f32)>,
    /// Where the last step ended, and how far the way has gone on since.
    step_at: Vec2,
    since_step: f32,
}

impl Walker {
    /// `spacing` in points of the window.
    pub fn new(spacing: f32) -> Self {
        Self { spacing: spacing.max(0.5), last: None, step_at: Vec2::ZERO, since_step: 0.0 }
    }

    /// Go on to a point; `step` gets every footstep on the way there. The first is where the stroke begins.
    pub fn go_to(&mut self, point: &StrokePoint, mut step: impl FnMut(Footstep)) {
        let to = Vec2::from_array(point.at);
        let Some((from, pressure)) = self.last else {
            self.last = Some((to, point.pressure));
            self.step_at = to;
            step(Footstep { before: to, at: to, pressure: point.pressure });
            return;
        };
        let length = from.distance(to);
        let mut along = self.spacing - self.since_step;
        while along <= length {
            let x = along / length;
            let at = from.lerp(to, x);
            step(Footstep { before: self.step_at, at, pressure: pressure + x * (point.pressure - pressure) });
            self.step_at = at;
            along += self.spacing;
        }
        self.since_step = length - (along - self.spacing);
        self.last = Some((to, point.pressure));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(points: &[StrokePoint]) -> Vec<Footstep> {
        let mut walker = Walker::new(3.0);
        let mut steps = Vec::new();
        for point in points {
            walker.go_to(point, |step| steps.push(step));
        }
        steps
    }

    #[test]
    fn steps_are_even_and_do_not_depend_on_the_number_of_events() {
        let ends = [StrokePoint::new(0.0, 0.0), StrokePoint { pressure: 0.5, ..StrokePoint::new(100.0, 40.0) }];
        let few = steps(&ends);
        let between = |i: usize| {
            let x = i as f32 / 40.0;
            StrokePoint { pressure: 1.0 - 0.5 * x, ..StrokePoint::new(100.0 * x, 40.0 * x) }
        };
        let many = steps(&(0..=40).map(between).collect::<Vec<_>>());
        assert_eq!((few.len(), many.len()), (36, 36));
        for (a, b) in few.iter().zip(&many) {
            assert!(a.at.distance(b.at) < 1e-3 && a.before.distance(b.before) < 1e-3);
            assert!((a.pressure - b.pressure).abs() < 1e-3);
        }
        assert!(few.windows(2).all(|pair| (pair[0].at.distance(pair[1].at) - 3.0).abs() < 1e-3));
        assert!(few.windows(2).all(|pair| pair[0].at == pair[1].before));
    }
}
