//! Growing bundles by a layer and shortening them (paper 3.2: Face Extrude, Face Delete).

use std::collections::HashMap;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::op::demand_any;
use super::work::{Vertex, Work, edges};
use super::{HairMesh, HairMeshError, Report};
use crate::curve::{catmull_rom, even_parameters};

/// Whether faces that are extruded join the faces of the next layer that are already there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Weld {
    /// Share vertices with neighbours that were extruded before.
    Neighbours,
    /// Share vertices only among the faces of this call: a parting opens to the rest.
    Apart,
}

/// A vertex that is being extruded from a layer to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extruded {
    /// The layer it comes from.
    pub layer: usize,
    /// Its index there.
    pub vertex: u32,
    pub position: Vec3,
}

/// Which way faces are extruded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Along {
    /// Each vertex along the normal of the faces around it that are extruded.
    Normal,
    /// Each vertex the way its hair came; from the root layer, along the normal.
    Onward,
    /// From the way the hair came (0) to straight down (1).
    Gravity { pull: f32 },
    /// All vertices one way; any length but 0.
    Direction(Vec3),
    /// All faces together along a curve through these points, turning with it; only its shape counts: it
    /// begins in the middle of the faces and is scaled to the length of the extrusion.
    Curve(Vec<Vec3>),
}

/// More layers than this in one extrusion are a slip of the hand.
const MOST_LAYERS: u32 = 256;

impl HairMesh {
    /// Extrude the tip faces of `bundles` by one layer: `place` says where each vertex goes.
    /// Faces that share a vertex in their tip layer share its copy.
    pub fn extrude(
        &mut self,
        bundles: &[usize],
        weld: Weld,
        place: impl FnMut(Extruded) -> Vec3,
    ) -> Result<Report, HairMeshError> {
        let mut work = Work::on(self);
        work.extrude(bundles, weld, place)?;
        let (mesh, report) = work.finish()?;
        *self = mesh;
        Ok(report)
    }
}

/// Copies that stand in the layer above: by layer, vertex and the other end of an edge they share with
/// the new face, and by layer and vertex alone.
#[derive(Default)]
struct Copies {
    of_edge: HashMap<(usize, u32, u32), u32>,
    of_vertex: HashMap<(usize, u32), u32>,
}

impl Copies {
    fn put(&mut self, layer: usize, below: &[u32], above: &[u32]) {
        let n = below.len();
        for i in 0..n {
            for neighbour in [below[(i + 1) % n], below[(i + n - 1) % n]] {
                self.of_edge.entry((layer, below[i], neighbour)).or_insert(above[i]);
            }
            self.of_vertex.entry((layer, below[i])).or_insert(above[i]);
        }
    }

    /// A face that shares an edge is nearer than one that shares only the vertex.
    fn get(&self, layer: usize, before: u32, vertex: u32, after: u32) -> Option<u32> {
        let of_edge = [after, before].into_iter().find_map(|end| self.of_edge.get(&(layer, vertex, end)));
        of_edge.or_else(|| self.of_vertex.get(&(layer, vertex))).copied()
    }
}

impl Work {
    pub(super) fn extrude(
        &mut self,
        bundles: &[usize],
        weld: Weld,
        mut place: impl FnMut(Extruded) -> Vec3,
    ) -> Result<(), HairMeshError> {
        demand_any(bundles, "faces")?;
        let bundles = unique(bundles);
        let mut tips = Vec::with_capacity(bundles.len());
        for &bundle in &bundles {
            tips.push((bundle, self.tip_layer(bundle)?));
        }
        let mut copies = Copies::default();
        if weld == Weld::Neighbours {
            for layer in 1..self.layers.len() {
                for (bundle, above) in self.layers[layer].bundles() {
                    if let Some(below) = self.face(layer - 1, bundle) {
                        copies.put(layer - 1, below, above);
                    }
                }
            }
        }
        for (bundle, tip) in tips {
            if self.layers.len() == tip + 1 {
                self.push_layer();
            }
            let below = self.layers[tip].faces[bundle].clone().unwrap_or_default();
            let n = below.len();
            let mut above = Vec::with_capacity(n);
            for (i, &vertex) in below.iter().enumerate() {
                let copy = copies.get(tip, below[(i + n - 1) % n], vertex, below[(i + 1) % n]);
                above.push(copy.unwrap_or_else(|| {
                    let from = self.layers[tip].vertices[vertex as usize];
                    let position = place(Extruded { layer: tip, vertex, position: from.position });
                    self.layers[tip + 1].push(Vertex { position, pinned: false, ..from.copy() })
                }));
            }
            copies.put(tip, &below, &above);
            self.layers[tip + 1].faces[bundle] = Some(above);
        }
        Ok(())
    }

