//! Freeze: other brushes leave the hair alone; inverted, it thaws.

use super::{Dab, Hair};

/// Share of the way to frozen in one dab in the middle of a brush of full strength.
const SHARE: f32 = 0.5;

pub(super) fn freeze(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    hair.numbers.frozen = (hair.numbers.frozen + dab.sign() * SHARE * hair.weight()).clamp(0.0, 1.0);
}
