//! Hair that is gathered: from every root along the scalp to a place where it is held, through it side by
//! side, and on along a course: a tail, a bun, the strands of a braid.
//!
//! The roots are a grid around the place where hair is held, so a root has an angle around it and a rank
//! from there to the hairline. In the hand that holds it, hair keeps the angle from which it comes, and what
//! grew farther away lies farther outside: no two bundles cross, and the hair mesh stays one volume.

use std::collections::HashMap;
use std::f32::consts::TAU;
use std::ops::Range;

use glam::{Quat, Vec2, Vec3};
use lorelei_core::hair_mesh::HairMesh;

use super::Studio;
use super::roots::{Root, RootGrid};
use crate::bake::sdf::smoothstep;

/// Length of a step along the scalp, in centimetres.
const STEP: f32 = 0.3;
/// Where hair begins to leave the scalp for the hand that holds it, in centimetres before it.
const LEAVES: f32 = 4.0;

/// How hair lies on its way to where it is held. Lengths in centimetres.
#[derive(Debug, Clone, Copy)]
pub struct Comb {
    /// Over the scalp.
    pub cover: f32,
    /// How much higher the hairline's hair lies over the rest when it arrives.
    pub thickness: f32,
    /// Layers of the hair mesh up to there.
    pub n_layers: usize,
}

/// All hair of a head is thick where it comes together: combed flatter, more strands than have room would lie in front
/// of each other, and a picture could not tell which of them is in front.
impl Default for Comb {
    fn default() -> Self {
        Self { cover: 0.45, thickness: 1.2, n_layers: 7 }
    }
}

/// Part of the columns and where they go. `course` gives the place in section `k`, from 0 where the hair is
/// held, of hair at a place in the unit disc.
pub struct Tress<'c> {
    pub columns: Range<usize>,
    pub course: &'c dyn Fn(usize, Vec2) -> Vec3,
}

/// A cross-section of a rope of hair: its middle and its half axes.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    pub middle: Vec3,
    pub x: Vec3,
    pub y: Vec3,
}

impl Section {
    pub fn at(&self, place: Vec2) -> Vec3 {
        self.middle + place.x * self.x + place.y * self.y
    }
}

/// Sections along a line, turned as little as possible from one to the next; `x` is the first one's, `size`
/// gives both half axes at a share of the line.
pub fn rope(line: &[Vec3], x: Vec3, size: impl Fn(f32) -> Vec2) -> Vec<Section> {
    let last = line.len() - 1;
    let direction = |k: usize| (line[(k + 1).min(last)] - line[k.saturating_sub(1)]).normalize();
    let mut along = direction(0);
    let mut x = x.reject_from_normalized(along).normalize();
    let section = |k: usize| {
        let next = direction(k);
        x = (Quat::from_rotation_arc(along, next) * x).reject_from_normalized(next).normalize();
        along = next;
        let size = size(k as f32 / last as f32);
        Section { middle: line[k], x: size.x * x, y: size.y * along.cross(x) }
    };
    (0..=last).map(section).collect()
}

/// `n` points evenly along a polyline, both ends included.
pub fn evenly(line: &[Vec3], n: usize) -> Vec<Vec3> {
    let mut length_to = vec![0.0];
    for pair in line.windows(2) {
        length_to.push(length_to[length_to.len() - 1] + pair[0].distance(pair[1]));
    }
    let total = length_to[length_to.len() - 1];
    let at = |k: usize| {
        let wanted = total * k as f32 / (n - 1) as f32;
        let i = length_to.partition_point(|&l| l < wanted).clamp(1, line.len() - 1);
        let t = (wanted - length_to[i - 1]) / (length_to[i] - length_to[i - 1]).max(1e-6);
        line[i - 1].lerp(line[i], t.clamp(0.0, 1.0))
    };
    (0..n).map(at).collect()
}

