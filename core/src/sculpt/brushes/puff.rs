//! Puff: hair rises off the head; inverted, it lies down.

use super::{Dab, Hair};

/// How far a point rises in one dab, in radii of the brush.
const RISE: f32 = 0.18;

pub(super) fn puff(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let rise = dab.sign() * RISE * dab.radius_cm;
    for (p, weight) in hair.points.iter_mut().zip(hair.weights).skip(1) {
        if weight > 0.0 {
            *p += weight * rise * dab.outwards(*p, hair.normal);
        }
    }
}
