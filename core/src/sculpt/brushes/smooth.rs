//! Smooth: bends go out of the hair, and it lies as its neighbours do.

use super::super::K;
use super::{Dab, Hair};

/// Shares of the way that a point goes in one dab: to the middle of its neighbours along the hair, and to where
/// the mean of the hair under the brush would have it.
const ALONG: f32 = 0.5;
const AMONG: f32 = 0.05;
/// Rounds in one dab: one alone takes only the shortest bends out.
const ROUNDS: usize = 4;

pub(super) fn smooth(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    for _ in 0..ROUNDS {
        smooth_once(hair, dab);
    }
}

fn smooth_once(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let before = *hair.points;
    for k in 1..K {
        // The tip goes on as the hair before it does.
        let even = match before.get(k + 1) {
            Some(next) => 0.5 * (before[k - 1] + *next),
            None => before[k - 1] + 0.5 * (before[k] - before[k - 1]) + 0.5 * (before[k - 1] - before[k - 2]),
        };
        let mut wanted = ALONG * (even - before[k]);
        if let Some(lock) = dab.lock {
            wanted += AMONG * (before[0] + (lock[k] - lock[0]) - before[k]);
        }
        hair.points[k] += hair.weights[k] * wanted;
    }
}