/// The hair mesh of gathered hair: `grid` is one around the place where it is held, all tresses have
/// `n_sections`. `x` and `y` span the plane in which hair is held, for a tress of all columns; a part of the
/// columns fills the disc from its first to its last.
pub fn gather(
    studio: &Studio,
    grid: &RootGrid,
    n_columns: usize,
    comb: &Comb,
    (x, y): (Vec3, Vec3),
    n_sections: usize,
    tresses: &[Tress<'_>],
) -> Result<HairMesh, String> {
    let n_rows = grid.roots.len() / n_columns;
    let middle = (0..n_columns).map(|c| grid.roots[c * n_rows].position).sum::<Vec3>() / n_columns as f32;
    let angle_of = |column: usize| {
        let out = grid.roots[column * n_rows + 2].position - middle;
        out.dot(y).atan2(out.dot(x))
    };
    let mut paths: Vec<Vec<Vec3>> = Vec::new();
    let mut faces = Vec::new();
    let mut path_of: HashMap<(usize, usize, bool), u32> = HashMap::new();
    for (tress_idx, tress) in tresses.iter().enumerate() {
        let is_whole = tress.columns.len() == n_columns;
        for column in tress.columns.clone() {
            for row in 0..n_rows - 1 {
                let mut corner = |column: usize, row: usize| {
                    // Hair at the rim of two tresses belongs to both, each with a path of its own.
                    let root_idx = (column % n_columns) * n_rows + row;
                    let is_rim = !is_whole && column == tress.columns.end;
                    *path_of.entry((tress_idx, root_idx, is_rim)).or_insert_with(|| {
                        let root = &grid.roots[root_idx];
                        let turn = (column - tress.columns.start) as f32 / tress.columns.len() as f32;
                        let angle = if is_whole { angle_of(column % n_columns) } else { TAU * turn };
                        let place = rank_of(root) * Vec2::from_angle(angle);
                        let held = (tress.course)(0, place);
                        let centre = &grid.roots[(column % n_columns) * n_rows];
                        let mut path = evenly(&along_scalp(studio, root, centre, held, comb), comb.n_layers + 1);
                        path.extend((1..n_sections).map(|k| (tress.course)(k, place)));
                        paths.push(path);
                        paths.len() as u32 - 1
                    })
                };
                faces.push(vec![
                    corner(column, row),
                    corner(column, row + 1),
                    corner(column + 1, row + 1),
                    corner(column + 1, row),
                ]);
            }
        }
    }
    let n_layers = comb.n_layers + n_sections - 1;
    let layers_at: Vec<f32> = (1..=n_layers).map(|k| k as f32 / n_layers as f32).collect();
    HairMesh::from_paths(&paths, &faces, &layers_at).map_err(|error| error.to_string())
}

/// The way along its column over the scalp to where hair is held, at a height that grows from the root.
fn along_scalp(studio: &Studio, root: &Root, centre: &Root, held: Vec3, comb: &Comb) -> Vec<Vec3> {
    let rank = rank_of(root);
    let n = ((root.position.distance(centre.position) / STEP).ceil() as usize).max(1);
    let way = studio.chart.way(root, centre, n);
    let mut left = vec![held.distance(way[n])];
    for pair in way.windows(2).rev() {
        left.push(left[left.len() - 1] + pair[0].distance(pair[1]));
    }
    left.reverse();
    let far = left[0];
    let mut line = vec![root.position];
    for k in 1..=n {
        let mut p = way[k];
        let share = 1.0 - left[k] / far;
        let wanted =
            comb.cover * smoothstep(0.0, 2.5, far - left[k]) + comb.thickness * rank * smoothstep(0.0, 1.0, share);
        for _ in 0..4 {
            let off = wanted - studio.body.sample(p);
            p += 0.8 * off * studio.body.gradient(p).normalize_or(root.normal);
        }
        line.push(p.lerp(held, smoothstep(LEAVES, 0.0, left[k])));
    }
    line.push(held);
    line
}

/// How far from the middle of the hand that holds it a root's hair lies, 0-1.
fn rank_of(root: &Root) -> f32 {
    0.04 + 0.96 * root.along
}
