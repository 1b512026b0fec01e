//! Add: deleted hair comes back, and where none is missing more grows than the style has.

use super::delete::delete;
use super::{Dab, Hair};
use crate::sculpt::planting::DENSEST;

/// Share of the hair that comes back in one dab in the middle of a brush of full strength.
const BACK: f32 = 0.4;
/// Strands that are planted in one such dab, for each that the style has: a stroke about doubles them.
const PLANTED: f32 = 0.12;

pub(super) fn add(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    if dab.is_inverted {
        return delete(hair, &Dab { is_inverted: false, ..*dab });
    }
    let keep = &mut hair.numbers.keep;
    let weight = hair.weights.iter().copied().fold(0.0, f32::max);
    *keep = if *keep < 1.0 { (*keep + BACK * weight).min(1.0) } else { (*keep + PLANTED * weight).min(DENSEST) };
}
