//! Nearest points among many that lie on a surface: a grid of cells, each a range of sorted indices.
//!
//! A k-d tree was rejected: roots are spread evenly, and then a grid is both simpler and faster.

use glam::{IVec3, UVec3, Vec3};

/// Points sorted into the cells of a box.
#[derive(Debug)]
pub struct PointGrid<'a> {
    points: &'a [Vec3],
    min: Vec3,
    cell: f32,
    n: UVec3,
    /// Range of each cell in `sorted`.
    starts: Vec<u32>,
    sorted: Vec<u32>,
}

/// More cells than this are not worth their memory: cells grow instead.
const MAX_CELLS: f32 = 2_000_000.0;

impl<'a> PointGrid<'a> {
    /// Sort finite points into cells of about `cell` centimetres.
    pub fn new(points: &'a [Vec3], cell: f32) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let (min, max) = points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let size = max - min;
        let mut cell = cell.max(1e-4 * size.max_element()).max(1e-6);
        while ((size / cell) + 1.0).element_product() > MAX_CELLS {
            cell *= 1.3;
        }
        let n = (size / cell).as_uvec3() + 1;
        let mut grid =
            Self { points, min, cell, n, starts: vec![0; n.element_product() as usize + 1], sorted: Vec::new() };
        let cell_of: Vec<u32> = points.iter().map(|&p| grid.index(grid.locate(p)) as u32).collect();
        for &cell in &cell_of {
            grid.starts[cell as usize + 1] += 1;
        }
        for cell in 1..grid.starts.len() {
            grid.starts[cell] += grid.starts[cell - 1];
        }
        let mut next = grid.starts.clone();
        grid.sorted = vec![0; points.len()];
        for (point_idx, &cell) in cell_of.iter().enumerate() {
            grid.sorted[next[cell as usize] as usize] = point_idx as u32;
            next[cell as usize] += 1;
        }
        grid
    }

    fn locate(&self, p: Vec3) -> IVec3 {
        ((p - self.min) / self.cell).floor().as_ivec3().clamp(IVec3::ZERO, self.n.as_ivec3() - 1)
    }

    fn index(&self, at: IVec3) -> usize {
        (at.x + self.n.x as i32 * (at.y + self.n.y as i32 * at.z)) as usize
    }

    /// Call `visit` with the index and the squared distance of every point within `radius` of `p`.
    pub fn within(&self, p: Vec3, radius: f32, mut visit: impl FnMut(usize, f32)) {
        let (lo, hi) = (self.locate(p - radius), self.locate(p + radius));
        for z in lo.z..=hi.z {
            for y in lo.y..=hi.y {
                let row = self.starts[self.index(IVec3::new(lo.x, y, z))]
                    ..self.starts[self.index(IVec3::new(hi.x, y, z)) + 1];
                for &point_idx in &self.sorted[row.start as usize..row.end as usize] {
                    let squared = self.points[point_idx as usize].distance_squared(p);
                    if squared <= radius * radius {
                        visit(point_idx as usize, squared);
                    }
                }
            }
        }
    }

    /// The `K` nearest points as (index, squared distance), nearest first; fewer where there are fewer.
    pub fn nearest<const K: usize>(&self, p: Vec3) -> ([(usize, f32); K], usize) {
        let mut radius = self.cell;
        let reach = (p - self.min).abs().max((p - self.min - self.n.as_vec3() * self.cell).abs()).length();
        loop {
            let mut best = [(usize::MAX, f32::INFINITY); K];
            let mut n_found = 0;
            self.within(p, radius, |point_idx, squared| {
                if squared < best[K - 1].1 || (squared == best[K - 1].1 && point_idx < best[K - 1].0) {
                    let at = best.iter().position(|b| (squared, point_idx) < (b.1, b.0)).unwrap_or(K - 1);
                    best.copy_within(at..K - 1, at + 1);
                    best[at] = (point_idx, squared);
                    n_found += 1;
                }
            });
            if n_found >= K || radius > reach {
                return (best, n_found.min(K));
            }
            radius *= 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hash::random;

    #[test]
    fn nearest_agrees_with_looking_at_all() {
        let points: Vec<Vec3> =
            (0..500).map(|i| Vec3::new(random(i, 0), 5.0 * random(i, 1), 0.3 * random(i, 2)) * 4.0).collect();
        let grid = PointGrid::new(&points, 0.5);
        for i in 0..60 {
            let p = Vec3::new(random(i, 3), random(i, 4), random(i, 5)) * 9.0 - 2.0;
            let mut all: Vec<(f32, usize)> = points.iter().map(|q| q.distance_squared(p)).zip(0..).collect();
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let (best, n_found) = grid.nearest::<4>(p);
            assert_eq!(n_found, 4);
            assert_eq!(best.map(|b| b.0), [all[0].1, all[1].1, all[2].1, all[3].1]);
        }
        let two = [Vec3::ZERO, Vec3::X];
        assert_eq!(PointGrid::new(&two, 0.1).nearest::<3>(Vec3::new(9.0, 0.0, 0.0)).1, 2);
    }
}
