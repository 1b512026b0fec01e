//! Twist: the lock turns about its own middle, more towards the tip.

use glam::Quat;

use super::super::K;
use super::{Dab, Hair};

/// Turn of the tip in one dab, radians.
const TURN: f32 = 0.35;

pub(super) fn twist(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let Some(lock) = dab.lock else { return };
    // A mirrored lock turns the mirrored way by itself.
    for k in 1..K {
        let along = k as f32 / (K - 1) as f32;
        let axis = (lock[(k + 1).min(K - 1)] - lock[k - 1]).normalize_or(hair.normal);
        let turn = Quat::from_axis_angle(axis, dab.sign() * TURN * along * hair.weights[k]);
        hair.points[k] = lock[k] + turn * (hair.points[k] - lock[k]);
    }
}
