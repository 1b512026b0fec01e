//! How much hair each guide stands for: where guides stand far apart, each stands for more.
//!
//! Hair grows about as densely wherever there is any, so a guide stands for the scalp around its root: its share is one over
//! the number of roots within reach, itself included. Reach is chosen so that a guide has a dozen of neighbours on average:
//! with fewer, the count of a random scatter would be noise. The binding's own numbers, strands by their weights, were
//! rejected: they change with every stroke of painted density and would make all kept frames others.

use std::collections::HashMap;

use glam::{IVec3, Vec3, Vec4Swizzles};

use crate::rest::Rest;

/// Roots within reach, on average.
const N_NEIGHBOURS: f32 = 12.0;
/// The share of one guide over the mean.
const RANGE: (f32, f32) = (0.1, 10.0);

/// Of each guide: hairs that it stands for, over those of the mean.
pub(crate) fn shares_of(rest: &Rest) -> Vec<f32> {
    let n = rest.n_vertices.max(1) as usize;
    let roots: Vec<Vec3> = rest.vertices.chunks_exact(n).map(|guide| guide[0].xyz()).collect();
    let (low, high) = roots.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let size = high - low;
    // Of a dome over the box, about; of what is flat, the flat itself.
    let area = size.x * size.y + size.y * size.z + size.z * size.x;
    let reach = (N_NEIGHBOURS * area / (std::f32::consts::PI * roots.len().max(1) as f32)).sqrt();
    if roots.len() < 3 || !(reach.is_finite() && reach > 1e-3) {
        return vec![1.0; roots.len()];
    }
    let cell_of = |p: Vec3| ((p - low) / reach).floor().as_ivec3();
    let mut cells: HashMap<IVec3, Vec<Vec3>> = HashMap::new();
    for &root in &roots {
        cells.entry(cell_of(root)).or_default().push(root);
    }
    let n_within = |root: &Vec3| -> f32 {
        let cell = cell_of(*root);
        let around = (0..27).map(|i| cell + IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
        let near = around.filter_map(|cell| cells.get(&cell)).flatten();
        // A smooth rim, so that a root that is a hair's breadth farther changes little.
        near.map(|p| (1.0 - p.distance_squared(*root) / (reach * reach)).max(0.0)).sum()
    };
    let shares: Vec<f32> = roots.iter().map(|root| 1.0 / n_within(root).max(1e-3)).collect();
    let mean = shares.iter().sum::<f32>() / shares.len() as f32;
    shares.into_iter().map(|share| (share / mean).clamp(RANGE.0, RANGE.1)).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec4;

    use super::*;

    /// Guides of two vertices that stand on a plane, four times as many a square on the right.
    fn uneven() -> Rest {
        let mut vertices = Vec::new();
        let mut add = |x: f32, z: f32| vertices.extend([Vec4::new(x, 0.0, z, 0.0), Vec4::new(x, 1.0, z, 0.0)]);
        for i in 0..20 {
            for j in 0..40 {
                add(0.25 + 0.5 * i as f32, 0.25 + 0.5 * j as f32);
                if i % 2 == 0 && j % 2 == 0 {
                    add(-0.5 - 0.5 * i as f32, 0.5 + 0.5 * j as f32);
                }
            }
        }
        Rest { n_vertices: 2, vertices, ties: Vec::new(), following: None }
    }

    #[test]
    fn where_guides_stand_far_apart_each_stands_for_more() {
        let rest = uneven();
        let shares = shares_of(&rest);
        let mean_of = |is_right: bool| {
            // Away from the rims, where there are no neighbours on one side.
            let is_inner = |p: Vec4| p.x.abs() > 3.0 && p.x.abs() < 7.0 && p.z > 3.0 && p.z < 17.0;
            let of: Vec<f32> = (rest.vertices.chunks(2).zip(&shares))
                .filter(|(guide, _)| (guide[0].x > 0.0) == is_right && is_inner(guide[0]))
                .map(|(_, share)| *share)
                .collect();
            of.iter().sum::<f32>() / of.len() as f32
        };
        let ratio = mean_of(false) / mean_of(true);
        assert!((ratio - 4.0).abs() < 0.4, "{ratio}");
        assert!((shares.iter().sum::<f32>() / shares.len() as f32 - 1.0).abs() < 0.05);
    }

    #[test]
    fn no_guide_one_guide_and_broken_numbers_are_harmless() {
        assert!(shares_of(&Rest::default()).is_empty());
        let one = Rest { n_vertices: 2, vertices: vec![Vec4::ONE; 2], ties: Vec::new(), following: None };
        assert_eq!(shares_of(&one), [1.0]);
        let same = Rest { n_vertices: 2, vertices: vec![Vec4::ONE; 20], ties: Vec::new(), following: None };
        assert_eq!(shares_of(&same), [1.0; 10]);
        let far = Rest {
            n_vertices: 1,
            vertices: vec![Vec4::ZERO, Vec4::splat(1e30), Vec4::ONE],
            ties: Vec::new(),
            following: None,
        };
        assert!(shares_of(&far).iter().all(|share| share.is_finite()));
    }
}
