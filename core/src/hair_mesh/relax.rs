//! Where the inner vertices of a hair mesh go, so that a person need only shape its outside.
//!
//! Neighbouring edges from layer to layer should point alike: the sum over all sides of all prisms of
//! |(a1 - a0) - (b1 - b0)|^2 is made as small as it can be with the outer vertices where they are (Yuksel,
//! Schaefer and Keyser 2009, section 3.3), by conjugate gradients from where the inner vertices are now.

use glam::DVec3;

use super::HairMesh;

/// Conjugate gradients stop when the residual is this share of the first.
const TOLERANCE: f64 = 1e-6;
const MOST_ITERATIONS: usize = 500;

/// A side of a prism: two corners of a face, below and above, as indices over all vertices.
struct Side {
    a: [usize; 2],
    b: [usize; 2],
}

impl HairMesh {
    /// Per layer and vertex: is it on the outer surface? Tip faces and sides that no other bundle shares
    /// are; so is the root layer, which lies on the scalp.
    pub fn external_vertices(&self) -> Vec<Vec<bool>> {
        use std::collections::HashMap;
        let mut external: Vec<Vec<bool>> = self.layers.iter().map(|layer| vec![false; layer.positions.len()]).collect();
        if let Some(root) = external.first_mut() {
            root.fill(true);
        }
        for bundle in 0..self.n_bundles() {
            if let Some(tip) = self.tip_layer(bundle) {
                self.face(tip, bundle).into_iter().flatten().for_each(|&v| external[tip][v as usize] = true);
            }
        }
        for layer in 1..self.layers.len() {
            // A side is shared where two bundles have both its lower and its upper edge in common.
            let mut n_bundles_of: HashMap<[u32; 4], u32> = HashMap::new();
            let mut sides = Vec::new();
            for bundle in 0..self.n_bundles() {
                let (Some(above), Some(below)) = (self.face(layer, bundle), self.face(layer - 1, bundle)) else {
                    continue;
                };
                for i in 0..above.len() {
                    let j = (i + 1) % above.len();
                    let side = [below[i], above[i], below[j], above[j]];
                    let turned = [below[j], above[j], below[i], above[i]];
                    *n_bundles_of.entry(side.min(turned)).or_default() += 1;
                    sides.push(side);
                }
            }
            for side in sides {
                let turned = [side[2], side[3], side[0], side[1]];
                if n_bundles_of[&side.min(turned)] == 1 {
                    external[layer - 1][side[0] as usize] = true;
                    external[layer - 1][side[2] as usize] = true;
                    external[layer][side[1] as usize] = true;
                    external[layer][side[3] as usize] = true;
                }
            }
        }
        external
    }

    /// Place the inner vertices that are not pinned. Returns how many iterations that took.
    pub fn relax_inside(&mut self) -> usize {
        let mut fixed = self.external_vertices();
        for (fixed, layer) in fixed.iter_mut().zip(&self.layers) {
            layer.pinned.iter().for_each(|&v| fixed[v as usize] = true);
        }
        self.relax(|layer, v| fixed[layer][v as usize])
    }

    /// Place all vertices that are not `fixed` (asked by layer and vertex; the root layer always is) so
    /// that neighbouring edges point alike. Returns how many iterations that took.
    pub fn relax(&mut self, fixed: impl Fn(usize, u32) -> bool) -> usize {
        let mut first_of_layer = vec![0];
        for layer in &self.layers {
            first_of_layer.push(first_of_layer[first_of_layer.len() - 1] + layer.positions.len());
        }
        let mut free = vec![false; first_of_layer[self.layers.len()]];
        let mut sides = Vec::new();
        for layer in 1..self.layers.len() {
            for v in 0..self.layers[layer].positions.len() {
                free[first_of_layer[layer] + v] = !fixed(layer, v as u32);
            }
            for bundle in 0..self.n_bundles() {
                let (Some(above), Some(below)) = (self.face(layer, bundle), self.face(layer - 1, bundle)) else {
                    continue;
                };
                let edge = |i: usize| {
                    [first_of_layer[layer - 1] + below[i] as usize, first_of_layer[layer] + above[i] as usize]
                };
                sides.extend((0..above.len()).map(|i| Side { a: edge(i), b: edge((i + 1) % above.len()) }));
            }
        }
        let mut x: Vec<DVec3> = self.layers.iter().flat_map(|layer| &layer.positions).map(|p| p.as_dvec3()).collect();
        let n_iterations = minimise(&sides, &free, &mut x);
        let mut moved = x.into_iter().map(DVec3::as_vec3);
        for p in self.layers.iter_mut().flat_map(|layer| &mut layer.positions) {
            *p = moved.next().unwrap_or(*p);
        }
        n_iterations
    }
}

