//! Putting a layer between two others and taking one out (paper 3.2: Layer Insert, Layer Remove).
//!
//! Both act on all faces that are connected in the layer, so that every vertex goes on standing on one.

use super::op::{demand_any, demand_share};
use super::work::{Vertex, Work};
use super::{HairMeshError, VertexId};
use crate::curve::catmull_rom;

impl Work {
    pub(super) fn insert_layer(&mut self, bundles: &[usize], layer: usize, at: f32) -> Result<(), HairMeshError> {
        demand_share(at)?;
        if layer == 0 {
            return Err(HairMeshError::RootLayer { done: "given a layer below it" });
        }
        let inside = self.connected(bundles, layer)?;
        let places = self.places_below(layer, at);
        self.push_layer();
        for k in (layer..self.layers.len() - 1).rev() {
            self.shift(&inside, k, k + 1);
        }
        // The new layer has the faces of the one above it.
        let n_above = self.layers[layer + 1].vertices.len();
        let mut copy_of = vec![u32::MAX; n_above];
        for bundle in (0..inside.len()).filter(|&bundle| inside[bundle]) {
            for &v in self.layers[layer + 1].faces[bundle].iter().flatten() {
                copy_of[v as usize] = 0;
            }
        }
        for v in (0..n_above).filter(|&v| copy_of[v] == 0).collect::<Vec<_>>() {
            let vertex = self.layers[layer + 1].vertices[v];
            let super::work::Origin::Kept(VertexId { vertex: old, .. }) = vertex.origin else { continue };
            let copy = Vertex { position: places[old as usize], pinned: false, ..vertex.copy() };
            copy_of[v] = self.layers[layer].push(copy);
        }
        for bundle in (0..inside.len()).filter(|&bundle| inside[bundle]) {
            let face = self.layers[layer + 1].faces[bundle].iter().flatten();
            self.layers[layer].faces[bundle] = Some(face.map(|&v| copy_of[v as usize]).collect());
        }
        Ok(())
    }

    pub(super) fn remove_layer(&mut self, bundles: &[usize], layer: usize) -> Result<(), HairMeshError> {
        if layer == 0 {
            return Err(HairMeshError::RootLayer { done: "removed" });
        }
        let inside = self.connected(bundles, layer)?;
        for bundle in (0..inside.len()).filter(|&bundle| inside[bundle]) {
            self.layers[layer].faces[bundle] = None;
        }
        for k in layer + 1..self.layers.len() {
            self.shift(&inside, k, k - 1);
        }
        Ok(())
    }

    /// Which bundles are connected in `layer`, from vertex to vertex, with one of `bundles`.
    fn connected(&self, bundles: &[usize], layer: usize) -> Result<Vec<bool>, HairMeshError> {
        demand_any(bundles, "faces of the layer")?;
        for &bundle in bundles {
            self.tip_layer(bundle)?;
            if self.face(layer, bundle).is_none() {
                return Err(HairMeshError::NoLayer { layer, bundle });
            }
        }
        let bundles_of = self.layers[layer].bundles_of_vertex();
        let mut inside = vec![false; self.n_bundles()];
        let mut open = bundles.to_vec();
        while let Some(bundle) = open.pop() {
            if std::mem::replace(&mut inside[bundle], true) {
                continue;
            }
            for &v in self.face(layer, bundle).unwrap_or_default() {
                open.extend(bundles_of[v as usize].iter().filter(|&&neighbour| !inside[neighbour]));
            }
        }
        Ok(inside)
    }

    /// For every vertex of `layer`, a place at the share `at` of the way up to it from the layer below, on
    /// the curve through the layers.
    fn places_below(&self, layer: usize, at: f32) -> Vec<glam::Vec3> {
        let parents = self.parents(layer);
        let grandparents = self.parents(layer - 1);
        let n = parents.len();
        // A vertex may have several above it: the curve goes to their middle.
        let mut above = vec![(glam::Vec3::ZERO, 0.0_f32); n];
        if layer + 1 < self.layers.len() {
            let next = &self.layers[layer + 1];
            for (vertex, on) in next.vertices.iter().zip(self.parents(layer + 1)) {
                if let Some((sum, n)) = above.get_mut(on as usize) {
                    *sum += vertex.position;
                    *n += 1.0;
                }
            }
        }
        let place = |v: usize| {
            let position = self.layers[layer].position(v as u32);
            let Some(parent) = self.layers[layer - 1].vertices.get(parents[v] as usize) else { return position };
            let grandparent = grandparents[parents[v] as usize];
            let mut points = Vec::with_capacity(4);
            if layer >= 2 && grandparent != u32::MAX {
                points.push(self.layers[layer - 2].position(grandparent));
            }
            let u = points.len() as f32 + at;
            points.extend([parent.position, position]);
            if above[v].1 > 0.0 {
                points.push(above[v].0 / above[v].1);
            }
            catmull_rom(&points, u)
        };
        (0..n).map(place).collect()
    }

    /// Move the faces of bundles with their vertices from one layer to another, where the bundles have
    /// none. No other bundle uses those vertices.
    fn shift(&mut self, inside: &[bool], from: usize, to: usize) {
        let mut new_index = vec![u32::MAX; self.layers[from].vertices.len()];
        for bundle in (0..inside.len()).filter(|&bundle| inside[bundle]) {
            for &v in self.layers[from].faces[bundle].iter().flatten() {
                new_index[v as usize] = 0;
            }
        }
        // In the order of their indices, so that what was in order stays so.
        for v in 0..new_index.len() {
            if new_index[v] == 0 {
                let vertex = self.layers[from].vertices[v];
                new_index[v] = self.layers[to].push(vertex);
            }
        }
        for bundle in (0..inside.len()).filter(|&bundle| inside[bundle]) {
            let face = self.layers[from].faces[bundle].take();
            self.layers[to].faces[bundle] = face.map(|face| face.into_iter().map(|v| new_index[v as usize]).collect());
        }
    }
}
