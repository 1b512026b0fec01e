//! Delete: hair that the brush touches gets thinner until none is left.

use super::{Dab, Hair};

/// Share of the hair that goes in one dab in the middle of a brush of full strength.
const SHARE: f32 = 0.4;

pub(super) fn delete(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    thin_out(hair, dab.sign());
}

/// Take hair away, or with a negative sign bring it back.
pub(super) fn thin_out(hair: &mut Hair<'_>, sign: f32) {
    hair.numbers.keep = (hair.numbers.keep - sign * SHARE * hair.weight()).clamp(0.0, 1.0);
}
