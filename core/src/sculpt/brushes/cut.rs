//! Cut: what lies beyond the brush, from the root's point of view, falls off; inverted, cut hair comes back.

use super::super::K;
use super::{Dab, Hair};

/// Share of the path that comes back in one dab.
const BACK: f32 = 0.08;
/// The shortest stubble, as a share of the path.
const SHORTEST: f32 = 0.02;
/// Places looked at along a segment.
const FINE: usize = 16;

pub(super) fn cut(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    if dab.is_inverted {
        hair.numbers.cut = (hair.numbers.cut + BACK * hair.weight()).min(1.0);
        return;
    }
    // Scissors cut whatever the strength; only who is frozen or on the far side has no weight.
    if hair.weight() <= 0.0 {
        return;
    }
    for k in 1..K {
        let (a, b) = (hair.points[k - 1], hair.points[k]);
        for step in 1..=FINE {
            let x = step as f32 / FINE as f32;
            let at = ((k - 1) as f32 + x) / (K - 1) as f32;
            if at >= hair.shown {
                return;
            }
            if hair.weights[k - 1].max(hair.weights[k]) > 0.0 && dab.reach(a.lerp(b, x)) > 0.0 {
                hair.numbers.cut = hair.numbers.cut.min((at / hair.left).max(SHORTEST));
                return;
            }
        }
    }
}