    pub(super) fn extrude_along(
        &mut self,
        bundles: &[usize],
        along: &Along,
        length_cm: f32,
        n_layers: u32,
        weld: Weld,
    ) -> Result<(), HairMeshError> {
        if !(1..=MOST_LAYERS).contains(&n_layers) {
            return Err(HairMeshError::OutOfRange { what: "the number of layers", min: "1", max: "256" });
        }
        if !length_cm.is_finite() || length_cm.abs() > 1e4 {
            return Err(HairMeshError::OutOfRange { what: "the length", min: "-10000", max: "10000 cm" });
        }
        demand_any(bundles, "faces")?;
        let step = length_cm / n_layers as f32;
        match along {
            Along::Direction(direction) => {
                let way = direction.try_normalize().ok_or(HairMeshError::NoDirection { what: "the direction" })?;
                for _ in 0..n_layers {
                    self.extrude(bundles, weld, |v| v.position + step * way)?;
                }
            }
            Along::Curve(points) => self.extrude_along_curve(bundles, points, length_cm, n_layers, weld)?,
            Along::Normal | Along::Onward | Along::Gravity { .. } => {
                for _ in 0..n_layers {
                    let ways = self.ways(bundles, along)?;
                    self.extrude(bundles, weld, |v| v.position + step * ways[&(v.layer, v.vertex)])?;
                }
            }
        }
        Ok(())
    }

    /// Unit directions for the tip vertices of `bundles`, by layer and vertex.
    fn ways(&self, bundles: &[usize], along: &Along) -> Result<HashMap<(usize, u32), Vec3>, HairMeshError> {
        let mut normals: HashMap<(usize, u32), Vec3> = HashMap::new();
        let mut onward: HashMap<(usize, u32), Vec3> = HashMap::new();
        for &bundle in bundles {
            let tip = self.tip_layer(bundle)?;
            let face = self.face(tip, bundle).unwrap_or_default();
            let position = |v: u32| self.layers[tip].position(v) - self.layers[tip].position(face[0]);
            // Newell's normal, as long as twice the area.
            let normal: Vec3 = edges(face).map(|[a, b]| position(a).cross(position(b))).sum();
            for &v in face {
                *normals.entry((tip, v)).or_default() += normal;
            }
            if let Some(below) = tip.checked_sub(1) {
                for (&v, &on) in face.iter().zip(self.face(below, bundle).unwrap_or_default()) {
                    onward.insert((tip, v), self.layers[tip].position(v) - self.layers[below].position(on));
                }
            }
        }
        let way = |(id, normal): ((usize, u32), Vec3)| {
            let normal = normal.normalize_or(Vec3::Y);
            let onward = onward.get(&id).map_or(normal, |way| way.normalize_or(normal));
            let way = match along {
                Along::Normal => normal,
                Along::Gravity { pull } => onward.lerp(Vec3::NEG_Y, pull.clamp(0.0, 1.0)).normalize_or(Vec3::NEG_Y),
                Along::Onward | Along::Direction(_) | Along::Curve(_) => onward,
            };
            (id, way)
        };
        Ok(normals.into_iter().map(way).collect())
    }

    fn extrude_along_curve(
        &mut self,
        bundles: &[usize],
        points: &[Vec3],
        length_cm: f32,
        n_layers: u32,
        weld: Weld,
    ) -> Result<(), HairMeshError> {
        const NO_CURVE: HairMeshError = HairMeshError::NoDirection { what: "the curve" };
        if points.len() < 2 || points.iter().any(|p| !p.is_finite()) {
            return Err(NO_CURVE);
        }
        let samples = even_parameters(points, n_layers as usize + 1).into_iter().map(|u| catmull_rom(points, u));
        let samples: Vec<Vec3> = samples.collect();
        let length: f32 = samples.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
        if length <= 1e-6 {
            return Err(NO_CURVE);
        }
        let mut tip_vertices = Vec::new();
        for &bundle in bundles {
            let tip = self.tip_layer(bundle)?;
            tip_vertices.extend(self.face(tip, bundle).unwrap_or_default().iter().map(|&v| (tip, v)));
        }
        tip_vertices.sort_unstable();
        tip_vertices.dedup();
        let sum: Vec3 = tip_vertices.iter().map(|&(layer, v)| self.layers[layer].position(v)).sum();
        let mut middle = sum / tip_vertices.len().max(1) as f32;
        let mut way_before: Option<Vec3> = None;
        for ends in samples.windows(2) {
            let offset = (ends[1] - ends[0]) * (length_cm / length);
            let way = offset.normalize_or(way_before.unwrap_or(Vec3::Y));
            let turn = way_before.map_or(Quat::IDENTITY, |before| Quat::from_rotation_arc(before, way));
            self.extrude(bundles, weld, |v| middle + turn * (v.position - middle) + offset)?;
            middle += offset;
            way_before = Some(way);
        }
        Ok(())
    }

    pub(super) fn delete_tips(&mut self, bundles: &[usize]) -> Result<(), HairMeshError> {
        demand_any(bundles, "faces")?;
        for bundle in unique(bundles) {
            let tip = self.tip_layer(bundle)?;
            self.layers[tip].faces[bundle] = None;
        }
        Ok(())
    }

    pub(super) fn delete_bundles(&mut self, bundles: &[usize]) -> Result<(), HairMeshError> {
        demand_any(bundles, "bundles")?;
        for bundle in unique(bundles) {
            self.tip_layer(bundle)?;
            self.layers.iter_mut().for_each(|layer| layer.faces[bundle] = None);
        }
        Ok(())
    }
}

/// Each bundle once, in the order given.
fn unique(bundles: &[usize]) -> Vec<usize> {
    let mut seen = std::collections::HashSet::new();
    bundles.iter().copied().filter(|&bundle| seen.insert(bundle)).collect()
}
