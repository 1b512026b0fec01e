//! Each strand's share in the sculpt guides around it.
//!
//! A strand takes from its three nearest guides on its own side of partings, by the weights of Franke and
//! Nielson 1980 (modified Shepard) with the fourth guide's distance as reach: a guide loses all its weight
//! before another takes its place, so the displaced hair has no seams. Barycentric weights were rejected:
//! three nearest guides need not stand around the strand.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::{GuidePaths, SculptRoots};
use crate::binding::{LayerBinding, same_side};
use crate::groom::{Head, Layer};
use crate::point_grid::PointGrid;

/// A strand farther from every guide than this is not sculpted, in centimetres.
const REACH: f32 = 2.5;

/// Three guides and their weights, which sum to 1, or are 0 where no guide is near. As the GPU reads it.
#[derive(Debug, Clone, Copy, PartialEq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Share {
    pub guides: [u32; 3],
    pub pad_0: u32,
    pub weights: [f32; 3],
    pub pad_1: f32,
}

/// The shares of a layer's strands; empty where it has no sculpt guides.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SculptShares {
    /// The guides that they are shares of.
    pub roots: Arc<SculptRoots>,
    /// One a strand.
    pub shares: Vec<Share>,
}

impl SculptShares {
    /// Whether these are the shares of `n_strands` strands in those guides.
    pub fn are_of(&self, roots: &Arc<SculptRoots>, n_strands: usize) -> bool {
        let n_shares = if roots.positions.is_empty() { 0 } else { n_strands };
        self.shares.len() == n_shares && (n_shares == 0 || Arc::ptr_eq(&self.roots, roots))
    }

    /// Find the shares of a layer's strands.
    pub fn find(binding: &LayerBinding, layer: &Layer, head: Option<&Head>) -> Self {
        let roots = &layer.sculpt.roots;
        if roots.positions.is_empty() {
            return Self::default();
        }
        let paths = GuidePaths::new(layer, head, roots);
        let there: Vec<u32> = (0..paths.n_guides() as u32).filter(|&g| paths.is_there[g as usize]).collect();
        let positions: Vec<Vec3> = there.iter().map(|&g| roots.positions[g as usize]).collect();
        let towards: Vec<Vec3> = there.iter().map(|&g| paths.towards(g as usize)).collect();
        let grid = PointGrid::new(&positions, 0.5);
        let n_vertices = binding.guides.n_vertices as usize;
        let share_of = |strand_idx: usize| -> Share {
            let at = |vertex: usize| -> Vec3 {
                let of_guide = |i: &crate::guides::Influence| {
                    i.weight * binding.guides.positions[i.guide_idx as usize * n_vertices + vertex]
                };
                binding.influences(strand_idx).iter().map(of_guide).sum()
            };
            let strand_towards = (at(n_vertices / 2) - at(0)).normalize_or(Vec3::Y);
            share(&same_side(&grid, &towards, binding.roots[strand_idx], strand_towards), &there)
        };
        let shares = if there.is_empty() {
            vec![Share::default(); binding.n_strands()]
        } else {
            (0..binding.n_strands()).into_par_iter().map(share_of).collect()
        };
        Self { roots: Arc::clone(roots), shares }
    }
}

/// The share of a place in the guides around it, whatever side of a parting they are on.
pub(super) fn nearest_share(grid: &PointGrid<'_>, names: &[u32], p: Vec3) -> Share {
    let (nearest, n_found) = grid.nearest::<4>(p);
    share(&nearest.map(|(guide, squared)| (guide, squared.sqrt()))[..n_found], names)
}

/// The share of a strand whose nearest guides are these; `names` are the guides' numbers.
fn share(nearest: &[(usize, f32)], names: &[u32]) -> Share {
    let mut share = Share::default();
    let Some(&(_, first)) = nearest.first() else { return share };
    if first > REACH {
        return share;
    }
    // Two places of the sequence may coincide only by accident; the weight of a guide underfoot is finite.
    let end = nearest.get(3).map_or_else(|| 2.0 * nearest[nearest.len() - 1].1, |&(_, d)| d).max(1e-4);
    for (i, &(root, distance)) in nearest.iter().take(3).enumerate() {
        let d = distance.max(1e-4);
        share.guides[i] = names[root];
        share.weights[i] = ((end - d).max(0.0) / (end * d)).powi(2);
    }
    let sum: f32 = share.weights.iter().sum();
    if sum > 0.0 {
        share.weights.iter_mut().for_each(|w| *w /= sum);
    } else {
        share.weights = [1.0, 0.0, 0.0];
    }
    share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_one_at_a_guide_and_do_not_jump_when_guides_change_places() {
        let names = [10, 11, 12, 13, 14];
        let at = share(&[(2, 0.0), (1, 0.4), (0, 0.4), (3, 0.5)], &names);
        assert_eq!(at.guides[0], 12);
        assert!(at.weights[0] > 0.999);
        // The third and the fourth are equally far: neither counts, so they may change places unseen.
        let at = share(&[(0, 0.1), (1, 0.2), (2, 0.3), (3, 0.3)], &names);
        assert!(at.weights[2] < 1e-6 && (at.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        assert_eq!(share(&[(0, 3.0)], &names).weights, [0.0; 3]);
        assert_eq!(share(&[(0, 0.2)], &names).weights, [1.0, 0.0, 0.0]);
    }
}
