//! What holds for hair whatever a brush did to it: every segment keeps its length, and none enters the head.

use glam::{Mat3, Vec3};

use super::{K, SculptGuide};
use crate::distance_field::DistanceField;
use crate::generate::{GROW_OUT, KEEP_OUT};

/// Distance from the scalp that brushed hair keeps, in centimetres, once it has grown out of it. Generation
/// spreads hair that lies closer than [`KEEP_OUT`] anyway.
const MARGIN: f32 = 0.1;

/// Lengths of a path's segments, centimetres.
pub fn segment_lengths(points: &[Vec3; K]) -> [f32; K - 1] {
    std::array::from_fn(|k| points[k].distance(points[k + 1]))
}

/// How far from the head a point must stay that is `arc_length` up the hair.
fn margin(arc_length: f32) -> f32 {
    let x = (arc_length / GROW_OUT).clamp(0.0, 1.0);
    MARGIN * x * x * (3.0 - 2.0 * x)
}

/// The guide as it is seen: its path displaced, with its lengths, out of the head. As generation does it, for a
/// strand of middling distance.
pub fn shown(path: &[Vec3; K], guide: &SculptGuide, frame: &Mat3, field: Option<&DistanceField>) -> [Vec3; K] {
    let displaced: [Vec3; K] = std::array::from_fn(|k| path[k] + *frame * Vec3::from_array(guide.offsets[k]));
    let mut points = displaced;
    for k in 1..K {
        let segment = guide.length * path[k].distance(path[k - 1]);
        points[k] = points[k - 1] + segment * (displaced[k] - displaced[k - 1]).normalize_or(Vec3::ZERO);
    }
    let Some(field) = field else { return points };
    let mut arc_length = 0.0;
    for k in 1..K {
        arc_length += path[k].distance(path[k - 1]);
        let x = (arc_length / GROW_OUT).clamp(0.0, 1.0);
        let margin = KEEP_OUT * x * x * (3.0 - 2.0 * x) + 1e-3;
        let distance = field.sample(points[k]);
        if distance < margin {
            let out = field.gradient(points[k]).normalize_or(Vec3::ZERO);
            points[k] += (margin * (distance / margin - 1.0).exp() - distance) * out;
        }
    }
    points
}

/// What a segment does when the one before it could not go where a brush wanted it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follow {
    /// Goes where its end was drawn to: hair that is pulled trails.
    Pulled,
    /// Keeps the direction that the brush gave it: hair that is bent.
    Turned,
}

/// Give every segment its length again, from the root on, and turn those that enter the head out of it.
pub fn solve(
    points: &mut [Vec3; K],
    lengths: &[f32; K - 1],
    normal: Vec3,
    follow: Follow,
    field: Option<&DistanceField>,
) {
    let wanted = *points;
    let mut before = normal;
    let mut arc_length = 0.0;
    for k in 1..K {
        let length = lengths[k - 1];
        let from = points[k - 1];
        let turned = (wanted[k] - wanted[k - 1]).normalize_or(before);
        let pulled = (wanted[k] - from).normalize_or(turned);
        let towards = match follow {
            // Pulled back over itself it would fold.
            Follow::Pulled if pulled.dot(turned) > 0.0 => pulled,
            Follow::Pulled | Follow::Turned => turned,
        };
        arc_length += length;
        let towards = field.map_or(towards, |field| {
            clear(field, from, towards, length, margin(arc_length), if k == 1 { normal } else { before })
        });
        points[k] = from + length * towards;
        before = towards;
    }
}

/// The direction nearest to `towards` in which a segment from `from` ends at least `margin` from the head.
fn clear(field: &DistanceField, from: Vec3, towards: Vec3, length: f32, margin: f32, before: Vec3) -> Vec3 {
    /// Halvings: a hundredth of a degree.
    const STEPS: usize = 14;
    let is_clear = |direction: Vec3| field.sample(from + length * direction) >= margin;
    if is_clear(towards) {
        return towards;
    }
    let out = field.gradient(from).normalize_or(before);
    // Straight in: leave by the side that the hair comes from.
    let towards = if towards.dot(out) < -0.99 {
        (towards + 0.2 * (before + out.any_orthonormal_vector())).normalize()
    } else {
        towards
    };
    let (mut inside, mut outside) = (0.0_f32, 1.0_f32);
    let turned = |x: f32| towards.lerp(out, x).normalize_or(out);
    for _ in 0..STEPS {
        let middle = 0.5 * (inside + outside);
        if is_clear(turned(middle)) {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    turned(outside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh_query::tests::sphere;

    #[test]
    fn lengths_are_kept_and_nothing_enters_the_ball() {
        let field = DistanceField::from_mesh(&sphere(Vec3::ZERO, 8.0, 48), 64).unwrap();
        for tilt in 0..12 {
            let normal = Vec3::Y;
            // Hair that is pressed through the ball.
            let aim = Vec3::new((tilt as f32 * 0.5).sin(), -1.0, (tilt as f32 * 0.5).cos() - 0.8).normalize();
            let mut points: [Vec3; K] = std::array::from_fn(|k| Vec3::Y * 8.02 + 1.1 * k as f32 * aim);
            let lengths = std::array::from_fn(|k| 0.5 + 0.04 * k as f32);
            solve(&mut points, &lengths, normal, Follow::Pulled, Some(&field));
            for k in 1..K {
                assert!((points[k].distance(points[k - 1]) - lengths[k - 1]).abs() < 1e-4);
                assert!(field.sample(points[k]) > 0.0, "{tilt} {k}: {}", field.sample(points[k]));
            }
        }
    }
}
