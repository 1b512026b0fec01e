//! Where the inner vertices of a hair mesh go, so that a person need only shape its outside.
//!
//! Neighbouring edges from layer to layer should point alike: the sum over all sides of all prisms of
//! |(a1 - a0) - (b1 - b0)|^2 is made as small as it can be with the outer vertices where they are (Yuksel,
//! Schaefer and Keyser 2009, section 3.3), by conjugate gradients from where the inner vertices are now.
//!
//! Along a chain the sum is a stiff system and across the chains a mild one; so the preconditioner is a
//! symmetric Gauss-Seidel sweep over whole chains, each solved exactly (it is tridiagonal). Without it
//! conjugate gradients need ten times as many rounds. A [`Relaxer`] keeps the system while vertices are
//! dragged. A Cholesky factor was rejected: it fills up with the number of layers.

use std::hash::{DefaultHasher, Hash, Hasher};

use glam::{DVec3, Vec4};

use super::work::edges;
use super::{HairMesh, VertexId};

/// Rounds of conjugate gradients at most.
const MOST_ITERATIONS: usize = 500;
const NONE: u32 = u32::MAX;

/// How far the inner vertices are moved towards their places.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accuracy {
    /// To a thousandth of the way: each frame of a drag goes on from the frame before.
    Drag,
    /// As far as single-precision places allow.
    Full,
}

/// What relaxing took and what is left.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Relaxed {
    pub n_iterations: usize,
    /// Estimated distance of the inner vertices from their places, root mean square, in centimetres.
    pub error_before: f64,
    pub error: f64,
}

/// The quadratic of one topology and one set of fixed vertices, ready to be minimised again and again.
#[derive(Debug, Clone, Default)]
pub struct Relaxer {
    topology: u64,
    /// Index over all vertices of each layer's first.
    first_of_layer: Vec<usize>,
    /// Sides of prisms as the vertices a0, a1, b0, b1, and how many prisms have them.
    sides: Vec<([u32; 4], f32)>,
    /// Free vertices, chain by chain from the root up, as indices over all vertices.
    order: Vec<u32>,
    /// Place in `order` of every vertex; `NONE` for fixed ones.
    place: Vec<u32>,
    /// First place of each chain, and the end.
    chains: Vec<u32>,
    /// The matrix of the free vertices. Entries within a chain: the diagonal and the one above it.
    diagonal: Vec<f32>,
    next: Vec<f32>,
    /// All other entries of row `i` are `row_start[i]..row_start[i + 1]`; from `row_later[i]` on they are in
    /// later chains.
    row_start: Vec<u32>,
    row_later: Vec<u32>,
    columns: Vec<u32>,
    weights: Vec<f32>,
    /// LDL^T of each chain's own block: inverse pivots, and the factors above the diagonal.
    inverse_pivot: Vec<f32>,
    factor: Vec<f32>,
}

impl HairMesh {
    /// Per layer and vertex: is it outside or pinned, and so not placed by relaxing?
    pub fn fixed_vertices(&self) -> Vec<Vec<bool>> {
        let mut fixed = self.external_vertices();
        for (fixed, layer) in fixed.iter_mut().zip(&self.layers) {
            for &v in &layer.pinned {
                fixed[v as usize] = true;
            }
        }
        fixed
    }

    /// Place the inner vertices that are not pinned.
    pub fn relax_inside(&mut self) -> Relaxed {
        Relaxer::new(self).relax(self, Accuracy::Full)
    }

    /// Place all vertices that are not `fixed` (asked by layer and vertex; the root layer always is) so
    /// that neighbouring edges point alike.
    pub fn relax(&mut self, fixed: impl Fn(usize, u32) -> bool) -> Relaxed {
        Relaxer::with_fixed(self, fixed).relax(self, Accuracy::Full)
    }
}

impl Relaxer {
    /// For the inner vertices that are not pinned.
    pub fn new(mesh: &HairMesh) -> Self {
        let fixed = mesh.fixed_vertices();
        Self::with_fixed(mesh, |layer, v| fixed[layer][v as usize])
    }

