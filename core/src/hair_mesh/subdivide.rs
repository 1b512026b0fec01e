//! Subdivision of layers, carried through whole bundles (paper 3.2).
//!
//! Every layer is subdivided as a surface of its own: an edge that is separated there is a border. What
//! lies between subdivided and other bundles stays in place, and the others get corners there. The root
//! layer's vertices stay too: they lie on the scalp, and smoothing would sink them into the head.

use std::collections::HashMap;

use glam::Vec3;

use super::work::{Work, WorkLayer, edge_of, edges};
use super::{HairMeshError, Scheme};

/// Places of a layer's vertices and of the middles of its edges after subdivision.
struct Smoothed {
    vertices: Vec<Vec3>,
    middle_of: HashMap<[u32; 2], Vec3>,
}

/// An edge of a layer with what lies around it.
#[derive(Default)]
struct Around {
    n_faces: u32,
    n_chosen: u32,
    /// Over the chosen faces: sum of their middles, and of the corners opposite to the edge.
    middles: Vec3,
    opposite: Vec3,
}

impl Work {
    pub(super) fn subdivide(&mut self, bundles: &[usize], scheme: Scheme) -> Result<(), HairMeshError> {
        let mut chosen = vec![bundles.is_empty(); self.n_bundles()];
        for &bundle in bundles {
            self.tip_layer(bundle)?;
            chosen[bundle] = true;
        }
        let chosen: Vec<usize> = (0..chosen.len()).filter(|&b| chosen[b] && self.face(0, b).is_some()).collect();
        if chosen.is_empty() {
            return Err(HairMeshError::NothingSelected { needed: "bundles" });
        }
        if scheme == Scheme::Loop {
            let n_corners = |bundle: usize| self.face(0, bundle).map_or(0, <[u32]>::len);
            if let Some(&bundle) = chosen.iter().find(|&&bundle| n_corners(bundle) != 3) {
                return Err(HairMeshError::NotTriangle { bundle, n_corners: n_corners(bundle) });
            }
        }
        let smoothed: Vec<Smoothed> = self
            .layers
            .iter()
            .enumerate()
            .map(|(layer, faces)| smoothed(faces, &chosen, if layer == 0 { Scheme::Linear } else { scheme }))
            .collect();
        let mut root_edges = std::collections::HashSet::new();
        for &bundle in &chosen {
            root_edges.extend(edges(self.face(0, bundle).unwrap_or_default()).map(|[a, b]| edge_of(a, b)));
        }
        // The middles of faces are taken before anything moves.
        self.split_edges(&|edge| root_edges.contains(&edge), &mut |layer, edge, [p, q]| {
            smoothed[layer].middle_of.get(&edge).copied().unwrap_or((p + q) / 2.0)
        });
        match scheme {
            Scheme::CatmullClark | Scheme::Linear => {
                let middles: Vec<Vec<(usize, Vec3)>> = self.middles_of_old_corners(&chosen);
                for &bundle in &chosen {
                    self.divide_around_middle(bundle, 2);
                }
                for (layer, middles) in self.layers.iter_mut().zip(middles) {
                    for (bundle, middle) in middles {
                        // The middle is the last corner of each part.
                        if let Some(&v) = layer.faces[bundle].as_ref().and_then(|face| face.last()) {
                            layer.vertices[v as usize].position = middle;
                        }
                    }
                }
            }
            Scheme::Loop => chosen.iter().for_each(|&bundle| self.divide_in_four(bundle)),
        }
        for (layer, smoothed) in self.layers.iter_mut().zip(&smoothed) {
            for (vertex, &place) in layer.vertices.iter_mut().zip(&smoothed.vertices) {
                vertex.position = if vertex.pinned { vertex.position } else { place };
            }
        }
        Ok(())
    }

    /// Per layer: the middle of each chosen face's corners from before its edges were split, which are
    /// every second one.
    fn middles_of_old_corners(&self, chosen: &[usize]) -> Vec<Vec<(usize, Vec3)>> {
        let of_layer = |layer: &WorkLayer| {
            let middle = |&bundle: &usize| {
                let face = layer.faces[bundle].as_ref()?;
                let corners: Vec<u32> = face.iter().step_by(2).copied().collect();
                Some((bundle, middle(layer, &corners)))
            };
            chosen.iter().filter_map(middle).collect()
        };
        self.layers.iter().map(of_layer).collect()
    }

    /// A triangle whose edges were split becomes four; the one at its first corner keeps its number.
    fn divide_in_four(&mut self, bundle: usize) {
        let parts = [bundle, self.push_bundle(), self.push_bundle(), self.push_bundle()];
        for layer in &mut self.layers {
            let Some(&[v0, e0, v1, e1, v2, e2]) = layer.faces[bundle].as_deref() else { break };
            for (part, face) in parts.into_iter().zip([[v0, e0, e2], [e0, v1, e1], [e2, e1, v2], [e0, e1, e2]]) {
                layer.faces[part] = Some(face.to_vec());
            }
        }
    }
}

