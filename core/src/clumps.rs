//! Which strands keep together: for every clump size of a style stack, the strand in the middle of each
//! strand's clump.
//!
//! The first strands of a layer are spread evenly over the scalp, so the first n / size of them are the
//! middles of n / size clumps, and the middles of a coarser size are among those of a finer one. A strand
//! belongs to the nearest middle, by the distance of their roots, and clumps do not reach across a parting.
//! What a parting is, a hair mesh says by its topology: bundles that hold together from root to tip. So moving
//! its vertices changes no strand's clump. Imported strands have no topology; there the distance of their paths
//! counts too. Clumps nest: a fine clump lies in one lock. Clustering by k-means was rejected: every clump moves
//! when one strand is added.

use glam::Vec3;
use rayon::prelude::*;

use crate::hair_mesh::HairMesh;
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
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Path {
    pub root: Vec3,
    /// 0 in a hair mesh.
    pub to_middle: Vec3,
    pub to_tip: Vec3,
    /// In a hair mesh: the bundle.
    pub bundle: u32,
}

/// Which bundles of a hair mesh may share a clump.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BundleReach {
    /// Per bundle: itself and all within [`N_HOPS`] shared sides, ascending.
    within: Vec<Vec<u32>>,
}

/// A lock of a centimetre or three spans so many of the bundles that artists make.
const N_HOPS: usize = 3;