    /// For all vertices that are not `fixed`; the root layer always is.
    pub fn with_fixed(mesh: &HairMesh, fixed: impl Fn(usize, u32) -> bool) -> Self {
        let mut relaxer = Self { topology: topology_of(mesh), first_of_layer: vec![0], ..Self::default() };
        for layer in &mesh.layers {
            let first = relaxer.first_of_layer[relaxer.first_of_layer.len() - 1];
            relaxer.first_of_layer.push(first + layer.positions.len());
        }
        let mut parent = vec![NONE; relaxer.n_vertices()];
        for layer in 1..mesh.layers.len() {
            let first = [relaxer.first_of_layer[layer - 1] as u32, relaxer.first_of_layer[layer] as u32];
            for bundle in 0..mesh.n_bundles() {
                let (Some(below), Some(above)) = (mesh.face(layer - 1, bundle), mesh.face(layer, bundle)) else {
                    continue;
                };
                for (&v, &on) in above.iter().zip(below) {
                    parent[(first[1] + v) as usize] = first[0] + on;
                }
                for ([a0, b0], [a1, b1]) in edges(below).zip(edges(above)) {
                    let (a, b) = ([first[0] + a0, first[1] + a1], [first[0] + b0, first[1] + b1]);
                    let ([a0, a1], [b0, b1]) = if a < b { (a, b) } else { (b, a) };
                    relaxer.sides.push(([a0, a1, b0, b1], 1.0));
                }
            }
        }
        relaxer.sides.sort_unstable_by_key(|(side, _)| *side);
        relaxer.sides.dedup_by(|later, first| {
            let same = later.0 == first.0;
            first.1 += if same { later.1 } else { 0.0 };
            same
        });
        let is_free = |v: usize| {
            let layer = relaxer.first_of_layer.partition_point(|&first| first <= v) - 1;
            layer > 0 && parent[v] != NONE && !fixed(layer, (v - relaxer.first_of_layer[layer]) as u32)
        };
        let free: Vec<bool> = (0..relaxer.n_vertices()).map(is_free).collect();
        relaxer.put_in_chains(&free, &parent);
        relaxer.assemble();
        relaxer.factorise();
        relaxer
    }

    /// Whether this was made for a hair mesh of the same topology and pins.
    pub fn fits(&self, mesh: &HairMesh) -> bool {
        self.topology == topology_of(mesh)
    }

    /// The vertices that are placed.
    pub fn free(&self) -> impl Iterator<Item = VertexId> {
        self.order.iter().map(|&v| {
            let layer = self.first_of_layer.partition_point(|&first| first <= v as usize) - 1;
            VertexId { layer, vertex: v - self.first_of_layer[layer] as u32 }
        })
    }

    /// How many vertices are placed.
    pub fn n_free(&self) -> usize {
        self.order.len()
    }

    fn n_vertices(&self) -> usize {
        self.first_of_layer.last().copied().unwrap_or(0)
    }

    /// Order the free vertices in chains: each goes on with the first free vertex that stands on it.
    fn put_in_chains(&mut self, free: &[bool], parent: &[u32]) {
        let mut child = vec![NONE; free.len()];
        for v in (0..free.len()).rev().filter(|&v| free[v]) {
            if parent[v] != NONE {
                child[parent[v] as usize] = v as u32;
            }
        }
        self.place = vec![NONE; free.len()];
        for v in (0..free.len()).filter(|&v| free[v]) {
            if self.place[v] != NONE {
                continue;
            }
            self.chains.push(self.order.len() as u32);
            let mut link = v as u32;
            while link != NONE && free[link as usize] {
                self.place[link as usize] = self.order.len() as u32;
                self.order.push(link);
                link = child[link as usize];
            }
        }
        self.chains.push(self.order.len() as u32);
    }

    fn assemble(&mut self) {
        const SIGNS: [f32; 4] = [-1.0, 1.0, 1.0, -1.0];
        let n = self.order.len();
        let mut entries: Vec<(u32, u32, f32)> = Vec::with_capacity(16 * self.sides.len());
        for (side, weight) in &self.sides {
            let places = side.map(|v| self.place[v as usize]);
            for (i, &p) in places.iter().enumerate().filter(|(_, p)| **p != NONE) {
                for (j, &q) in places.iter().enumerate().filter(|(_, q)| **q != NONE) {
                    entries.push((p, q, weight * SIGNS[i] * SIGNS[j]));
                }
            }
        }
        entries.sort_unstable_by_key(|&(p, q, _)| (p, q));
        entries.dedup_by(|later, first| {
            let same = (later.0, later.1) == (first.0, first.1);
            first.2 += if same { later.2 } else { 0.0 };
            same
        });
        let mut chain_of = vec![0; n];
        for (chain, ends) in self.chains.windows(2).enumerate() {
            chain_of[ends[0] as usize..ends[1] as usize].fill(chain);
        }
        self.diagonal = vec![0.0; n];
        self.next = vec![0.0; n];
        self.row_start = Vec::with_capacity(n + 1);
        let mut at = 0;
        for row in 0..n {
            self.row_start.push(self.columns.len() as u32);
            let mut later = None;
            while let Some(&(p, q, weight)) = entries.get(at).filter(|(p, ..)| *p as usize == row) {
                at += 1;
                if q == p {
                    self.diagonal[row] = weight;
                } else if chain_of[q as usize] == chain_of[row] {
                    // Layers that are not neighbours share no side: only the next in the chain can be here.
                    if q as usize == row + 1 {
                        self.next[row] = weight;
                    }
                } else {
                    if chain_of[q as usize] > chain_of[row] {
                        later.get_or_insert(self.columns.len() as u32);
                    }
                    self.columns.push(q);
                    self.weights.push(weight);
                }
            }
            self.row_later.push(later.unwrap_or(self.columns.len() as u32));
        }
        self.row_start.push(self.columns.len() as u32);
    }

