//! Slide: roots move over the scalp with the pointer and take their hair along.

use super::{Dab, Hair, mirrored};

/// Corrections towards the scalp; each leaves a small part of the error.
const STEPS: usize = 4;

pub(super) fn slide(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    let root = hair.points[0];
    let weight = hair.weights[0];
    if weight <= 0.0 {
        return;
    }
    let mut to = root + weight * dab.movement_at(root);
    match dab.field {
        // As far from the surface as before: a field's surface and the scalp differ by a little.
        Some(field) => {
            let mirror = |p| if dab.is_mirrored { mirrored(p) } else { p };
            let height = field.sample(mirror(root));
            for _ in 0..STEPS {
                to -= (field.sample(mirror(to)) - height) * dab.outwards(to, hair.normal);
            }
        }
        None => to -= (to - root).dot(hair.normal) * hair.normal,
    }
    hair.points.iter_mut().for_each(|p| *p += to - root);
}
