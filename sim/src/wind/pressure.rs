//! The pressure that leaves the air without divergence: multigrid. Twin of `wind_pressure.wgsl`: same names, same order.
//!
//! The equation of cell i is the sum over its faces f to neighbours j of a_f (p_i - p_j) = -divergence_i, with a_f how open
//! the face is: less in hair, 0 in the head. At the box's boundary the pressure is 0 on the face, half a cell away.
//!
//! Multigrid, for it needs the fewest dispatches for what it leaves: a cycle is four on each level above 16 cells (back, red,
//! black, forth) and one for all levels below. Successive over-relaxation takes ten sweeps of two dispatches for a cycle's
//! work at 32 cells and forty at 128; conjugate gradients wait for two sums over all cells in each iteration. Red
//! and black cells take turns, so a sweep does not depend on the order of threads. A coarse face is as open as the mean of
//! its four fine ones, and a coarse pressure is interpolated from cells with air only, or every wall would leak through
//! the coarse levels.

use glam::{IVec3, UVec3, Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::grid::GridParams;

const LEAST_DIAGONAL: f32 = 1e-5;
const N_COARSE_SWEEPS: usize = 2;
const N_COARSEST_SWEEPS: usize = 8;
/// Levels of this many cells a side and fewer are solved in one workgroup.
pub const LARGEST_COARSE: u32 = 16;
/// A level of this many cells a side is not made coarser.
const COARSEST: u32 = 4;
/// Levels that a uniform has room for.
pub const MAX_LEVELS: usize = 8;

/// Cells along a side and the first entry of every level, the finest first. Layout of `Levels` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Levels {
    pub of: [[u32; 4]; MAX_LEVELS],
    /// The level of a dispatch.
    pub level: u32,
    pub n_levels: u32,
    pub pad: [u32; 2],
}

impl Levels {
    /// Halved until few or an odd number of cells are left.
    pub fn new(n: u32) -> Self {
        let mut levels = Self { of: [[0; 4]; MAX_LEVELS], level: 0, n_levels: 0, pad: [0; 2] };
        let (mut n, mut first) = (n, 0);
        loop {
            levels.of[levels.n_levels as usize] = [n, first, 0, 0];
            levels.n_levels += 1;
            first += (n + 1).pow(3);
            if n <= COARSEST || n % 2 == 1 || levels.n_levels as usize == MAX_LEVELS {
                return levels;
            }
            n /= 2;
        }
    }

    /// For a dispatch on a level.
    pub fn at(&self, level: usize) -> Self {
        Self { level: level as u32, ..*self }
    }

    /// Entries of all levels.
    pub fn n_entries(&self) -> usize {
        let [n, first, ..] = self.of[self.n_levels as usize - 1];
        (first + (n + 1).pow(3)) as usize
    }

    /// The first level that one workgroup solves with all below it.
    pub fn first_coarse(&self) -> usize {
        let is_coarse = |level: &usize| self.of[*level][0] <= LARGEST_COARSE;
        (0..self.n_levels as usize).find(is_coarse).unwrap_or(self.n_levels as usize - 1)
    }

    fn n_of(&self, level: usize) -> u32 {
        self.of[level][0]
    }

    fn at_level(&self, level: usize, c: UVec3) -> usize {
        let side = self.n_of(level) + 1;
        (self.of[level][1] + c.x + side * (c.y + side * c.z)) as usize
    }
}

/// The equations of all levels and what has been found so far.
#[derive(Debug, Clone, PartialEq)]
pub struct Pressure {
    pub levels: Levels,
    /// What a difference of pressure does to the speed through each lower face, level after level.
    pub openness: Vec<Vec4>,
    /// Right side and the inverse of the diagonal (0 where no air is), level after level.
    pub equations: Vec<[f32; 2]>,
    /// cm/s: times the step over density and cell it would be one.
    pub pressure: Vec<f32>,
}

impl Pressure {
    pub fn new(n: u32) -> Self {
        let levels = Levels::new(n);
        let n_entries = levels.n_entries();
        Self {
            levels,
            openness: vec![Vec4::ZERO; n_entries],
            equations: vec![[0.0; 2]; n_entries],
            pressure: vec![0.0; n_entries],
        }
    }

    /// The neighbours' pressures, each times how open the face between is. Outside there is none.
    fn pull_of_neighbours(&self, level: usize, c: UVec3) -> f32 {
        let n = self.levels.n_of(level);
        let row = n as usize + 1;
        let slab = row * row;
        let at = self.levels.at_level(level, c);
        let (openness, pressure) = (&self.openness, &self.pressure);
        let low = openness[at];
        let mut sum = 0.0;
        if c.x > 0 {
            sum += low.x * pressure[at - 1];
        }
        if c.x + 1 < n {
            sum += openness[at + 1].x * pressure[at + 1];
        }
        if c.y > 0 {
            sum += low.y * pressure[at - row];
        }
        if c.y + 1 < n {
            sum += openness[at + row].y * pressure[at + row];
        }
        if c.z > 0 {
            sum += low.z * pressure[at - slab];
        }
        if c.z + 1 < n {
            sum += openness[at + slab].z * pressure[at + slab];
        }
        sum
    }