fn middle(layer: &WorkLayer, face: &[u32]) -> Vec3 {
    face.iter().map(|&v| layer.position(v)).sum::<Vec3>() / face.len() as f32
}

fn smoothed(layer: &WorkLayer, chosen: &[usize], scheme: Scheme) -> Smoothed {
    let mut around: HashMap<[u32; 2], Around> = HashMap::new();
    let mut is_chosen = vec![false; layer.faces.len()];
    for &bundle in chosen {
        is_chosen[bundle] = true;
    }
    for (bundle, face) in layer.bundles() {
        let middle = middle(layer, face);
        for (i, [a, b]) in edges(face).enumerate() {
            let edge = around.entry(edge_of(a, b)).or_default();
            edge.n_faces += 1;
            if is_chosen[bundle] {
                edge.n_chosen += 1;
                edge.middles += middle;
                edge.opposite += layer.position(face[(i + 2) % face.len()]);
            }
        }
    }
    let smooth = |edge: &Around| edge.n_faces == 2 && edge.n_chosen == 2;
    let middle_of = around.iter().filter(|(_, edge)| edge.n_chosen > 0).map(|(&[a, b], edge)| {
        let ends = layer.position(a) + layer.position(b);
        let place = match scheme {
            Scheme::CatmullClark if smooth(edge) => (ends + edge.middles) / 4.0,
            Scheme::Loop if smooth(edge) => (3.0 * ends + edge.opposite) / 8.0,
            Scheme::CatmullClark | Scheme::Loop | Scheme::Linear => ends / 2.0,
        };
        ([a, b], place)
    });
    let middle_of = middle_of.collect();
    let vertices: Vec<Vec3> = layer.vertices.iter().map(|vertex| vertex.position).collect();
    let vertices = match scheme {
        Scheme::Linear => vertices,
        Scheme::CatmullClark | Scheme::Loop => smooth_vertices(layer, &is_chosen, &around, &vertices, scheme),
    };
    Smoothed { vertices, middle_of }
}

/// What the vertex rules of both schemes ask about.
#[derive(Default, Clone)]
struct Star {
    n_faces: u32,
    n_chosen: u32,
    /// Sum over the faces around.
    middles: Vec3,
    /// Other ends of the edges: inner ones and those of the border.
    inner: Vec<u32>,
    border: Vec<u32>,
}

fn smooth_vertices(
    layer: &WorkLayer,
    is_chosen: &[bool],
    around: &HashMap<[u32; 2], Around>,
    positions: &[Vec3],
    scheme: Scheme,
) -> Vec<Vec3> {
    let mut stars = vec![Star::default(); positions.len()];
    for (bundle, face) in layer.bundles() {
        let middle = middle(layer, face);
        for &v in face {
            let star = &mut stars[v as usize];
            star.n_faces += 1;
            star.n_chosen += u32::from(is_chosen[bundle]);
            star.middles += middle;
        }
    }
    let mut edges: Vec<(&[u32; 2], &Around)> = around.iter().collect();
    // Sums of single-precision numbers depend on their order.
    edges.sort_unstable_by_key(|(ends, _)| **ends);
    for (&[a, b], edge) in edges {
        for (v, other) in [(a, b), (b, a)] {
            let star = &mut stars[v as usize];
            if edge.n_faces == 2 { star.inner.push(other) } else { star.border.push(other) }
        }
    }
    let sum = |ends: &[u32]| ends.iter().map(|&v| positions[v as usize]).sum::<Vec3>();
    let smooth = |(star, &p): (&Star, &Vec3)| {
        let n = star.n_faces as f32;
        if star.n_faces == 0 || star.n_chosen < star.n_faces {
            return p;
        }
        match (star.border.len(), scheme) {
            // Catmull and Clark 1978.
            (0, Scheme::CatmullClark) => {
                let f = star.middles / n;
                let r = star.inner.iter().map(|&v| (p + positions[v as usize]) / 2.0).sum::<Vec3>() / n;
                (f + 2.0 * r + (n - 3.0) * p) / n
            }
            // Loop 1987, with Warren's weights.
            (0, _) => {
                let beta = if star.n_faces == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * n) };
                (1.0 - n * beta) * p + beta * sum(&star.inner)
            }
            // A border is a cubic B-spline; the corner of a single face stays.
            (2, _) if star.n_faces > 1 => 0.75 * p + 0.125 * sum(&star.border),
            _ => p,
        }
    };
    stars.iter().zip(positions).map(smooth).collect()
}
