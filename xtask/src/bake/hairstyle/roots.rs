//! Where hair is rooted: a grid of faces from the parting to the hairline, and the maps of its density.
//!
//! The grid is laid out in the scalp's chart, where it is nearly rigid: columns run from the parting (and
//! from the crown, around which the back ones fan out) straight to the hairline, so that a column is the
//! way a comb would take, and rows are what lies over what. A polar grid around the crown was rejected: a
//! parting would cut across its faces.

use std::collections::HashMap;

use glam::{Vec2, Vec3, vec2};
use lorelei_core::maps::ScalpMap;
use lorelei_core::mesh::{SCALP_GROUP, TriMesh};

use crate::bake::sdf::smoothstep;

/// Side of a density map in texels: 0.1 cm a texel.
const MAP_SIZE: u32 = 512;
/// How far each side's roots reach over the parting on average, centimetres: hair of both sides crosses the
/// line, so that it shows roots but no bald stripe.
const PARTING_OVERLAP: f32 = 0.4;
/// How much denser hair grows along the parting and around the crown than elsewhere: there nothing lies over
/// it but itself.
const DENSER: f32 = 2.2;
/// The same around the whorl of short hair, which covers less.
const DENSEST: f32 = 3.2;
/// How much denser hair that is combed back grows behind the hairline over the face.
const DENSER_IN_FRONT: f32 = 1.8;

/// The scalp's chart, its border in order and its scale.
pub struct ScalpChart {
    triangles: Vec<[(Vec2, Vec3, Vec3); 3]>,
    /// The hairline, from the middle of the forehead over the model's left side, nape and right side.
    border: Vec<(Vec2, Vec3)>,
    /// Centimetres up to each border point.
    length_to: Vec<f32>,
    /// Texture units in a centimetre.
    scale: f32,
}

/// A corner of the root grid.
#[derive(Debug, Clone, Copy)]
pub struct Root {
    pub position: Vec3,
    pub normal: Vec3,
    /// Unit vector along the column, away from the parting.
    pub flow: Vec3,
    /// 0 at the forehead to 1 at the nape, along the hairline.
    pub back: f32,
    /// 0 at the parting to 1 at the hairline.
    pub along: f32,
    /// Its place in the scalp's chart.
    pub uv: Vec2,
}

/// Root faces with their corners.
pub struct RootGrid {
    pub roots: Vec<Root>,
    pub faces: Vec<Vec<u32>>,
}

/// How a grid is laid out. Places in head space, centimetres.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// Where the parting begins: x on the hairline over the forehead.
    pub parting_x: f32,
    /// Where it ends and the whorl is.
    pub crown: Vec3,
    /// Share of each side's columns that begin at the parting; the others fan out from the crown.
    pub parted: f32,
    /// Columns on each side, and rows.
    pub n_columns: usize,
    pub n_rows: usize,
    /// Turn of the flow at the crown, radians, and the distance over which it is gone.
    pub whorl: f32,
    pub whorl_radius: f32,
}

