//! Where strands grow: a sequence of places on the root surface, evenly spread by area, every beginning
//! of which is evenly spread too.
//!
//! The sequence is best-candidate sampling (Mitchell 1991): each place is the one of a few random ones
//! that is farthest from all before it. A place's index in the sequence is the strand's stable id. Density
//! is chosen after the fact: a place is alive while `id / density` is small, so painting more density, or
//! asking for more strands, only adds strands, and a shorter beginning is a coarser level of detail.
//!
//! Relaxing a point set was rejected: every point moves when one is added. Sample elimination (Yuksel
//! 2015) gives better spectra, but a sequence only for a count that is known from the start.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use crate::hair_mesh::HairMesh;
use crate::hash::{combine, random};
use crate::mesh::TriMesh;

/// Candidates a place is chosen from, at most.
const N_CANDIDATES: u32 = 10;
/// How much area candidates come from, in shares of the area that a place has for itself.
const CANDIDATE_AREA: f64 = 40.0;
/// A candidate this far from all others, as a share of the closest packing's spacing, is taken at once.
const GOOD_ENOUGH: f32 = 0.78;
/// Places that are looked for at once: one of this many of those there are.
const BATCH_SHARE: usize = 32;
/// Fewer are not worth another core.
const FEWEST_A_CORE: usize = 16;

/// Triangles that strands may grow on, to be sampled by area.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RootSurface {
    triangles: Vec<RootTriangle>,
    /// Areas up to and including each triangle, in square centimetres.
    area_up_to: Vec<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct RootTriangle {
    corners: [Vec3; 3],
    face: u32,
}

/// A place on the root surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// Bundle of the hair mesh, or triangle of the head.
    pub face: u32,
    pub position: Vec3,
    /// Weights of the triangle's corners; for a hair mesh they mean nothing.
    pub barycentric: [f32; 3],
}

impl RootSurface {
    /// The root faces of all bundles that have at least one layer above the root.
    pub fn of_hair_mesh(mesh: &HairMesh) -> Self {
        let mut surface = Self::default();
        for bundle in 0..mesh.n_bundles() {
            let Some(face) = mesh.face(0, bundle).filter(|_| mesh.face(1, bundle).is_some()) else { continue };
            let corners: Vec<Vec3> = face.iter().map(|&v| mesh.layers[0].positions[v as usize]).collect();
            // A fan around the middle, so that a warped quad is sampled alike from all its corners.
            let middle = corners.iter().sum::<Vec3>() / corners.len() as f32;
            for i in 0..corners.len() {
                surface.push([middle, corners[i], corners[(i + 1) % corners.len()]], bundle as u32);
            }
        }
        surface
    }

    /// The given triangles of a mesh.
    pub fn of_triangles(mesh: &TriMesh, triangles: impl IntoIterator<Item = u32>) -> Self {
        let mut surface = Self::default();
        for triangle_idx in triangles {
            surface.push(mesh.corners(triangle_idx as usize), triangle_idx);
        }
        surface
    }

    fn push(&mut self, corners: [Vec3; 3], face: u32) {
        let [a, b, c] = corners;
        let area = 0.5 * f64::from((b - a).cross(c - a).length());
        if area.is_finite() && area > 0.0 {
            self.area_up_to.push(self.area() + area);
            self.triangles.push(RootTriangle { corners, face });
        }
    }

    /// Square centimetres.
    pub fn area(&self) -> f64 {
        self.area_up_to.last().copied().unwrap_or(0.0)
    }

    /// A random place at a share (0-1) of the area, counted through the triangles.
    fn sample(&self, share: f64, seed: u32) -> Root {
        let area = self.area() * share;
        let at = self.area_up_to.partition_point(|&up_to| up_to <= area).min(self.triangles.len() - 1);
        let RootTriangle { corners: [a, b, c], face } = self.triangles[at];
        let (r1, r2) = (random(seed, 1).sqrt(), random(seed, 2));
        let barycentric = [1.0 - r1, r1 * (1.0 - r2), r1 * r2];
        Root { face, position: barycentric[0] * a + barycentric[1] * b + barycentric[2] * c, barycentric }
    }

    /// The first `n` places of the sequence of `seed`; a longer sequence begins with the same places.
    /// Empty where there is no surface.
    pub fn sequence(&self, n: usize, seed: u32) -> Vec<Root> {
        let mut roots = Vec::new();
        self.extend(&mut roots, n, seed);
        roots
    }

