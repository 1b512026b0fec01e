//! Part: hair goes to the side of the stroke on which its root stands.

use glam::Vec2;

use super::{Dab, Hair};

/// How far a point goes to its side in one dab, in radii of the brush.
const ASIDE: f32 = 0.25;

pub(super) fn part(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let along = (dab.at - dab.before).normalize_or(Vec2::ZERO);
    let Some(root) = dab.view.project(hair.points[0]).filter(|_| along != Vec2::ZERO) else { return };
    let across = along.perp();
    let side = if (root - dab.at).dot(across) < 0.0 { -dab.sign() } else { dab.sign() };
    let aside = ASIDE * dab.radius_cm / dab.view.cm_per_point(dab.centre).max(1e-6);
    for (p, weight) in hair.points.iter_mut().zip(hair.weights).skip(1) {
        if weight > 0.0 {
            *p += dab.view.move_at(*p, side * aside * weight * across);
        }
    }
}
