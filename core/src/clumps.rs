//! Which strands keep together: for every clump size of a style stack, the strand in the middle of each
//! strand's clump.
//!
//! The first strands of a layer are spread evenly over the scalp, so the first n / size of them are the
//! middles of n / size clumps, and the middles of a coarser size are among those of a finer one. A strand
//! belongs to the nearest middle, by the distance of their roots and of their paths: so clumps do not
//! reach across a parting. Clumps nest: a fine clump lies in one lock. Clustering by k-means was
//! rejected: every clump moves when one strand is added.

use glam::Vec3;
use rayon::prelude::*;

use crate::point_grid::PointGrid;
use crate::style::{StyleKind, StyleOp};

/// What a squared difference between two strands' paths counts against one between their roots.
const PATH_WEIGHT: f32 = 0.2;

/// The middle strands of each strand's clumps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Clumps {
    /// Strands a clump: the distinct sizes above 1 of the stack's operators, finest first.
    pub sizes: Vec<f32>,
    /// Strand `s`'s middle strand for `sizes[g]` is `middles[s * sizes.len() + g]`.
    pub middles: Vec<u32>,
}

/// What clumps are found by: the root, and the path from there to two places up the strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    pub root: Vec3,
    pub to_middle: Vec3,
    pub to_tip: Vec3,
}

impl Path {
    fn distance_squared(&self, other: &Self) -> f32 {
        self.root.distance_squared(other.root)
            + PATH_WEIGHT
                * (self.to_middle.distance_squared(other.to_middle) + 0.25 * self.to_tip.distance_squared(other.to_tip))
    }
}

impl Clumps {
    /// The distinct clump sizes above 1 of a stack's operators, finest first.
    pub fn sizes_of(style: &[StyleOp]) -> Vec<f32> {
        let mut sizes: Vec<f32> = style
            .iter()
            .filter(|op| op.on && op.strength != 0.0)
            .map(|op| op.kind.strands_per_clump())
            .filter(|&size| size > 1.0)
            .collect();
        sizes.sort_by(f32::total_cmp);
        sizes.dedup();
        sizes
    }

    /// Find the clumps of strands in their order of detail.
    pub fn of_style(style: &[StyleOp], paths: &[Path]) -> Self {
        let sizes = Self::sizes_of(style);
        let n_sizes = sizes.len();
        let mut middles = vec![0; paths.len() * n_sizes];
        if paths.is_empty() || n_sizes == 0 {
            return Self { sizes, middles };
        }
        // Coarsest first: a fine middle's own coarse clumps are known when its members inherit them.
        let mut by_size: Vec<Vec<u32>> = Vec::with_capacity(n_sizes);
        let mut n_members = paths.len();
        for &size in &sizes {
            let n_middles = ((paths.len() as f32 / size).round() as usize).clamp(1, n_members);
            by_size.push(nearest_middles(&paths[..n_members], n_middles));
            n_members = n_middles;
        }
        for (strand_idx, of_strand) in middles.chunks_exact_mut(n_sizes).enumerate() {
            let mut member = strand_idx as u32;
            for (middle, nearest) in of_strand.iter_mut().zip(&by_size) {
                member = nearest[member as usize];
                *middle = member;
            }
        }
        Self { sizes, middles }
    }

    /// Index into `sizes` of an operator's clumps; `None` where every strand is on its own.
    pub fn size_idx(&self, kind: StyleKind) -> Option<usize> {
        let size = kind.strands_per_clump();
        self.sizes.iter().position(|&s| s == size)
    }

    /// The strand whose random numbers `strand_idx` shares under an operator.
    pub fn middle(&self, strand_idx: usize, size_idx: Option<usize>) -> usize {
        size_idx.map_or(strand_idx, |g| self.middles[strand_idx * self.sizes.len() + g] as usize)
    }
}

/// For each path the nearest of the first `n_middles`.
fn nearest_middles(paths: &[Path], n_middles: usize) -> Vec<u32> {
    let roots: Vec<Vec3> = paths[..n_middles].iter().map(|path| path.root).collect();
    // The middles' spacing: the mean distance of neighbours among some of them.
    let first = roots.first().copied().unwrap_or_default();
    let (lo, hi) = roots.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let coarse = PointGrid::new(&roots, (hi - lo).max_element() / (n_middles as f32).sqrt());
    let n_measured = n_middles.min(256);
    let spacing = roots[..n_measured].iter().map(|&p| coarse.nearest::<2>(p).0[1].1).filter(|d| d.is_finite());
    let spacing = (spacing.sum::<f32>() / n_measured as f32).sqrt().max(1e-4);
    let grid = PointGrid::new(&roots, spacing);
    paths
        .par_iter()
        .enumerate()
        .map(|(strand_idx, path)| {
            if strand_idx < n_middles {
                return strand_idx as u32;
            }
            let mut best = (f32::INFINITY, u32::MAX);
            grid.within(path.root, 2.5 * spacing, |middle, root_squared| {
                if root_squared < best.0 {
                    let squared = path.distance_squared(&paths[middle]);
                    best = if (squared, middle as u32) < best { (squared, middle as u32) } else { best };
                }
            });
            if best.1 == u32::MAX { grid.nearest::<1>(path.root).0[0].0 as u32 } else { best.1 }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::tests::straight_grid;
    use crate::roots::RootSurface;

    fn clump(strands_per_clump: f32) -> StyleOp {
        StyleOp::new(StyleKind::Clump { strands_per_clump, flare: 0.0, stray: 0.0 })
    }

    /// Strands on a square of side 8 that fall to either side of x = 4.
    fn parted() -> Vec<Path> {
        let roots = RootSurface::of_hair_mesh(&straight_grid(8, 1)).sequence(4000, 5);
        let side = |x: f32| if x < 4.0 { -1.0 } else { 1.0 };
        roots
            .iter()
            .map(|root| Path {
                root: root.position,
                to_middle: Vec3::new(4.0 * side(root.position.x), -2.0, 0.0),
                to_tip: Vec3::new(6.0 * side(root.position.x), -9.0, 0.0),
            })
            .collect()
    }

    #[test]
    fn clumps_have_about_their_size_nest_and_do_not_cross_a_parting() {
        let paths = parted();
        let clumps = Clumps::of_style(&[clump(400.0), clump(40.0), clump(400.0), clump(1.0)], &paths);
        assert_eq!(clumps.sizes, [40.0, 400.0]);
        let mut lock_of_clump = vec![None; 100];
        let mut n_members = vec![0; 100];
        for (strand_idx, path) in paths.iter().enumerate() {
            let fine = clumps.middle(strand_idx, Some(0));
            let lock = clumps.middle(strand_idx, Some(1));
            assert!(fine < 100 && lock < 10);
            n_members[fine] += 1;
            assert_eq!(*lock_of_clump[fine].get_or_insert(lock), lock);
            assert!((paths[fine].root.x < 4.0) == (path.root.x < 4.0), "a clump crosses the parting");
        }
        assert!(n_members.iter().all(|&n| (8..=120).contains(&n)), "{n_members:?}");
    }

    #[test]
    fn a_clump_larger_than_the_layer_is_one_clump() {
        let clumps = Clumps::of_style(&[clump(1e6)], &parted()[..50]);
        assert!(clumps.middles.iter().all(|&m| m == 0));
        assert!(Clumps::of_style(&[clump(10.0)], &[]).middles.is_empty());
    }
}