    fn factorise(&mut self) {
        self.inverse_pivot = vec![0.0; self.order.len()];
        self.factor = vec![0.0; self.order.len()];
        for ends in self.chains.windows(2) {
            let mut taken = 0.0;
            for i in ends[0] as usize..ends[1] as usize {
                // A vertex that nothing holds has no pivot of its own; this keeps it where it is.
                let pivot = (self.diagonal[i] - taken).max(1e-4 * self.diagonal[i].max(1.0));
                self.inverse_pivot[i] = 1.0 / pivot;
                self.factor[i] = self.next[i] / pivot;
                taken = self.factor[i] * self.next[i];
            }
        }
    }

    /// Move the free vertices of `mesh`, which this was made for, to where they belong, from where they are.
    pub fn relax(&self, mesh: &mut HairMesh, accuracy: Accuracy) -> Relaxed {
        let n = self.order.len();
        let mut outcome = Relaxed::default();
        if n == 0 {
            return outcome;
        }
        let mut largest = 10.0_f32;
        for p in mesh.layers.iter().flat_map(|layer| &layer.positions) {
            largest = largest.max(p.abs().max_element());
        }
        // Single-precision places are known to about this, which a full relaxing takes for nothing.
        let rounding = 1e-6 * f64::from(largest);
        let mut residual = self.residual(mesh);
        let mut z = vec![Vec4::ZERO; n];
        let mut scratch = vec![Vec4::ZERO; n];
        self.precondition(&residual, &mut z, &mut scratch);
        let mut direction = z.clone();
        let mut along = vec![Vec4::ZERO; n];
        let mut moved = vec![Vec4::ZERO; n];
        let mut energy = dot(&residual, &z);
        let error = |energy: f64| (energy.max(0.0) / n as f64).sqrt();
        outcome.error_before = error(energy);
        let enough = match accuracy {
            Accuracy::Drag => (1e-3 * outcome.error_before).max(rounding),
            Accuracy::Full => (1e-6 * outcome.error_before).max(rounding),
        };
        while error(energy) > enough && outcome.n_iterations < MOST_ITERATIONS {
            self.multiply(&direction, &mut along);
            let alpha = (energy / dot(&direction, &along).max(f64::MIN_POSITIVE)) as f32;
            for i in 0..n {
                moved[i] += alpha * direction[i];
                residual[i] -= alpha * along[i];
            }
            self.precondition(&residual, &mut z, &mut scratch);
            let before = energy;
            energy = dot(&residual, &z);
            let beta = (energy / before) as f32;
            for i in 0..n {
                direction[i] = z[i] + beta * direction[i];
            }
            outcome.n_iterations += 1;
        }
        outcome.error = error(energy);
        if outcome.n_iterations > 0 {
            for (&v, moved) in self.order.iter().zip(&moved) {
                let layer = self.first_of_layer.partition_point(|&first| first <= v as usize) - 1;
                mesh.layers[layer].positions[v as usize - self.first_of_layer[layer]] += moved.truncate();
            }
        }
        outcome
    }

    /// Minus half the gradient of the sum at the mesh's places, for the free vertices.
    fn residual(&self, mesh: &HairMesh) -> Vec<Vec4> {
        let x: Vec<DVec3> = mesh.layers.iter().flat_map(|layer| &layer.positions).map(|p| p.as_dvec3()).collect();
        let mut residual = vec![DVec3::ZERO; self.order.len()];
        for ([a0, a1, b0, b1], weight) in &self.sides {
            let at = |v: &u32| x[*v as usize];
            let d = f64::from(*weight) * ((at(a1) - at(a0)) - (at(b1) - at(b0)));
            for (v, of_v) in [(a1, -d), (a0, d), (b1, d), (b0, -d)] {
                let place = self.place[*v as usize];
                if place != NONE {
                    residual[place as usize] += of_v;
                }
            }
        }
        residual.into_iter().map(|r| r.as_vec3().extend(0.0)).collect()
    }

