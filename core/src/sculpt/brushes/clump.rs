//! Clump: hair comes to the middle of its lock, more towards the tip; inverted, it goes apart.

use super::super::K;
use super::{Dab, Hair};

/// Share of the way to the middle that the tip goes in one dab.
const SHARE: f32 = 0.35;

pub(super) fn clump(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let Some(lock) = dab.lock else { return };
    for k in 1..K {
        let along = k as f32 / (K - 1) as f32;
        let p = hair.points[k];
        hair.points[k] += dab.sign() * SHARE * along * hair.weights[k] * (lock[k] - p);
    }
}
