//! Pinch: hair comes together under the pointer; inverted, it spreads.

use super::{Dab, Hair};

/// Share of the way to the pointer that a point goes in one dab.
const SHARE: f32 = 0.25;

pub(super) fn pinch(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    for (p, weight) in hair.points.iter_mut().zip(hair.weights).skip(1) {
        let Some(at) = dab.view.project(*p).filter(|_| weight > 0.0) else { continue };
        *p += dab.view.move_at(*p, dab.sign() * SHARE * weight * (dab.at - at));
    }
}