    /// Make a beginning of the sequence of `seed` longer, to `n` places, as if it had been made so at once.
    pub fn extend(&self, roots: &mut Vec<Root>, n: usize, seed: u32) {
        if self.triangles.is_empty() || roots.len() >= n {
            return;
        }
        roots.reserve_exact(n - roots.len());
        // The spacing of the densest packing of so many points on a plane of this area.
        let spacing_at = |i: usize| (2.0 / 3.0_f64.sqrt() * self.area() / (i + 1) as f64).sqrt() as f32;
        let is_rebuilt_at = |i: usize| i == 0 || (i.is_power_of_two() && i >= 8);
        let built_at = if roots.len() < 8 { 0 } else { 1_usize << roots.len().ilog2() };
        let mut near = Near::new(spacing_at(built_at), roots, 2 * built_at.max(8));
        while roots.len() < n {
            let first = roots.len();
            if is_rebuilt_at(first) {
                near = Near::new(spacing_at(first), roots, 2 * first.max(8));
            }
            // Many places at once, each as if those of its batch were not there, and up to where `near` is rebuilt.
            // One that another of its batch then turns out to crowd is found again; any other would have been found
            // the same: what lies farther away than its nearest changes nothing.
            let end = n.min(first + (first / BATCH_SHARE).max(1)).min((first + 1).next_power_of_two());
            let found: Vec<(Root, f32)> = (first..end)
                .into_par_iter()
                .with_min_len(FEWEST_A_CORE)
                .map(|i| self.best_of(&near, i, seed, (GOOD_ENOUGH * spacing_at(i)).powi(2)))
                .collect();
            let mut batch = Near::new(0.5 * near.cell, &[], 2 * found.len());
            for (i, (mut root, squared)) in (first..end).zip(found) {
                if batch.distance_squared(root.position, -1.0) < squared {
                    root = self.best_of(&near, i, seed, (GOOD_ENOUGH * spacing_at(i)).powi(2)).0;
                }
                near.insert(root.position);
                batch.insert(root.position);
                roots.push(root);
            }
        }
    }

    /// Place `i` of the sequence of `seed`, and its squared distance to the nearest before it. A candidate as far
    /// from them as `good` (squared) is taken at once.
    fn best_of(&self, near: &Near, i: usize, seed: u32, good: f32) -> (Root, f32) {
        // The golden ratio's multiples visit every part of the area in turn, so that no part falls behind;
        // candidates come from around there.
        let turn = i as f64 * 0.618_033_988_749_895;
        let width = (CANDIDATE_AREA / (i + 1) as f64).min(1.0);
        let place = |candidate: u32| {
            let seed = combine(combine(seed, i as u32), candidate);
            self.sample((turn + width * f64::from(random(seed, 0))).fract(), seed)
        };
        let mut best = place(0);
        let mut best_squared = near.distance_squared(best.position, -1.0);
        let mut candidate = 1;
        while best_squared < good && candidate < N_CANDIDATES {
            let root = place(candidate);
            let squared = near.distance_squared(root.position, best_squared);
            if squared > best_squared {
                (best, best_squared) = (root, squared);
            }
            candidate += 1;
        }
        (best, best_squared)
    }
}

/// Points hashed into cells of twice the search radius, so that eight cells hold all that can be near.
#[derive(Default)]
struct Near {
    cell: f32,
    mask: u32,
    /// First point of each bucket as index + 1; 0 is none.
    first: Vec<u32>,
    /// Position and next point of the same bucket.
    points: Vec<(Vec3, u32)>,
}

impl Near {
    fn new(radius: f32, roots: &[Root], capacity: usize) -> Self {
        let n_buckets = capacity.next_power_of_two();
        let mut near = Self {
            cell: 2.0 * radius,
            mask: n_buckets as u32 - 1,
            first: vec![0; n_buckets],
            points: Vec::with_capacity(capacity),
        };
        for root in roots {
            near.insert(root.position);
        }
        near
    }

    fn bucket(&self, cell: IVec3) -> usize {
        let [x, y, z] = cell.to_array().map(|c| c as u32);
        let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
        (hash & self.mask) as usize
    }

    fn insert(&mut self, p: Vec3) {
        let bucket = self.bucket((p / self.cell).floor().as_ivec3());
        self.points.push((p, self.first[bucket]));
        self.first[bucket] = self.points.len() as u32;
    }

    /// Squared distance to the nearest point within the search radius, or that radius' square; as soon as
    /// it is below `enough`, whatever is known then.
    fn distance_squared(&self, p: Vec3, enough: f32) -> f32 {
        let mut nearest = (0.5 * self.cell).powi(2);
        let low = (p / self.cell - 0.5).floor().as_ivec3();
        for corner in 0..8 {
            let cell = low + IVec3::new(corner & 1, corner >> 1 & 1, corner >> 2);
            let mut at = self.first[self.bucket(cell)];
            while at != 0 {
                let (q, next) = self.points[at as usize - 1];
                nearest = nearest.min(p.distance_squared(q));
                if nearest <= enough {
                    return nearest;
                }
                at = next;
            }
        }
        nearest
    }
}

/// What places are chosen by: with full density, a place's number.
pub fn key(id: u32, density: f32) -> f64 {
    (f64::from(id) + 0.5) / f64::from(density)
}

