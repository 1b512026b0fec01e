//! Delete: hair that the brush touches gets thinner until none is left; inverted, what was deleted comes back.

use super::{Dab, Hair};

/// Share of the hair that goes in one dab in the middle of a brush of full strength.
const SHARE: f32 = 0.4;

pub(super) fn delete(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let keep = hair.numbers.keep;
    let most = keep.max(1.0);
    hair.numbers.keep = (keep - dab.sign() * SHARE * hair.weight()).clamp(0.0, most);
}