    /// One step of Gauss and Seidel.
    fn relax(&self, level: usize, c: UVec3) -> f32 {
        let [right, inverse] = self.equations[self.levels.at_level(level, c)];
        (right + self.pull_of_neighbours(level, c)) * inverse
    }

    fn residual(&self, level: usize, c: UVec3) -> f32 {
        let at = self.levels.at_level(level, c);
        let [right, inverse] = self.equations[at];
        if inverse == 0.0 {
            return 0.0;
        }
        right + self.pull_of_neighbours(level, c) - self.pressure[at] / inverse
    }

    fn mean_openness(&self, level: usize, c: UVec3, axis: usize) -> f32 {
        let side = self.levels.n_of(level) as usize + 1;
        let (a, b) = [(side, side * side), (1, side * side), (1, side)][axis];
        let at = self.levels.at_level(level, c);
        let open = |at: usize| self.openness[at][axis];
        let mean = 0.25 * (open(at) + open(at + a) + open(at + b) + open(at + a + b));
        // Outside there is nothing: a coarser cell is farther from the face, which resists as it did.
        let is_outer = c[axis] == 0 || c[axis] == self.levels.n_of(level);
        if is_outer { 2.0 * mean / (1.0 + 0.5 * mean) } else { mean }
    }

    /// What is left of the equations of `level`, as those of a coarser cell: openness of its lower faces and of its upper
    /// ones, and the equation.
    fn restrict_to(&self, level: usize, c: UVec3) -> (Vec3, Vec3, [f32; 2]) {
        let fine = 2 * c;
        let mut left = 0.0;
        for i in 0..8_u32 {
            left += self.residual(level, fine + UVec3::new(i & 1, i >> 1 & 1, i >> 2));
        }
        let low = [0, 1, 2].map(|axis| self.mean_openness(level, fine, axis));
        let high = [0, 1, 2].map(|axis| self.mean_openness(level, fine + 2 * UVec3::AXES[axis], axis));
        let (low, high) = (Vec3::from_array(low), Vec3::from_array(high));
        (low, high, [0.5 * left, inverse_diagonal(low, high)])
    }

    /// The coarser level's pressure, interpolated from where there is air.
    fn prolong(&self, level: usize, c: UVec3) -> f32 {
        if self.equations[self.levels.at_level(level, c)][1] == 0.0 {
            return 0.0;
        }
        let n = self.levels.n_of(level + 1) as i32;
        let near = (c / 2).as_ivec3();
        let towards = (c % 2).as_ivec3() * 2 - 1;
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in 0..8_i32 {
            let offset = IVec3::new(i & 1, i >> 1 & 1, i >> 2);
            let neighbour = near + offset * towards;
            let share = 0.75 - 0.5 * offset.as_vec3();
            let mut weight = share.x * share.y * share.z;
            let inside = neighbour.clamp(IVec3::ZERO, IVec3::splat(n - 1));
            let from_cell = self.levels.at_level(level + 1, inside.as_uvec3());
            if self.equations[from_cell][1] > 0.0 {
                weights += weight;
                // Beyond the boundary the pressure goes on through 0 where it is open, and as it is where it is closed.
                for axis in 0..3 {
                    if neighbour[axis] < 0 {
                        weight *= 1.0 - self.openness[from_cell][axis];
                    }
                    if neighbour[axis] >= n {
                        let last = self.levels.at_level(level + 1, inside.as_uvec3() + UVec3::AXES[axis]);
                        weight *= 1.0 - self.openness[last][axis];
                    }
                }
                sum += weight * self.pressure[from_cell];
            }
        }
        if weights > 0.0 { sum / weights } else { 0.0 }
    }

    /// The equations of the finest level, from the speeds before the pressure and how open their faces are.
    pub fn begin(&mut self, grid: &GridParams, predicted: &[Vec4], openness: &[Vec4]) {
        self.openness[..openness.len()].copy_from_slice(openness);
        let cell_of = grid.entries();
        let row = grid.n as usize + 1;
        let n = UVec3::splat(grid.n);
        self.equations[..openness.len()].par_iter_mut().enumerate().for_each(|(at, equation)| {
            if cell_of(at).cmpge(n).any() {
                return;
            }
            let upper = |of: &[Vec4]| Vec3::new(of[at + 1].x, of[at + row].y, of[at + row * row].z);
            let (low, high) = (predicted[at].xyz(), upper(predicted));
            let divergence = high.x - low.x + high.y - low.y + high.z - low.z;
            *equation = [-divergence, inverse_diagonal(openness[at].xyz(), upper(openness))];
        });
    }