impl BundleReach {
    /// Two bundles hold together where a side is shared in every layer that both have.
    pub fn of(mesh: &HairMesh) -> Self {
        use std::collections::HashMap;
        let n_bundles = mesh.n_bundles();
        let mut on_root_edge: HashMap<[u32; 2], Vec<(usize, usize)>> = HashMap::new();
        for bundle in 0..n_bundles {
            let Some(face) = mesh.face(0, bundle) else { continue };
            for i in 0..face.len() {
                let (a, b) = (face[i], face[(i + 1) % face.len()]);
                on_root_edge.entry([a.min(b), a.max(b)]).or_default().push((bundle, i));
            }
        }
        // A side by its two corners, whichever way round the face goes.
        let side = |layer: usize, (bundle, i): (usize, usize)| {
            let face = mesh.face(layer, bundle)?;
            let (a, b) = (face[i], face[(i + 1) % face.len()]);
            Some([a.min(b), a.max(b)])
        };
        let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); n_bundles];
        for users in on_root_edge.values() {
            for (n, &a) in users.iter().enumerate() {
                for &b in &users[n + 1..] {
                    let holds = (1..mesh.layers.len())
                        .map_while(|layer| Some(side(layer, a)? == side(layer, b)?))
                        .all(|is_shared| is_shared);
                    if holds && a.0 != b.0 {
                        neighbours[a.0].push(b.0 as u32);
                        neighbours[b.0].push(a.0 as u32);
                    }
                }
            }
        }
        let mut within = Vec::with_capacity(n_bundles);
        for bundle in 0..n_bundles as u32 {
            let mut reached = vec![bundle];
            let mut first_of_ring = 0;
            for _ in 0..N_HOPS {
                let ring = first_of_ring..reached.len();
                first_of_ring = ring.end;
                for i in ring {
                    for next in neighbours[reached[i] as usize].iter().copied() {
                        if !reached.contains(&next) {
                            reached.push(next);
                        }
                    }
                }
            }
            reached.sort_unstable();
            within.push(reached);
        }
        Self { within }
    }

    pub fn reaches(&self, from: u32, to: u32) -> bool {
        self.within[from as usize].binary_search(&to).is_ok()
    }
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

    /// Find the clumps of strands in their order of detail; `reach` where the strands are a hair mesh's.
    pub fn of_style(style: &[StyleOp], paths: &[Path], reach: Option<&BundleReach>) -> Self {
        Self::find(Self::sizes_of(style), paths, reach, |_, _| None)
    }

    /// The same strands' clumps where bundles reach as in `after` and not as in `before`: a strand whose bundle
    /// reaches what it did keeps its clumps' middles without a search.
    pub fn reaching(&self, paths: &[Path], before: &BundleReach, after: &BundleReach) -> Self {
        let is_same: Vec<bool> = before.within.iter().zip(&after.within).map(|(a, b)| a == b).collect();
        let n_sizes = self.sizes.len();
        // A finer clump's middle is the middle of its own, so that what a search found is still known.
        let known = |size_idx: usize, member: usize| {
            let bundle = paths[member].bundle as usize;
            is_same.get(bundle).is_some_and(|same| *same).then(|| self.middles[member * n_sizes + size_idx])
        };
        Self::find(self.sizes.clone(), paths, Some(after), known)
    }

    /// `known` tells the nearest middle of a size for a member of it, where no search is needed.
    fn find(
        sizes: Vec<f32>,
        paths: &[Path],
        reach: Option<&BundleReach>,
        known: impl Fn(usize, usize) -> Option<u32> + Sync,
    ) -> Self {
        let n_sizes = sizes.len();
        let mut middles = vec![0; paths.len() * n_sizes];
        if paths.is_empty() || n_sizes == 0 {
            return Self { sizes, middles };
        }
        // Coarsest last: the members of a coarse clump are the middles of finer ones.
        let mut by_size: Vec<Vec<u32>> = Vec::with_capacity(n_sizes);
        let mut n_members = paths.len();
        for (size_idx, &size) in sizes.iter().enumerate() {
            let n_middles = ((paths.len() as f32 / size).round() as usize).clamp(1, n_members);
            let known = |member: usize| known(size_idx, member);
            by_size.push(nearest_middles(&paths[..n_members], n_middles, reach, known));
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

/// For each path the nearest of the first `n_middles`, or the one that is known.
fn nearest_middles(
    paths: &[Path],
    n_middles: usize,
    reach: Option<&BundleReach>,
    known: impl Fn(usize) -> Option<u32> + Sync,
) -> Vec<u32> {
    let may_share = |a: &Path, b: &Path| reach.is_none_or(|reach| reach.reaches(a.bundle, b.bundle));
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
            if let Some(known) = known(strand_idx) {
                return known;
            }
            let mut best = (f32::INFINITY, u32::MAX);
            grid.within(path.root, 2.5 * spacing, |middle, root_squared| {
                if root_squared < best.0 && may_share(path, &paths[middle]) {
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
                bundle: root.face,
            })
            .collect()
    }

    #[test]
    fn clumps_have_about_their_size_nest_and_do_not_cross_a_parting() {
        let paths = parted();
        let clumps = Clumps::of_style(&[clump(400.0), clump(40.0), clump(400.0), clump(1.0)], &paths, None);
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
        let clumps = Clumps::of_style(&[clump(1e6)], &parted()[..50], None);
        assert!(clumps.middles.iter().all(|&m| m == 0));
        assert!(Clumps::of_style(&[clump(10.0)], &[], None).middles.is_empty());
    }

    #[test]
    fn in_a_hair_mesh_the_topology_is_the_parting() {
        use crate::hair_mesh::Weld;
        let mut mesh = straight_grid(8, 0);
        let (left, right): (Vec<usize>, Vec<usize>) = (0..64).partition(|bundle| bundle % 8 < 4);
        mesh.extrude(&left, Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
        mesh.extrude(&right, Weld::Apart, |v| v.position + Vec3::Y).unwrap();
        let reach = BundleReach::of(&mesh);
        assert!(reach.reaches(3, 0) && reach.reaches(3, 11) && !reach.reaches(3, 4) && !reach.reaches(0, 24 + 1));
        let paths: Vec<Path> =
            parted().into_iter().map(|path| Path { to_middle: Vec3::ZERO, to_tip: Vec3::ZERO, ..path }).collect();
        let clumps = Clumps::of_style(&[clump(40.0)], &paths, Some(&reach));
        for (strand_idx, path) in paths.iter().enumerate() {
            let middle = &paths[clumps.middle(strand_idx, Some(0))];
            assert_eq!(path.root.x < 4.0, middle.root.x < 4.0);
        }
    }
}