    /// The matrix times `x`.
    fn multiply(&self, x: &[Vec4], product: &mut [Vec4]) {
        let mut from_before = Vec4::ZERO;
        for (i, product) in product.iter_mut().enumerate() {
            let mut sum = self.diagonal[i] * x[i] + from_before;
            if self.next[i] != 0.0 {
                sum += self.next[i] * x[i + 1];
            }
            from_before = self.next[i] * x[i];
            *product = sum + self.row(self.row_start[i], self.row_start[i + 1], x);
        }
    }

    #[inline]
    fn row(&self, start: u32, end: u32, x: &[Vec4]) -> Vec4 {
        let range = start as usize..end as usize;
        let mut sum = Vec4::ZERO;
        for (&column, &weight) in self.columns[range.clone()].iter().zip(&self.weights[range]) {
            sum += weight * x[column as usize];
        }
        sum
    }

    /// z = (D + U)^-1 D (D + L)^-1 r with D the blocks of the chains.
    fn precondition(&self, r: &[Vec4], z: &mut [Vec4], scratch: &mut [Vec4]) {
        for ends in self.chains.windows(2) {
            let chain = ends[0] as usize..ends[1] as usize;
            for i in chain.clone() {
                scratch[i] = r[i] - self.row(self.row_start[i], self.row_later[i], z);
            }
            self.solve_chain(chain.clone(), scratch);
            z[chain.clone()].copy_from_slice(&scratch[chain]);
        }
        for ends in self.chains.windows(2).rev() {
            let chain = ends[0] as usize..ends[1] as usize;
            for i in chain.clone() {
                scratch[i] = self.row(self.row_later[i], self.row_start[i + 1], z);
            }
            self.solve_chain(chain.clone(), scratch);
            for i in chain {
                z[i] -= scratch[i];
            }
        }
    }

    /// Solve a chain's own block in place.
    fn solve_chain(&self, chain: std::ops::Range<usize>, x: &mut [Vec4]) {
        for i in chain.clone().skip(1) {
            let from_below = self.factor[i - 1] * x[i - 1];
            x[i] -= from_below;
        }
        let mut above = Vec4::ZERO;
        for i in chain.rev() {
            x[i] = self.inverse_pivot[i] * x[i] - self.factor[i] * above;
            above = x[i];
        }
    }
}

fn dot(a: &[Vec4], b: &[Vec4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.dot(*b))).sum()
}

