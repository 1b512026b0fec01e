//! Curl: the hair rolls up in the plane of the picture, from where the brush touches it to the tip.

use glam::Quat;

use super::super::K;
use super::{Dab, Hair};

/// Bend of a segment in one dab, radians.
const BEND: f32 = 0.12;

pub(super) fn curl(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    for k in 1..K {
        if hair.weights[k] <= 0.0 {
            continue;
        }
        let bend = Quat::from_axis_angle(dab.view.forward, dab.sign() * BEND * hair.weights[k]);
        let pivot = hair.points[k - 1];
        for p in &mut hair.points[k..] {
            *p = pivot + bend * (*p - pivot);
        }
    }
}