impl ScalpChart {
    pub fn new(head: &TriMesh) -> Option<Self> {
        let group = head.group(SCALP_GROUP)?;
        let corner = |v: u32| {
            let v = v as usize;
            (Vec2::from_array(head.uvs[v]), head.positions[v], head.normals[v])
        };
        let triangles: Vec<_> = group.triangles.iter().map(|&t| head.triangles[t as usize].map(corner)).collect();
        // Border edges have no twin; each leads to the next.
        let mut next: HashMap<u32, u32> = HashMap::new();
        let edges = |t: &u32| {
            let [a, b, c] = head.triangles[*t as usize];
            [(a, b), (b, c), (c, a)]
        };
        let all: std::collections::HashSet<(u32, u32)> = group.triangles.iter().flat_map(edges).collect();
        for &(a, b) in all.iter().filter(|&&(a, b)| !all.contains(&(b, a))) {
            next.insert(a, b);
        }
        let middle = |v: &&u32| {
            head.positions[**v as usize].x.abs() + if head.positions[**v as usize].z > 0.0 { 0.0 } else { 99.0 }
        };
        let first = *next.keys().min_by(|a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)))?;
        let mut border = vec![(corner(first).0, corner(first).1)];
        let mut at = *next.get(&first)?;
        while at != first && border.len() <= next.len() {
            border.push((corner(at).0, corner(at).1));
            at = *next.get(&at)?;
        }
        border.push(border[0]);
        let mut length_to = vec![0.0];
        for pair in border.windows(2) {
            length_to.push(length_to[length_to.len() - 1] + pair[0].1.distance(pair[1].1));
        }
        let area = |[a, b, c]: [Vec3; 3]| (b - a).cross(c - a).length();
        let in_space: f32 = triangles.iter().map(|t| area(t.map(|c| c.1))).sum();
        let in_chart: f32 = triangles.iter().map(|t| area(t.map(|c| c.0.extend(0.0)))).sum();
        Some(Self { triangles, border, length_to, scale: (in_chart / in_space).sqrt() })
    }

    /// Place and normal at texture coordinates; the nearest of the chart where they are outside.
    fn at(&self, uv: Vec2) -> (Vec3, Vec3) {
        let mut best = (f32::MAX, Vec3::ZERO, Vec3::Y);
        for [a, b, c] in &self.triangles {
            let (e, f, q) = (b.0 - a.0, c.0 - a.0, uv - a.0);
            let det = e.perp_dot(f);
            let (u, v) = (q.perp_dot(f) / det, e.perp_dot(q) / det);
            // Clamping is exact inside and near enough outside.
            let (u, v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
            let sum = (u + v).max(1.0);
            let (u, v) = (u / sum, v / sum);
            let distance = (a.0 + u * e + v * f).distance(uv);
            if distance < best.0 {
                let mix = |a: Vec3, b: Vec3, c: Vec3| a + u * (b - a) + v * (c - a);
                best = (distance, mix(a.1, b.1, c.1), mix(a.2, b.2, c.2).normalize());
            }
            if distance < 1e-6 {
                break;
            }
        }
        (best.1, best.2)
    }

    /// Texture coordinates of the chart's place nearest to a point.
    fn uv_near(&self, p: Vec3) -> Vec2 {
        let corners = self.triangles.iter().flatten();
        let nearest = corners.min_by(|a, b| a.1.distance_squared(p).total_cmp(&b.1.distance_squared(p)));
        nearest.map_or(Vec2::ZERO, |corner| corner.0)
    }

    /// Texture coordinates of the hairline, centimetres from its beginning; wraps around.
    fn border_at(&self, length: f32) -> Vec2 {
        let total = self.length_to[self.length_to.len() - 1];
        let length = length.rem_euclid(total);
        let i = self.length_to.partition_point(|&l| l <= length).clamp(1, self.border.len() - 1);
        let t = (length - self.length_to[i - 1]) / (self.length_to[i] - self.length_to[i - 1]).max(1e-6);
        self.border[i - 1].0.lerp(self.border[i].0, t)
    }

    /// Where on the hairline a measure is least, centimetres from its beginning.
    fn nearest_border(&self, is: impl Fn(Vec3) -> f32) -> f32 {
        let i = (0..self.border.len() - 1).min_by(|&a, &b| is(self.border[a].1).total_cmp(&is(self.border[b].1)));
        self.length_to[i.unwrap_or(0)]
    }

    /// Where the parting begins, centimetres along the hairline; negative on the right side.
    fn parting_begin(&self, layout: &Layout) -> f32 {
        let total = self.length_to[self.length_to.len() - 1];
        let front = self.nearest_border(|p| (p.x - layout.parting_x).abs() + if p.z > 2.0 { 0.0 } else { 99.0 });
        if front > 0.5 * total { front - total } else { front }
    }

    /// Lay the grid out.
    pub fn grid(&self, layout: &Layout) -> RootGrid {
        let total = self.length_to[self.length_to.len() - 1];
        let front = self.parting_begin(layout);
        let nape = self.nearest_border(|p| p.x.abs() + if p.z < -3.0 { 0.0 } else { 99.0 });
        let (front_uv, crown_uv) = (self.border_at(front), self.uv_near(layout.crown));
        let n = layout.n_columns;
        let mut roots = Vec::new();
        for column in 0..=2 * n {
            // From the parting over the left side to the nape, then back over the right side.
            let side = (n as f32 - column as f32).clamp(-1.0, 1.0);
            let back = 1.0 - (column as f32 - n as f32).abs() / n as f32;
            // The first column lies along the hairline itself.
            let reach = 4.5;
            let target = if column <= n {
                front + reach + (nape - front - reach) * back
            } else {
                front + total - reach - (front + total - reach - nape) * back
            };
            let end = self.border_at(target);
            // None where the parting ends: a folded face would send its strands anywhere.
            // From column to column more and less: no hand parts hair along a ruler.
            let uneven = 0.75 + 0.5 * (2.4 * column as f32).sin();
            let overlap = PARTING_OVERLAP
                * uneven
                * smoothstep(-0.08, 0.1, back)
                * smoothstep(layout.parted, layout.parted - 0.1, back);
            let begin = if back < layout.parted {
                let across = (crown_uv - front_uv).perp().normalize() * -side;
                front_uv.lerp(crown_uv, (back / layout.parted).powf(0.9)) - overlap * self.scale * across
            } else {
                crown_uv + 0.15 * self.scale * (end - crown_uv).normalize()
            };
            let along_border = |t: f32| self.border_at(if side > 0.0 { front + reach * t } else { front - reach * t });
            let on_column = |t: f32| {
                let straight = begin.lerp(end, t);
                // Columns beside the first one bend like it.
                let follow = (1.0 - back * n as f32 / 2.0).max(0.0);
                straight.lerp(along_border(t) + (begin - front_uv) * (1.0 - t), follow)
            };
            let uvs: Vec<Vec2> = (0..=layout.n_rows).map(|row| on_column(row as f32 / layout.n_rows as f32)).collect();
            let places: Vec<(Vec3, Vec3)> = uvs.iter().map(|&uv| self.at(uv)).collect();
            for (row, &(position, normal)) in places.iter().enumerate() {
                let (before, after) = (places[row.saturating_sub(1)].0, places[(row + 1).min(layout.n_rows)].0);
                let flow = (after - before).reject_from_normalized(normal).normalize_or(Vec3::NEG_Y);
                let whorl = layout.whorl * (-(position.distance(layout.crown) / layout.whorl_radius).powi(2)).exp();
                let flow = glam::Quat::from_axis_angle(normal, whorl) * flow;
                let along = row as f32 / layout.n_rows as f32;
                roots.push(Root { position, normal, flow, back, along, uv: uvs[row] });
            }
        }
        let rows = layout.n_rows as u32 + 1;
        let mut faces = Vec::new();
        for column in 0..2 * n as u32 {
            for row in 0..layout.n_rows as u32 {
                let corner = column * rows + row;
                faces.push(vec![corner, corner + 1, corner + rows + 1, corner + rows]);
            }
        }
        RootGrid { roots, faces }
    }

    /// A grid without a parting: columns from a place on the scalp straight to the hairline all around it,
    /// closed, for hair that is gathered there. The flow is towards that place.
    pub fn grid_around(&self, centre: Vec3, n_columns: usize, n_rows: usize) -> RootGrid {
        let total = self.length_to[self.length_to.len() - 1];
        let centre_uv = self.uv_near(centre);
        let mut roots = Vec::new();
        for column in 0..n_columns {
            let share = column as f32 / n_columns as f32;
            let end = self.border_at(share * total);
            let begin = centre_uv + 0.25 * self.scale * (end - centre_uv).normalize();
            let uvs: Vec<Vec2> = (0..=n_rows).map(|row| begin.lerp(end, row as f32 / n_rows as f32)).collect();
            let places: Vec<(Vec3, Vec3)> = uvs.iter().map(|&uv| self.at(uv)).collect();
            for (row, &(position, normal)) in places.iter().enumerate() {
                let (before, after) = (places[row.saturating_sub(1)].0, places[(row + 1).min(n_rows)].0);
                let flow = (before - after).reject_from_normalized(normal).normalize_or(Vec3::Y);
                let back = 1.0 - (2.0 * share - 1.0).abs();
                roots.push(Root { position, normal, flow, back, along: row as f32 / n_rows as f32, uv: uvs[row] });
            }
        }
        let rows = n_rows as u32 + 1;
        let mut faces = Vec::new();
        for column in 0..n_columns as u32 {
            let next = (column + 1) % n_columns as u32 * rows;
            for row in 0..n_rows as u32 {
                let corner = column * rows + row;
                faces.push(vec![corner, corner + 1, next + row + 1, next + row]);
            }
        }
        RootGrid { roots, faces }
    }

    /// The way over the scalp from a root to another along a straight line of the chart, on the skin, as `n` segments.
    /// Columns are such lines: they never spread on the way to where they meet. The shortest way through space does
    /// that badly: seen from the forehead the nape is straight through the head, and hair would part there to go
    /// around both ears.
    pub fn way(&self, from: &Root, to: &Root, n: usize) -> Vec<Vec3> {
        (0..=n).map(|k| self.at(from.uv.lerp(to.uv, k as f32 / n as f32)).0).collect()
    }

    /// Density of hair that is combed back: denser over the forehead and the temples, where nothing lies over it.
    pub fn combed_density(&self) -> ScalpMap {
        self.map(|p, _, inside| {
            let bare = smoothstep(5.0, 1.5, inside) * smoothstep(-1.0, 2.5, p.z);
            plain_density(p, inside) * (1.0 + (DENSER_IN_FRONT - 1.0) * bare) / DENSER_IN_FRONT
        })
    }

    /// Plain density where hair grows all ways from a crown: densest there, where nothing lies over it.
    pub fn whorl_density(&self, crown: Vec3) -> ScalpMap {
        self.map(|p, _, inside| {
            let bare = smoothstep(2.6, 0.8, p.distance(crown));
            plain_density(p, inside) * (1.0 + (DENSEST - 1.0) * bare) / DENSEST
        })
    }

    /// Hair's density: densest along the parting and at the crown, thinning over an irregular centimetre to
    /// the hairline, sparser at the temples.
    pub fn hair_density(&self, layout: &Layout) -> ScalpMap {
        let (front, crown) = (self.border_at(self.parting_begin(layout)), self.uv_near(layout.crown));
        let line = crown - front;
        self.map(|p, uv, inside| {
            let edge = smoothstep(0.0, 1.0, ragged(p, inside));
            let temple = 0.35 * smoothstep(2.2, 0.0, inside) * smoothstep(1.0, 4.0, p.z);
            let nape = 0.4 * smoothstep(2.5, 0.0, inside) * smoothstep(-3.5, -6.5, p.y);
            let on_line = front + ((uv - front).dot(line) / line.length_squared()).clamp(0.0, 1.0) * line;
            let (from_line, from_crown) = (uv.distance(on_line) / self.scale, uv.distance(crown) / self.scale);
            let bare = smoothstep(1.3, 0.4, from_line).max(smoothstep(2.6, 0.8, from_crown));
            edge * (1.0 - temple - nape) * (1.0 + (DENSER - 1.0) * bare) / DENSER
        })
    }

    /// Fly-aways' density: none above the face, across which they would hang.
    pub fn fly_away_density(&self) -> ScalpMap {
        self.map(|p, _, inside| {
            smoothstep(0.3, 1.2, inside) * (1.0 - smoothstep(4.5, 2.0, inside) * smoothstep(-1.0, 2.5, p.z))
        })
    }

    /// Baby hairs' density: a ragged band along the hairline.
    pub fn baby_density(&self) -> ScalpMap {
        self.map(|p, _, inside| {
            let band =
                smoothstep(1.5, 0.3, inside + 0.3 * noise(p * 1.7)) * (0.75 + 0.5 * noise(p * 2.3)).clamp(0.1, 1.0);
            let ear = smoothstep(0.4, 0.8, (p.z + 1.7).abs() / 3.0 + if p.y > 3.4 { 1.0 } else { 0.0 });
            band * ear
        })
    }

    /// A map from a function of place, texture coordinates and distance from the hairline (cm).
    fn map(&self, density: impl Fn(Vec3, Vec2, f32) -> f32) -> ScalpMap {
        let mut texels = vec![0.0f32; (MAP_SIZE * MAP_SIZE) as usize];
        let texel_of = |uv: Vec2| vec2(uv.x, 1.0 - uv.y) * MAP_SIZE as f32 - Vec2::splat(0.5);
        for [a, b, c] in &self.triangles {
            let [ta, tb, tc] = [a, b, c].map(|corner| texel_of(corner.0));
            let (min, max) = (ta.min(tb).min(tc).floor(), ta.max(tb).max(tc).ceil());
            for y in min.y as u32..=max.y as u32 {
                for x in min.x as u32..=max.x as u32 {
                    let (e, f, q) = (tb - ta, tc - ta, vec2(x as f32, y as f32) - ta);
                    let det = e.perp_dot(f);
                    let (u, v) = (q.perp_dot(f) / det, e.perp_dot(q) / det);
                    if u < -0.01 || v < -0.01 || u + v > 1.01 {
                        continue;
                    }
                    let p = a.1 + u * (b.1 - a.1) + v * (c.1 - a.1);
                    let uv = a.0 + u * (b.0 - a.0) + v * (c.0 - a.0);
                    texels[(y * MAP_SIZE + x) as usize] = density(p, uv, self.inside(p)).clamp(0.0, 1.0);
                }
            }
        }
        let texel = |x: u32, y: u32| (255.0 * texels[(y * MAP_SIZE + x) as usize]).round() as u8;
        ScalpMap::from_fn(MAP_SIZE, MAP_SIZE, texel).expect("a size within the limits")
    }

    /// Distance from the hairline, centimetres.
    fn inside(&self, p: Vec3) -> f32 {
        let squared = self.border.windows(2).map(|edge| {
            let (a, ab) = (edge[0].1, edge[1].1 - edge[0].1);
            let t = ((p - a).dot(ab) / ab.length_squared().max(1e-9)).clamp(0.0, 1.0);
            (a + t * ab).distance_squared(p)
        });
        squared.fold(f32::MAX, f32::min).sqrt()
    }
}

/// Density without a parting at a place and its distance from the hairline in centimetres: full, thinning over an
/// irregular centimetre to the hairline.
fn plain_density(p: Vec3, inside: f32) -> f32 {
    let temple = 0.3 * smoothstep(2.2, 0.0, inside) * smoothstep(1.0, 4.0, p.z);
    smoothstep(0.0, 0.8, ragged(p, inside)) * (1.0 - temple)
}

/// The distance from the hairline as the hair has it, which grows out of no ruled line.
fn ragged(p: Vec3, inside: f32) -> f32 {
    inside + 0.35 * noise(p * 1.1) + 0.25 * noise(p * 3.1)
}

/// Smooth noise in about [-1, 1] over space, one feature a unit: sines in turned directions.
pub fn noise(p: Vec3) -> f32 {
    let wave = |x: f32, y: f32, z: f32, phase: f32| (p.dot(Vec3::new(x, y, z)) + phase).sin();
    0.4 * wave(3.1, 1.7, -2.3, 0.3) + 0.35 * wave(-1.9, 4.1, 2.7, 1.9) + 0.3 * wave(4.3, -2.9, 3.7, 4.1)
}