fn topology_of(mesh: &HairMesh) -> u64 {
    let mut hasher = DefaultHasher::new();
    for layer in &mesh.layers {
        (layer.positions.len(), &layer.faces, &layer.pinned).hash(&mut hasher);
    }
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::tests::straight_grid;
    use super::super::{MeshOp, VertexId};
    use super::*;

    #[test]
    fn outside_is_what_one_can_touch() {
        let external = straight_grid(3, 4).external_vertices();
        let n_inside: Vec<usize> = external.iter().map(|layer| layer.iter().filter(|e| !**e).count()).collect();
        // Four inner vertices in each layer but the root and the tip.
        assert_eq!(n_inside, [0, 4, 4, 4, 0]);
    }

    #[test]
    fn relaxing_straightens_the_inside_and_leaves_the_outside() {
        let straight = straight_grid(4, 5);
        let external = straight.external_vertices();
        let mut mesh = straight.clone();
        for layer in 1..5 {
            mesh.move_vertices(layer, |v, p| {
                let shift = Vec3::new((v as f32).sin(), (2.0 * v as f32).cos(), (3.0 * v as f32).sin());
                if external[layer][v as usize] { p } else { p + 0.7 * shift }
            });
        }
        let relaxed = mesh.relax(|layer, v| external[layer][v as usize]);
        assert!((1..20).contains(&relaxed.n_iterations), "{relaxed:?}");
        for (a, b) in mesh.layers.iter().zip(&straight.layers) {
            assert!(a.positions.iter().zip(&b.positions).all(|(a, b)| a.distance(*b) < 1e-4));
        }
        assert_eq!(mesh.relax(|layer, v| external[layer][v as usize]).n_iterations, 0);
    }

    #[test]
    fn the_inside_follows_a_bent_outside() {
        let mut mesh = straight_grid(4, 5);
        let external = mesh.external_vertices();
        let bend = |layer: usize, p: Vec3| p + Vec3::X * 0.1 * (layer * layer) as f32;
        for layer in 1..6 {
            mesh.move_vertices(layer, |v, p| if external[layer][v as usize] { bend(layer, p) } else { p });
        }
        mesh.relax_inside();
        let straight = straight_grid(4, 5);
        for layer in 0..6 {
            for (p, q) in mesh.layers[layer].positions.iter().zip(&straight.layers[layer].positions) {
                // Every outer edge is bent alike, so the inner ones have the same edges at the minimum.
                assert!(p.distance(bend(layer, *q)) < 1e-4, "{p} {q}");
            }
        }
    }

    /// The gradient of the paper's sum, straight from its definition.
    fn gradient(mesh: &HairMesh, free: impl Fn(usize, u32) -> bool) -> f64 {
        let mut gradient: Vec<Vec<DVec3>> =
            mesh.layers.iter().map(|layer| vec![DVec3::ZERO; layer.positions.len()]).collect();
        for layer in 1..mesh.layers.len() {
            for bundle in 0..mesh.n_bundles() {
                let (Some(below), Some(above)) = (mesh.face(layer - 1, bundle), mesh.face(layer, bundle)) else {
                    continue;
                };
                let at = |k: usize, v: u32| mesh.layers[k].positions[v as usize].as_dvec3();
                for ([a0, b0], [a1, b1]) in edges(below).zip(edges(above)) {
                    let d = (at(layer, a1) - at(layer - 1, a0)) - (at(layer, b1) - at(layer - 1, b0));
                    gradient[layer][a1 as usize] += d;
                    gradient[layer][b1 as usize] -= d;
                    gradient[layer - 1][a0 as usize] -= d;
                    gradient[layer - 1][b0 as usize] += d;
                }
            }
        }
        let mut worst = 0.0_f64;
        for (layer, gradient) in gradient.iter().enumerate() {
            for (_, g) in gradient.iter().enumerate().filter(|(v, _)| free(layer, *v as u32)) {
                worst = worst.max(g.length());
            }
        }
        worst
    }

    #[test]
    fn the_gradient_of_the_sum_vanishes_at_all_that_is_free_even_where_the_mesh_splits() {
        let mut mesh = straight_grid(6, 6);
        // A parting over the middle from layer 3 on, some bundles cut short, a pin out of place.
        let separate = mesh.layers[3].positions.iter().enumerate().filter(|(_, p)| p.x == 3.0);
        let vertices = separate.map(|(v, _)| VertexId { layer: 3, vertex: v as u32 }).collect();
        mesh.apply(&MeshOp::SeparateVertices { vertices }).unwrap();
        mesh.apply(&MeshOp::DeleteTips { bundles: vec![14, 15, 20, 21] }).unwrap();
        let vertex = mesh.layers[2].positions.iter().position(|p| p.x == 2.0 && p.z == 2.0).unwrap() as u32;
        mesh.layers[2].positions[vertex as usize] += Vec3::new(0.5, 0.2, 0.3);
        mesh.apply(&MeshOp::SetPinned { vertices: vec![VertexId { layer: 2, vertex }], pinned: true }).unwrap();
        for layer in 1..=6 {
            mesh.move_vertices(layer, |_, p| p + 0.05 * Vec3::new((7.0 * p.z).sin(), p.x.cos(), p.x * layer as f32));
        }
        let relaxer = Relaxer::new(&mesh);
        assert!(relaxer.fits(&mesh) && relaxer.n_free() > 50);
        let external = mesh.external_vertices();
        let free =
            |layer: usize, v: u32| layer > 0 && !external[layer][v as usize] && !mesh.layers[layer].pinned.contains(&v);
        let mut placed = mesh.clone();
        assert!(gradient(&placed, free) > 0.1);
        let outcome = relaxer.relax(&mut placed, Accuracy::Full);
        assert!(gradient(&placed, free) < 2e-4, "{outcome:?}");
        assert!(outcome.n_iterations < 40, "{outcome:?}");
        assert!(outcome.error < 1e-4 * outcome.error_before, "{outcome:?}");
        for layer in 0..=6 {
            for v in 0..mesh.layers[layer].positions.len() {
                let moved = placed.layers[layer].positions[v] != mesh.layers[layer].positions[v];
                assert!(!moved || free(layer, v as u32), "{v} of {layer} is fixed");
            }
        }
        // A drag goes on from the frame before and needs less.
        let tip = mesh.layers[6].positions.len() - 1;
        placed.layers[6].positions[tip] += Vec3::X * 0.2;
        let drag = relaxer.relax(&mut placed, Accuracy::Drag);
        assert!(drag.n_iterations <= outcome.n_iterations, "{drag:?}");
        placed.layers[2].pinned.clear();
        assert!(!relaxer.fits(&placed));
    }
}