/// Half the gradient of the sum at `x`, for the free vertices.
fn half_gradient(sides: &[Side], free: &[bool], x: &[DVec3]) -> Vec<DVec3> {
    let mut gradient = vec![DVec3::ZERO; x.len()];
    for Side { a, b } in sides {
        let d = (x[a[1]] - x[a[0]]) - (x[b[1]] - x[b[0]]);
        for (v, of_v) in [(a[1], d), (a[0], -d), (b[1], -d), (b[0], d)] {
            gradient[v] += of_v;
        }
    }
    for (g, &free) in gradient.iter_mut().zip(free) {
        if !free {
            *g = DVec3::ZERO;
        }
    }
    gradient
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

/// Conjugate gradients (Shewchuk 1994, section B2) over the free vertices.
fn minimise(sides: &[Side], free: &[bool], x: &mut [DVec3]) -> usize {
    let mut residual: Vec<DVec3> = half_gradient(sides, free, x).into_iter().map(|g| -g).collect();
    let mut direction = residual.clone();
    let mut squared = dot(&residual, &residual);
    let enough = TOLERANCE * TOLERANCE * squared;
    // Single-precision positions a metre from the origin leave a residual of about 1e-5 cm each.
    let rounding = 1e-10 * x.len() as f64;
    for iteration in 0..MOST_ITERATIONS {
        if squared <= enough || squared < rounding {
            return iteration;
        }
        let along = half_gradient(sides, free, &direction);
        let alpha = squared / dot(&direction, &along).max(f64::MIN_POSITIVE);
        for i in 0..x.len() {
            x[i] += alpha * direction[i];
            residual[i] -= alpha * along[i];
        }
        let before = squared;
        squared = dot(&residual, &residual);
        let beta = squared / before;
        for i in 0..x.len() {
            direction[i] = residual[i] + beta * direction[i];
        }
    }
    MOST_ITERATIONS
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use crate::hair_mesh::tests::straight_grid;

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
        let n_iterations = mesh.relax(|layer, v| external[layer][v as usize]);
        assert!((1..80).contains(&n_iterations), "{n_iterations}");
        for (a, b) in mesh.layers.iter().zip(&straight.layers) {
            assert!(a.positions.iter().zip(&b.positions).all(|(a, b)| a.distance(*b) < 1e-4));
        }
        assert_eq!(mesh.relax(|layer, v| external[layer][v as usize]), 0);
    }

    #[test]
    fn the_inside_follows_a_bent_outside() {
        let mut mesh = straight_grid(4, 5);
        let external = mesh.external_vertices();
        let bend = |layer: usize, p: Vec3| p + Vec3::X * 0.1 * (layer * layer) as f32;
        for layer in 1..6 {
            mesh.move_vertices(layer, |v, p| if external[layer][v as usize] { bend(layer, p) } else { p });
        }
        mesh.relax(|layer, v| external[layer][v as usize]);
        let straight = straight_grid(4, 5);
        for layer in 0..6 {
            for (p, q) in mesh.layers[layer].positions.iter().zip(&straight.layers[layer].positions) {
                // Every outer edge is bent alike, so the inner ones have the same edges at the minimum.
                assert!(p.distance(bend(layer, *q)) < 1e-4, "{p} {q}");
            }
        }
    }
}
