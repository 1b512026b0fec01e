//! Length: hair grows as a whole, its shape with it; inverted, it shrinks.

use super::{Dab, Hair};

/// Growth in one dab, as a share of the length.
const GROWTH: f32 = 0.06;
/// Shortest and longest, as shares of what the style gives.
const RANGE: (f32, f32) = (0.05, 6.0);

pub(super) fn length(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let factor = 1.0 + dab.sign() * GROWTH * hair.weight();
    hair.numbers.length = (hair.numbers.length * factor).clamp(RANGE.0, RANGE.1);
}