    fn sweep(&mut self, level: usize) {
        let n = self.levels.n_of(level);
        let side = n as usize + 1;
        let first = self.levels.of[level][1] as usize;
        for colour in 0..2 {
            let relaxed: Vec<f32> = (0..(side * side * side))
                .into_par_iter()
                .with_min_len(4096)
                .map(|at| {
                    let c = UVec3::new((at % side) as u32, (at / side % side) as u32, (at / (side * side)) as u32);
                    let is_its_turn = (c.x + c.y + c.z + colour).is_multiple_of(2) && c.cmplt(UVec3::splat(n)).all();
                    if is_its_turn { self.relax(level, c) } else { self.pressure[first + at] }
                })
                .collect();
            self.pressure[first..first + relaxed.len()].copy_from_slice(&relaxed);
        }
    }

    fn coarsen(&mut self, level: usize) {
        for c in cells(self.levels.n_of(level + 1)) {
            let (low, high, equation) = self.restrict_to(level, c);
            let at = self.levels.at_level(level + 1, c);
            self.openness[at] = low.extend(0.0);
            for axis in 0..3 {
                let next = c + UVec3::AXES[axis];
                if next[axis] == self.levels.n_of(level + 1) {
                    let next = self.levels.at_level(level + 1, next);
                    self.openness[next][axis] = high[axis];
                }
            }
            self.equations[at] = equation;
            self.pressure[at] = 0.0;
        }
    }

    fn refine(&mut self, level: usize) {
        for c in cells(self.levels.n_of(level)) {
            let more = self.prolong(level, c);
            let at = self.levels.at_level(level, c);
            self.pressure[at] += more;
        }
    }

    /// As many cycles as asked for, from the pressure of the last frame.
    pub fn solve(&mut self, n_cycles: u32) {
        let (first_coarse, last) = (self.levels.first_coarse(), self.levels.n_levels as usize - 1);
        for level in 0..first_coarse.min(1) {
            self.sweep(level);
        }
        for _ in 0..n_cycles.clamp(1, 8) {
            for level in 0..first_coarse {
                if level > 0 {
                    self.sweep(level);
                }
                self.coarsen(level);
            }
            self.coarse(first_coarse, last);
            for level in (0..first_coarse).rev() {
                self.refine(level);
                self.sweep(level);
            }
        }
    }

    /// One cycle over a level and all coarser ones.
    fn coarse(&mut self, first: usize, last: usize) {
        for level in first..last {
            for _ in 0..N_COARSE_SWEEPS {
                self.sweep(level);
            }
            self.coarsen(level);
        }
        for _ in 0..N_COARSEST_SWEEPS {
            self.sweep(last);
        }
        for level in (first..last).rev() {
            self.refine(level);
            for _ in 0..N_COARSE_SWEEPS {
                self.sweep(level);
            }
        }
    }

    /// Speed through a lower face once the pressure has pushed.
    fn pushed(&self, grid: &GridParams, predicted: &[Vec4], c: UVec3, axis: usize) -> f32 {
        let at = grid.entry(c);
        let mut difference = 0.0;
        if c[axis] < grid.n {
            difference += self.pressure[at];
        }
        if c[axis] > 0 {
            difference -= self.pressure[grid.entry(c - UVec3::AXES[axis])];
        }
        predicted[at][axis] - self.openness[at][axis] * difference
    }

    /// Of a cell: speeds through its lower faces, and the velocity in its middle with how open it is (w).
    pub fn project(&self, grid: &GridParams, predicted: &[Vec4], c: UVec3) -> (Vec4, Option<Vec4>) {
        let (mut low, mut middle) = (Vec3::ZERO, Vec3::ZERO);
        for axis in 0..3 {
            let others = c * (UVec3::ONE - UVec3::AXES[axis]);
            if others.cmplt(UVec3::splat(grid.n)).all() {
                low[axis] = self.pushed(grid, predicted, c, axis);
                if c[axis] < grid.n {
                    middle[axis] = 0.5 * (low[axis] + self.pushed(grid, predicted, c + UVec3::AXES[axis], axis));
                }
            }
        }
        let is_cell = c.cmplt(UVec3::splat(grid.n)).all();
        (low.extend(0.0), is_cell.then(|| middle.extend(predicted[grid.entry(c)].w)))
    }
}

fn inverse_diagonal(low: Vec3, high: Vec3) -> f32 {
    let diagonal = low.x + high.x + low.y + high.y + low.z + high.z;
    if diagonal < LEAST_DIAGONAL { 0.0 } else { 1.0 / diagonal }
}

/// All cells of a level.
fn cells(n: u32) -> impl Iterator<Item = UVec3> {
    (0..n * n * n).map(move |i| UVec3::new(i % n, i / n % n, i / (n * n)))
}
