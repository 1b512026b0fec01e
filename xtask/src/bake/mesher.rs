//! From the mannequin's distance to triangles of the size each region deserves.
//!
//! Surface nets on a fine grid give a closed surface; then short edges are collapsed until every edge is
//! as long as its region wants (Botsch and Kobbelt 2004), edges are flipped to Delaunay, vertices relaxed
//! along the surface and projected onto it. Decimation by quadric error was rejected: it saves triangles
//! on the scalp, where even triangles are wanted for roots.

use std::collections::HashMap;

use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::{UVec3, Vec3, uvec3, vec3};

use super::mannequin::Mannequin;
use super::sdf::smoothstep;

/// Fine enough for the groove of a closed lid.
const CELL: f32 = 0.15;
const MIN: Vec3 = vec3(-20.4, -27.0, -15.5);
const MAX: Vec3 = vec3(20.4, 12.2, 12.8);

/// A mesh that is being edited: triangles, and the triangles around each vertex.
pub struct Surface {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    around: Vec<Vec<u32>>,
}

const DEAD: [u32; 3] = [u32::MAX; 3];

/// Edge length wanted at a place of the skin (cm).
fn edge_length(mannequin: &Mannequin, p: Vec3) -> f32 {
    let q = vec3(p.x.abs(), p.y, p.z);
    let near = |centre: Vec3, r: f32| smoothstep(r, 0.55 * r, (q - centre).length());
    let body = 0.75 + 0.55 * smoothstep(-13.0, -18.0, p.y);
    // The rim of the cut is tighter than the rest of the shoulders.
    let rim = smoothstep(17.0, 18.5, q.x).max(smoothstep(-23.5, -25.0, p.y));
    let body = body + (0.7 - body) * rim;
    let face = near(vec3(0.0, -3.0, 8.0), 10.5);
    let features =
        near(vec3(3.2, -0.2, 7.6), 2.6).max(near(vec3(0.0, -3.6, 10.0), 2.4)).max(near(vec3(0.0, -6.7, 9.0), 3.6));
    let ear = smoothstep(0.7, 0.2, mannequin.ear_distance(p));
    let length = body + (0.36 - body) * face;
    let length = length + (0.2 - length) * features;
    let length = length + (0.15 - length) * near(vec3(3.2, -0.3, 7.8), 2.1);
    length + (0.24 - length) * ear
}

/// Mesh the mannequin.
pub fn mesh(mannequin: &Mannequin) -> Surface {
    let (positions, triangles) = raw(mannequin);
    // A groove that ends under the skin leaves a bubble there: only the outer surface counts.
    let outer = largest_piece(&triangles, &vec![true; triangles.len()]);
    let triangles = outer.into_iter().map(|t| triangles[t as usize]).collect();
    let mut surface = Surface::new((positions, triangles));
    for round in 0..6 {
        surface.collapse_short_edges(mannequin);
        surface.flip_to_delaunay(mannequin);
        surface.compact();
        surface.relax(mannequin, if round < 5 { 2 } else { 6 });
    }
    surface.flip_to_delaunay(mannequin);
    surface
}

/// Surface nets on the narrow band around the skin.
fn raw(mannequin: &Mannequin) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    const BLOCK: u32 = 8;
    let n = ((MAX - MIN) / CELL).ceil().as_uvec3() + UVec3::splat(2);
    let shape = RuntimeShape::<u32, 3>::new(n.to_array());
    let mut values = vec![0.0f32; shape.size() as usize];
    let at = |ijk: UVec3| MIN + CELL * ijk.as_vec3();
    let n_blocks = (n + UVec3::splat(BLOCK - 1)) / BLOCK;
    for block in (0..n_blocks.x * n_blocks.y * n_blocks.z)
        .map(|b| uvec3(b % n_blocks.x, b / n_blocks.x % n_blocks.y, b / (n_blocks.x * n_blocks.y)))
    {
        let first = block * BLOCK;
        let end = (first + UVec3::splat(BLOCK)).min(n);
        let centre = mannequin.distance(at(first) + Vec3::splat(0.5 * BLOCK as f32 * CELL));
        // Ellipsoids only estimate their distance: twice the half diagonal is on the safe side.
        let far = centre.abs() > 2.0 * 0.87 * BLOCK as f32 * CELL;
        for k in first.z..end.z {
            for j in first.y..end.y {
                for i in first.x..end.x {
                    values[shape.linearize([i, j, k]) as usize] =
                        if far { centre } else { mannequin.distance(at(uvec3(i, j, k))) };
                }
            }
        }
    }
    let mut net = SurfaceNetsBuffer::default();
    surface_nets(&values, &shape, [0; 3], (n - UVec3::ONE).to_array(), &mut net);
    let positions = net.positions.iter().map(|&p| MIN + CELL * Vec3::from_array(p)).collect();
    let triangles = net.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (positions, triangles)
}

