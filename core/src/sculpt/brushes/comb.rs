//! Comb: the hair goes with the pointer.

use super::{Dab, Hair};

/// Every point moves as the pointer did at its depth, by its weight; the root stays. Hair is held better than by its
/// weight alone, or it slips out of the comb half way.
pub(super) fn comb(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    for (p, weight) in hair.points.iter_mut().zip(hair.weights).skip(1) {
        if weight > 0.0 {
            let hold = 1.0 - (1.0 - weight).powi(2);
            *p += hold * dab.movement_at(*p);
        }
    }
}
