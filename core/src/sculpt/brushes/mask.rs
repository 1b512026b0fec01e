//! Mask: the sculpt layer acts less where it was painted, as far as it is masked at all.

use super::{Dab, Hair};

/// Share of the way to fully masked in one dab in the middle of a brush of full strength.
const SHARE: f32 = 0.5;

pub(super) fn mask(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    hair.numbers.masked = (hair.numbers.masked + dab.sign() * SHARE * hair.weight()).clamp(0.0, 1.0);
}