impl Surface {
    fn new((positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> Self {
        let mut around = vec![Vec::with_capacity(8); positions.len()];
        for (t, triangle) in triangles.iter().enumerate() {
            for &v in triangle {
                around[v as usize].push(t as u32);
            }
        }
        Self { positions, triangles, around }
    }

    /// Normal of a triangle times twice its area.
    fn area_normal(&self, [a, b, c]: [u32; 3]) -> Vec3 {
        let [a, b, c] = [a, b, c].map(|v| self.positions[v as usize]);
        (b - a).cross(c - a)
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut all: Vec<u32> =
            self.around[v as usize].iter().flat_map(|&t| self.triangles[t as usize]).filter(|&u| u != v).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    fn collapse_short_edges(&mut self, mannequin: &Mannequin) {
        let mut wanted: Vec<f32> = self.positions.iter().map(|&p| edge_length(mannequin, p)).collect();
        let mut edges: Vec<(f32, u32, u32)> = Vec::new();
        for &[a, b, c] in self.triangles.iter().filter(|&&t| t != DEAD) {
            for (u, v) in [(a, b), (b, c), (c, a)] {
                let ratio = self.positions[u as usize].distance(self.positions[v as usize])
                    / (0.5 * (wanted[u as usize] + wanted[v as usize]));
                if u < v && ratio < 0.8 {
                    edges.push((ratio, u, v));
                }
            }
        }
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, a, b) in edges {
            if self.around[a as usize].is_empty() || self.around[b as usize].is_empty() {
                continue;
            }
            let wish = 0.5 * (wanted[a as usize] + wanted[b as usize]);
            if self.positions[a as usize].distance(self.positions[b as usize]) > 0.8 * wish {
                continue;
            }
            self.collapse(mannequin, &mut wanted, a, b, 1.3 * wish);
        }
    }

    /// Move `a` onto the middle of edge (a, b) and drop `b`, where that keeps the surface a surface.
    fn collapse(&mut self, mannequin: &Mannequin, wanted: &mut [f32], a: u32, b: u32, longest: f32) {
        let (around_a, around_b) = (self.neighbours(a), self.neighbours(b));
        if !around_a.contains(&b) || around_a.iter().filter(|v| around_b.contains(v)).count() != 2 {
            return;
        }
        let middle = mannequin.project(0.5 * (self.positions[a as usize] + self.positions[b as usize]));
        let too_long = around_a
            .iter()
            .chain(&around_b)
            .any(|&v| v != a && v != b && middle.distance(self.positions[v as usize]) > longest);
        if too_long {
            return;
        }
        for (v, other) in [(a, b), (b, a)] {
            for &t in &self.around[v as usize] {
                let triangle = self.triangles[t as usize];
                if triangle.contains(&other) {
                    continue;
                }
                let [p, q, r] = triangle.map(|u| if u == v { middle } else { self.positions[u as usize] });
                let after = (q - p).cross(r - p);
                let before = self.area_normal(triangle);
                let longest_edge = (q - p).length().max((r - q).length()).max((p - r).length());
                let shortest_height = after.length() / longest_edge;
                if after.dot(before) < 0.3 * after.length() * before.length() || shortest_height < 0.12 * longest_edge {
                    return;
                }
            }
        }
        self.positions[a as usize] = middle;
        wanted[a as usize] = edge_length(mannequin, middle);
        for t in std::mem::take(&mut self.around[b as usize]) {
            let triangle = self.triangles[t as usize];
            if triangle.contains(&a) {
                for v in triangle {
                    self.around[v as usize].retain(|&u| u != t);
                }
                self.triangles[t as usize] = DEAD;
            } else {
                self.triangles[t as usize] = triangle.map(|v| if v == b { a } else { v });
                self.around[a as usize].push(t);
            }
        }
    }

    /// Flip edges whose opposite angles sum to more than 180 degrees.
    fn flip_to_delaunay(&mut self, mannequin: &Mannequin) {
        for _ in 0..4 {
            let mut n_flipped = 0;
            let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
            for (t, &[a, b, c]) in self.triangles.iter().enumerate().filter(|&(_, &t)| t != DEAD) {
                for edge in [(a, b), (b, c), (c, a)] {
                    of_edge.insert(edge, t as u32);
                }
            }
            let mut edges: Vec<(u32, u32)> = of_edge.keys().copied().filter(|&(u, v)| u < v).collect();
            edges.sort_unstable();
            for (a, b) in edges {
                let (Some(&left), Some(&right)) = (of_edge.get(&(a, b)), of_edge.get(&(b, a))) else { continue };
                let third = |t: u32| self.triangles[t as usize].into_iter().find(|&v| v != a && v != b);
                let has = |t: u32| self.triangles[t as usize].contains(&a) && self.triangles[t as usize].contains(&b);
                if !has(left) || !has(right) {
                    continue;
                }
                let (Some(c), Some(d)) = (third(left), third(right)) else { continue };
                if self.flip(mannequin, [a, b, c, d], left, right) {
                    n_flipped += 1;
                }
            }
            if n_flipped == 0 {
                break;
            }
        }
    }

    /// Replace edge (a, b) between triangles (a, b, c) and (b, a, d) by (c, d).
    fn flip(&mut self, mannequin: &Mannequin, [a, b, c, d]: [u32; 4], left: u32, right: u32) -> bool {
        if c == d || self.neighbours(c).contains(&d) {
            return false;
        }
        let p = |v: u32| self.positions[v as usize];
        let angle = |at: u32, u: u32, v: u32| (p(u) - p(at)).angle_between(p(v) - p(at));
        if angle(c, a, b) + angle(d, a, b) < std::f32::consts::PI + 0.02 {
            return false;
        }
        // Keep folds: flip only where the four corners are nearly flat and the normals stay outward.
        let (n0, n1) = (self.area_normal([a, b, c]), self.area_normal([b, a, d]));
        let (m0, m1) = (self.area_normal([c, a, d]), self.area_normal([c, d, b]));
        let outward = mannequin.normal(0.5 * (p(a) + p(b)));
        if n0.angle_between(n1) > 0.7 || m0.dot(outward) < 0.5 * m0.length() || m1.dot(outward) < 0.5 * m1.length() {
            return false;
        }
        self.triangles[left as usize] = [c, a, d];
        self.triangles[right as usize] = [c, d, b];
        self.around[a as usize].retain(|&t| t != right);
        self.around[b as usize].retain(|&t| t != left);
        self.around[c as usize].push(right);
        self.around[d as usize].push(left);
        true
    }

    /// Move every vertex towards the middle of its neighbours, along the surface.
    fn relax(&mut self, mannequin: &Mannequin, n_rounds: usize) {
        for _ in 0..n_rounds {
            let moved: Vec<Vec3> = (0..self.positions.len() as u32)
                .map(|v| {
                    let p = self.positions[v as usize];
                    let around = self.neighbours(v);
                    if around.is_empty() {
                        return p;
                    }
                    let middle = around.iter().map(|&u| self.positions[u as usize]).sum::<Vec3>() / around.len() as f32;
                    let normal = mannequin.normal(p);
                    let along = (middle - p).reject_from_normalized(normal);
                    mannequin.project(p + 0.5 * along)
                })
                .collect();
            self.positions = moved;
        }
    }

    fn compact(&mut self) {
        let mut new_index = vec![u32::MAX; self.positions.len()];
        let mut positions = Vec::new();
        self.triangles.retain(|&t| t != DEAD);
        for v in self.triangles.iter_mut().flatten() {
            let index = &mut new_index[*v as usize];
            if *index == u32::MAX {
                *index = positions.len() as u32;
                positions.push(self.positions[*v as usize]);
            }
            *v = *index;
        }
        *self = Self::new((positions, std::mem::take(&mut self.triangles)));
    }

    /// Cut along the zero of `f`, so that no edge crosses it; returns the sign of each triangle.
    pub fn cut(&mut self, mannequin: &Mannequin, f: impl Fn(Vec3) -> f32) -> Vec<bool> {
        let mut value: Vec<f32> = self.positions.iter().map(|&p| f(p)).collect();
        let crossing = |mut p: Vec3, mut q: Vec3| {
            let from = f(p) > 0.0;
            for _ in 0..24 {
                let middle = mannequin.project(0.5 * (p + q));
                if (f(middle) > 0.0) == from { p = middle } else { q = middle }
            }
            p
        };
        // Vertices near the curve move onto it: no slivers.
        for v in 0..self.positions.len() as u32 {
            let p = self.positions[v as usize];
            let nearest = self
                .neighbours(v)
                .into_iter()
                .filter(|&u| value[u as usize] * value[v as usize] < 0.0)
                .map(|u| (crossing(p, self.positions[u as usize]), self.positions[u as usize].distance(p)))
                .min_by(|a, b| a.0.distance(p).total_cmp(&b.0.distance(p)));
            if let Some((on, length)) = nearest.filter(|(on, length)| on.distance(p) < 0.3 * length) {
                let _ = length;
                self.positions[v as usize] = on;
                value[v as usize] = 0.0;
            }
        }
        let mut on_edge: HashMap<(u32, u32), u32> = HashMap::new();
        let mut triangles = Vec::with_capacity(self.triangles.len() + 1024);
        for triangle in self.triangles.clone() {
            let mut polygon = Vec::with_capacity(5);
            for i in 0..3 {
                let (u, v) = (triangle[i], triangle[(i + 1) % 3]);
                polygon.push(u);
                if value[u as usize] * value[v as usize] < 0.0 {
                    let key = (u.min(v), u.max(v));
                    let new = *on_edge.entry(key).or_insert_with(|| {
                        self.positions.push(crossing(self.positions[key.0 as usize], self.positions[key.1 as usize]));
                        value.push(0.0);
                        self.positions.len() as u32 - 1
                    });
                    polygon.push(new);
                }
            }
            // Split between two zeros, so that each part has one sign.
            let zeros: Vec<usize> = (0..polygon.len()).filter(|&i| value[polygon[i] as usize] == 0.0).collect();
            match (polygon.len(), zeros.as_slice()) {
                (3, _) => triangles.push(triangle),
                (n, &[i, j, ..]) => {
                    for part in [(i..=j).collect::<Vec<_>>(), (j..=i + n).map(|k| k % n).collect()] {
                        for k in 1..part.len() - 1 {
                            triangles.push([polygon[part[0]], polygon[part[k]], polygon[part[k + 1]]]);
                        }
                    }
                }
                (n, _) => (1..n - 1).for_each(|k| triangles.push([polygon[0], polygon[k], polygon[k + 1]])),
            }
        }
        let sign = triangles.iter().map(|t| t.iter().map(|&v| value[v as usize]).sum::<f32>() > 0.0).collect();
        *self = Self::new((std::mem::take(&mut self.positions), triangles));
        sign
    }
}

/// The largest connected set among the marked triangles.
pub fn largest_piece(triangles: &[[u32; 3]], marked: &[bool]) -> Vec<u32> {
    let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate().filter(|&(t, _)| marked[t]) {
        for edge in [(a, b), (b, c), (c, a)] {
            of_edge.insert(edge, t as u32);
        }
    }
    let mut seen = vec![false; triangles.len()];
    let mut best = Vec::new();
    for start in (0..triangles.len() as u32).filter(|&t| marked[t as usize]) {
        if std::mem::replace(&mut seen[start as usize], true) {
            continue;
        }
        let mut piece = vec![start];
        let mut next = 0;
        while next < piece.len() {
            let [a, b, c] = triangles[piece[next] as usize];
            for edge in [(b, a), (c, b), (a, c)] {
                if let Some(&u) = of_edge.get(&edge)
                    && !std::mem::replace(&mut seen[u as usize], true)
                {
                    piece.push(u);
                }
            }
            next += 1;
        }
        if piece.len() > best.len() {
            best = piece;
        }
    }
    best
}