/// The `n` places with the smallest `id / density`, in that order; places without density never.
/// `densities` holds one value, 0-1, for each place of the sequence.
pub fn select(densities: &[f32], n: usize) -> Vec<u32> {
    let key = |id: u32| key(id, densities[id as usize]);
    let mut ids: Vec<u32> = (0..densities.len() as u32).filter(|&id| densities[id as usize] > 0.0).collect();
    let by_key = |a: &u32, b: &u32| key(*a).total_cmp(&key(*b)).then(a.cmp(b));
    if n < ids.len() {
        if n > 0 {
            ids.select_nth_unstable_by(n - 1, by_key);
        }
        ids.truncate(n);
    }
    ids.sort_unstable_by(by_key);
    ids
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::tests::straight_grid;

    /// Mean distance of each place to its nearest neighbour.
    fn mean_nearest(points: &[Vec3]) -> f32 {
        let grid = crate::point_grid::PointGrid::new(points, 0.1);
        points.iter().map(|&p| grid.nearest::<2>(p).0[1].1.sqrt()).sum::<f32>() / points.len() as f32
    }

    #[test]
    fn spacing_is_blue_at_every_length() {
        let surface = RootSurface::of_hair_mesh(&straight_grid(8, 1));
        let roots = surface.sequence(8192, 7);
        for n in [256, 1000, 8192] {
            let points: Vec<Vec3> = roots[..n].iter().map(|root| root.position).collect();
            let scattered: Vec<Vec3> =
                (0..n as u32).map(|i| surface.sample(f64::from(random(i, 9)), i).position).collect();
            // Random points have a mean nearest distance of half of 1/sqrt(density); the closest packing
            // 1.07 of it. Best candidate reaches about 0.8.
            let unit = (64.0 / n as f32).sqrt();
            assert!((mean_nearest(&scattered) / unit - 0.5).abs() < 0.1);
            assert!(mean_nearest(&points) / unit > 0.72, "{n}: {}", mean_nearest(&points) / unit);
        }
    }

    #[test]
    fn longer_sequences_begin_alike_and_raising_density_keeps_every_root() {
        let surface = RootSurface::of_hair_mesh(&straight_grid(4, 1));
        let (short, long) = (surface.sequence(500, 3), surface.sequence(2000, 3));
        assert_eq!(short[..], long[..500]);
        for n in [0, 3, 8, 9, 256, 500] {
            let mut extended = long[..n].to_vec();
            surface.extend(&mut extended, 2000, 3);
            assert_eq!(extended, long, "from {n}");
        }
        let painted: Vec<f32> = long.iter().map(|root| 0.2 + 0.1 * root.position.x).collect();
        let raised: Vec<f32> = painted.iter().zip(&long).map(|(d, root)| d + 0.1 * root.position.z / 4.0).collect();
        let before = select(&painted, 300);
        // As many more strands as the density has risen in all.
        let limit = before.iter().map(|&id| (id as f32 + 0.5) / painted[id as usize]).fold(0.0, f32::max);
        let n_after = (0..2000).filter(|&id| (id as f32 + 0.5) / raised[id] <= limit).count();
        let after = select(&raised, n_after);
        assert!(n_after > 300 && before.iter().all(|id| after.contains(id)));
        assert_eq!(select(&painted, 200), before[..200]);
    }

    #[test]
    fn places_found_many_at_once_are_those_found_one_by_one() {
        let surface = RootSurface::of_hair_mesh(&straight_grid(3, 1));
        let at_once = surface.sequence(6000, 5);
        let mut one_by_one = at_once[..5000].to_vec();
        for n in 5001..=5500 {
            surface.extend(&mut one_by_one, n, 5);
        }
        assert_eq!(one_by_one, at_once[..5500]);
    }

    #[test]
    fn a_density_map_is_reproduced_within_two_percent() {
        let surface = RootSurface::of_hair_mesh(&straight_grid(8, 1));
        let roots = surface.sequence(160_000, 11);
        let density = |p: Vec3| 0.3 + 0.7 * ((p.x as u32 + 3 * p.z as u32) % 8) as f32 / 7.0;
        let densities: Vec<f32> = roots.iter().map(|root| density(root.position)).collect();
        let n = 100_000;
        let ids = select(&densities, n);
        let mut found = [0.0_f32; 64];
        for &id in &ids {
            found[roots[id as usize].face as usize] += 1.0;
        }
        let total: f32 = (0..64).map(|i| density(Vec3::new((i % 8) as f32 + 0.5, 0.0, (i / 8) as f32 + 0.5))).sum();
        for (i, found) in found.iter().enumerate() {
            let p = Vec3::new((i % 8) as f32 + 0.5, 0.0, (i / 8) as f32 + 0.5);
            let expected = n as f32 * density(p) / total;
            assert!((found / expected - 1.0).abs() < 0.02, "patch {i}: {found} of {expected}");
        }
    }

    #[test]
    fn no_surface_no_roots() {
        assert!(RootSurface::default().sequence(10, 0).is_empty());
        assert!(RootSurface::of_hair_mesh(&straight_grid(2, 0)).sequence(10, 0).is_empty());
    }
}
