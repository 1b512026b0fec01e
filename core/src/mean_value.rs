//! Mean value coordinates of a point in a polygon (Floater 2003): how a strand's root is written down as
//! weights of its face's corners, for faces with any number of corners.
//!
//! In 3D the angles are measured where they are, so a slightly warped quad needs no plane; for a planar
//! polygon the coordinates reproduce the point exactly. Bilinear coordinates were rejected: they know
//! only quads.

use glam::{DVec3, Vec3};

/// Below this share of the polygon's size a point counts as lying on a corner or an edge.
const ON_BORDER: f64 = 1e-9;

/// Weights of `corners` at `p`, which lies in the polygon; they sum to 1. Non-negative in convex
/// polygons; on a corner or an edge only its own corners have weight. At least three corners.
pub fn mean_value_weights(corners: &[Vec3], p: Vec3) -> Vec<f32> {
    let n = corners.len();
    let p = p.as_dvec3();
    let d: Vec<DVec3> = corners.iter().map(|c| c.as_dvec3() - p).collect();
    let r: Vec<f64> = d.iter().map(|d| d.length()).collect();
    let size = r.iter().copied().fold(0.0, f64::max);

    if let Some(on_corner) = r.iter().position(|&r| r <= ON_BORDER * size) {
        return (0..n).map(|i| if i == on_corner { 1.0 } else { 0.0 }).collect();
    }
    // The polygon's area vector, seen from p: it tells a reflex angle of a concave polygon.
    let area: DVec3 = (0..n).map(|i| d[i].cross(d[(i + 1) % n])).sum();
    // Compute tan(alpha_i / 2) = sin / (1 + cos) of the angle between corner i and the next.
    let mut tan_half = vec![0.0; n];
    for i in 0..n {
        let j = (i + 1) % n;
        let cross = d[i].cross(d[j]);
        let one_plus_cos = r[i] * r[j] + d[i].dot(d[j]);
        if cross.length() <= ON_BORDER * size * size && one_plus_cos <= ON_BORDER * size * size {
            // Between the two corners: linear along the edge.
            let mut weights = vec![0.0; n];
            weights[i] = (r[j] / (r[i] + r[j])) as f32;
            weights[j] = 1.0 - weights[i];
            return weights;
        }
        tan_half[i] = (cross.length() / one_plus_cos).copysign(cross.dot(area));
    }
    // Floater 2003, eq. 2.1.
    let w: Vec<f64> = (0..n).map(|i| (tan_half[(i + n - 1) % n] + tan_half[i]) / r[i]).collect();
    let sum: f64 = w.iter().sum();
    w.iter().map(|w| (w / sum) as f32).collect()
}

/// As [`mean_value_weights`], none below 0: in a face that is not convex mean values can be far below 0, and a strand
/// with such weights would leave its lock.
pub fn weights_within(corners: &[Vec3], p: Vec3) -> Vec<f32> {
    let mut weights = mean_value_weights(corners, p);
    let sum: f32 = weights.iter().map(|w| w.max(0.0)).sum();
    for w in &mut weights {
        *w = w.max(0.0) / sum;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn blend(corners: &[Vec3], weights: &[f32]) -> Vec3 {
        corners.iter().zip(weights).map(|(c, w)| *c * *w).sum()
    }

    /// A regular polygon in a tilted plane.
    fn polygon(n: usize) -> Vec<Vec3> {
        let rotation = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.3);
        (0..n)
            .map(|i| {
                let (sin, cos) = (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
                rotation * Vec3::new(2.0 * cos, 1.2 * sin, 0.0) + Vec3::new(3.0, -1.0, 7.0)
            })
            .collect()
    }

    proptest! {
        #[test]
        fn weights_reproduce_the_point_and_sum_to_one(n in 3_usize..9, mix in prop::collection::vec(0.0_f32..1.0, 9)) {
            let corners = polygon(n);
            let total: f32 = mix[..n].iter().sum::<f32>().max(1e-3);
            let p = blend(&corners, &mix[..n].iter().map(|m| m / total).collect::<Vec<_>>());
            prop_assume!(mix[..n].iter().sum::<f32>() > 1e-3);
            let weights = mean_value_weights(&corners, p);
            prop_assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
            prop_assert!(weights.iter().all(|w| *w >= -1e-4));
            prop_assert!(blend(&corners, &weights).distance(p) < 1e-4, "{weights:?}");
        }
    }

    #[test]
    fn corners_and_edges_use_only_themselves() {
        let corners = polygon(5);
        for i in 0..5 {
            let weights = mean_value_weights(&corners, corners[i]);
            assert_eq!(weights[i], 1.0);
            for share in [1e-6, 0.25, 0.5, 1.0 - 1e-6] {
                let weights = mean_value_weights(&corners, corners[i].lerp(corners[(i + 1) % 5], share));
                assert!(weights.iter().all(|w| w.is_finite()));
                assert!((weights[i] - (1.0 - share)).abs() < 1e-3, "{share}: {weights:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn concave_polygons_of_any_number_of_corners_reproduce_points_continuously(
            radii in prop::collection::vec(0.4_f32..3.0, 3..12), share in 0.0_f32..0.9, turn in 0.0_f32..1.0,
        ) {
            // A star around its middle, in a tilted plane: concave wherever a corner is nearer than its neighbours.
            let n = radii.len();
            let rotation = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.3);
            let corner = |i: usize| {
                let (sin, cos) = (i as f32 / n as f32 * std::f32::consts::TAU).sin_cos();
                rotation * (radii[i % n] * Vec3::new(cos, sin, 0.0)) + Vec3::new(3.0, -1.0, 7.0)
            };
            let corners: Vec<Vec3> = (0..n).map(corner).collect();
            let at = turn * n as f32;
            let border = corner(at as usize % n).lerp(corner((at as usize + 1) % n), at.fract());
            let p = Vec3::new(3.0, -1.0, 7.0).lerp(border, share);
            let weights = mean_value_weights(&corners, p);
            prop_assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-4, "{weights:?}");
            prop_assert!(blend(&corners, &weights).distance(p) < 1e-3, "{weights:?}");
            // A step to the side changes them little: strands do not jump.
            let beside = mean_value_weights(&corners, p + rotation * Vec3::new(1e-3, 1e-3, 0.0));
            prop_assert!(weights.iter().zip(&beside).all(|(a, b)| (a - b).abs() < 0.05), "{weights:?} {beside:?}");
        }
    }

    #[test]
    fn concave_polygons_still_reproduce_the_point() {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        let p = Vec3::new(0.7, 1.5, 0.0);
        let weights = mean_value_weights(&corners, p);
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        assert!(blend(&corners, &weights).distance(p) < 1e-4);
    }
}
