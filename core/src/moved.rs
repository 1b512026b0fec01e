//! What of a layer's hair a solver moves, and how the rest of the layer follows it.
//!
//! - **Guides**: every guide by itself; strands are blended between them.
//! - **Hair mesh** (Yuksel, Schaefer, Keyser 2009, section 4): the edges that lead a vertex of the mesh from layer to layer
//!   are the links of an articulated chain. Guides are splines through its joints, as they are when the mesh is modelled,
//!   so that hair at rest is the same hair.
//! - **Every strand**: the strands themselves, as style and brushes have made them.

use glam::Vec3;

use crate::binding::LayerBinding;
use crate::curve::{catmull_rom, catmull_rom_weights};
use crate::distance_field::DistanceField;
use crate::generate::{Pose, generate};
use crate::groom::{Layer, Source};
use crate::guides::{GuideSet, divide_gaps};
use crate::hair_mesh::{Chains, HairMesh};
use crate::maps::MapKind;
use crate::simulation::Moved;

/// Curves that a solver moves.
///
/// Without ties nothing is tied.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MovedHair {
    /// At rest, head space.
    pub curves: GuideSet,
    /// Share of each curve, from its root, that is tied to the style, 0-1.
    pub ties: Vec<f32>,
    pub follow: Follow,
}

/// How a layer's hair follows its moved curves.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Follow {
    /// They are its guides.
    #[default]
    Guides,
    /// Its guides are splines through their joints.
    Spline(Spline),
    /// They are its strands: the first is the first.
    Strands,
}

/// Guides as sums of the vertices of as many curves. Vertex `k` of guide `g` is the sum over `rows[first_rows[g] + k]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spline {
    /// Vertices of a guide.
    pub n_vertices: u32,
    pub first_rows: Vec<u32>,
    pub rows: Vec<SplineRow>,
    /// Where each vertex of a curve is along its guide, in the guide's vertices; a run for every height of bundle.
    samples: Vec<f32>,
}

/// Vertices of a curve, counted from its root, and their weights.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SplineRow {
    pub vertices: [u32; 4],
    pub weights: [f32; 4],
}

/// Most vertices of a moved strand: as many as a workgroup of the solver has threads.
const MOST_VERTICES: u32 = 64;
/// Where the chain of a hair mesh has a vertex of its own, as a share of its first part: the way that hair leaves the scalp.
const ROOT_SHARE: f32 = 0.15;

impl MovedHair {
    /// What is moved of a layer that is bound; `field` is the head's, in head space. A layer that is no hair mesh has
    /// nothing but guides to move instead.
    pub fn new(moved: Moved, layer: &Layer, binding: &LayerBinding, field: Option<&DistanceField>) -> Self {
        match (moved, &layer.source) {
            (Moved::Strands, _) => Self::of_strands(layer, binding, field),
            (Moved::Mesh, Source::HairMesh(mesh)) => Self::of_hair_mesh(mesh, binding),
            (Moved::Mesh | Moved::Guides, _) => {
                Self { curves: binding.guides.clone(), ties: binding.guide_ties(), follow: Follow::Guides }
            }
        }
    }

    fn of_hair_mesh(mesh: &HairMesh, binding: &LayerBinding) -> Self {
        let chains = mesh.chains();
        // A mesh of roots alone has no edge to move; and guides that were bound before the mesh changed are of another.
        let is_bound = chains.chains.len() == binding.guides.n_guides();
        if mesh.layers.len() < 2 || !is_bound {
            return Self { curves: binding.guides.clone(), ties: binding.guide_ties(), follow: Follow::Guides };
        }
        let (curves, spline) = joints_of(mesh, &chains, binding.guides.n_vertices);
        Self { curves, ties: binding.guide_ties(), follow: Follow::Spline(spline) }
    }

    fn of_strands(layer: &Layer, binding: &LayerBinding, field: Option<&DistanceField>) -> Self {
        let n_vertices = moved_vertices(layer);
        let layer = Layer { vertices_per_strand: n_vertices, ..layer.clone() };
        let strands = generate(binding, &layer, &binding.guides.positions, &Pose { field, ..Pose::default() });
        let painted = binding.map_idx(&MapKind::Tied);
        let tie = |strand_idx| binding.map_value(strand_idx, painted, 0.0).clamp(binding.tied.clamp(0.0, 1.0), 1.0);
        let ties = (0..strands.n_strands()).map(tie).collect();
        Self { curves: GuideSet { n_vertices, positions: strands.points }, ties, follow: Follow::Strands }
    }

    /// The curves of guides, or of strands, that are at `shown`: the inverse of following, as far as there is one.
    pub fn curves_of(&self, shown: &[Vec3]) -> Vec<Vec3> {
        let Follow::Spline(spline) = &self.follow else { return shown.to_vec() };
        let (n_guide, n_curve) = (spline.n_vertices as usize, self.curves.n_vertices as usize);
        let of_guide = |(guide, &first): (&[Vec3], &u32)| {
            let height = first as usize / n_guide;
            let samples = spline.samples[height * n_curve..(height + 1) * n_curve].iter();
            samples.map(|&at| catmull_rom(guide, at)).collect::<Vec<_>>()
        };
        shown.chunks_exact(n_guide).zip(&spline.first_rows).flat_map(of_guide).collect()
    }

    /// Vertices of what is drawn from: guides, or strands.
    pub fn n_shown(&self) -> usize {
        match &self.follow {
            Follow::Guides | Follow::Strands => self.curves.positions.len(),
            Follow::Spline(spline) => spline.first_rows.len() * spline.n_vertices as usize,
        }
    }
}

/// Vertices of the guides, or of the strands, that [`MovedHair::new`] moves of a layer.
pub fn n_moved(moved: Moved, layer: &Layer, binding: &LayerBinding) -> usize {
    match moved {
        Moved::Strands => binding.n_strands() * moved_vertices(layer) as usize,
        Moved::Guides | Moved::Mesh => binding.guides.positions.len(),
    }
}

/// Vertices of a strand that is moved by itself.
pub fn moved_vertices(layer: &Layer) -> u32 {
    layer.vertices_per_strand.clamp(4, MOST_VERTICES)
}

/// The chains of a hair mesh as curves of one vertex count, and how its guides run through their joints. Chains of lower
/// bundles have vertices between their joints.
fn joints_of(mesh: &HairMesh, chains: &Chains, n_guide: u32) -> (GuideSet, Spline) {
    let n_gaps_most = mesh.layers.len() - 1;
    let parameters_of: Vec<Vec<f32>> = (0..=n_gaps_most).map(|n_gaps| with_root(n_gaps, n_gaps_most)).collect();
    let n_vertices = n_gaps_most as u32 + 2;
    let mut positions = Vec::with_capacity(chains.chains.len() * n_vertices as usize);
    for chain in &chains.chains {
        let joints: Vec<Vec3> = chain.iter().zip(&mesh.layers).map(|(&v, layer)| layer.positions[v as usize]).collect();
        positions.extend(parameters_of[joints.len() - 1].iter().map(|&u| catmull_rom(&joints, u)));
    }
    let mut rows = Vec::with_capacity((n_gaps_most + 1) * n_guide as usize);
    let mut samples = Vec::with_capacity((n_gaps_most + 1) * n_vertices as usize);
    for (n_gaps, parameters) in parameters_of.iter().enumerate() {
        let joint = |k: usize| {
            let at = parameters.iter().position(|&u| u >= k as f32);
            at.unwrap_or(parameters.len() - 1) as u32
        };
        let joints: Vec<u32> = (0..=n_gaps).map(joint).collect();
        let of_guide = divide_gaps(n_gaps, n_guide.max(2) as usize - 1);
        rows.extend(of_guide.iter().map(|&u| row_at(&joints, u)));
        samples.extend(parameters.iter().map(|&u| sample_at(&of_guide, u)));
    }
    let first_rows = chains.chains.iter().map(|chain| (chain.len() as u32 - 1) * n_guide).collect();
    (GuideSet { n_vertices, positions }, Spline { n_vertices: n_guide, first_rows, rows, samples })
}

/// Parameters of a chain's vertices, in gaps: root, the way out of the scalp, and on, joints among them.
fn with_root(n_gaps: usize, n_gaps_most: usize) -> Vec<f32> {
    let mut parameters = divide_gaps(n_gaps, n_gaps_most);
    parameters.insert(1, ROOT_SHARE * parameters[1]);
    parameters
}

/// Where `u` is among rising `parameters`, in their indices.
fn sample_at(parameters: &[f32], u: f32) -> f32 {
    let above = parameters.iter().position(|&at| at >= u).unwrap_or(parameters.len() - 1);
    let Some(below) = above.checked_sub(1) else { return 0.0 };
    let gap = parameters[above] - parameters[below];
    below as f32 + if gap > 0.0 { ((u - parameters[below]) / gap).min(1.0) } else { 1.0 }
}

/// The Catmull-Rom spline through `joints` at `u`, beyond whose ends it is mirrored: as [`crate::curve::catmull_rom`].
fn row_at(joints: &[u32], u: f32) -> SplineRow {
    let last = joints.len() - 1;
    if last == 0 {
        return SplineRow { vertices: [joints[0]; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    }
    let u = u.clamp(0.0, last as f32);
    let segment = (u as usize).min(last - 1);
    let [before, mut here, mut next, after] = catmull_rom_weights(u - segment as f32);
    let (mut w_before, mut w_after) = (before, after);
    if segment == 0 {
        (here, next, w_before) = (here + 2.0 * before, next - before, 0.0);
    }
    if segment + 2 > last {
        (here, next, w_after) = (here - after, next + 2.0 * after, 0.0);
    }
    let vertices =
        [joints[segment.saturating_sub(1)], joints[segment], joints[segment + 1], joints[(segment + 2).min(last)]];
    SplineRow { vertices, weights: [w_before, here, next, w_after] }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::binding::bind_layer;
    use crate::hair_mesh::tests::straight_grid;
    use crate::hair_mesh::{HairMesh, Weld};

    /// Two bundles, one of them higher, bent.
    fn bent_mesh() -> HairMesh {
        let mut mesh = straight_grid(2, 3);
        mesh.extrude(&[0], Weld::Neighbours, |v| v.position + Vec3::new(0.5, 4.0, 1.0)).unwrap();
        for (k, layer) in mesh.layers.iter_mut().enumerate() {
            for (i, p) in layer.positions.iter_mut().enumerate() {
                *p += Vec3::new(0.3 * (k * k) as f32, 0.0, 0.2 * (i as f32 * k as f32).sin());
            }
        }
        mesh
    }

    #[test]
    fn guides_of_moved_chains_are_at_rest_the_guides_of_the_mesh() {
        let mesh = bent_mesh();
        let layer = Layer { n_strands: 20, ..Layer::new("a", Source::HairMesh(Arc::new(mesh.clone()))) };
        let binding = bind_layer(&layer, None);
        let moved = MovedHair::new(Moved::Mesh, &layer, &binding, None);
        let Follow::Spline(spline) = &moved.follow else { panic!() };
        let n = moved.curves.n_vertices as usize;
        assert_eq!((n, moved.curves.n_guides()), (mesh.layers.len() + 1, binding.guides.n_guides()));
        assert_eq!((moved.n_shown(), moved.ties.len()), (binding.guides.positions.len(), moved.curves.n_guides()));
        for (idx, expected) in binding.guides.positions.iter().enumerate() {
            let (guide, k) = (idx / spline.n_vertices as usize, idx % spline.n_vertices as usize);
            let row = spline.rows[spline.first_rows[guide] as usize + k];
            let curve = moved.curves.guide(guide);
            let place: Vec3 = row.vertices.iter().zip(row.weights).map(|(&v, w)| w * curve[v as usize]).sum();
            assert!(place.distance(*expected) < 1e-5, "guide {guide}, vertex {k}: {place} {expected}");
            assert!((row.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
        }
        // And back: joints are vertices of their guide, others lie on the spline through it.
        let curves = moved.curves_of(&binding.guides.positions);
        let farthest = curves.iter().zip(&moved.curves.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(farthest < 0.01 && curves.len() == moved.curves.positions.len(), "{farthest} cm");
    }

    #[test]
    fn every_strand_is_moved_from_where_it_is_drawn_and_tied_as_the_layer_says() {
        let layer = Layer {
            n_strands: 50,
            vertices_per_strand: 100,
            tied: 0.3,
            ..Layer::new("a", Source::HairMesh(Arc::new(bent_mesh())))
        };
        let binding = bind_layer(&layer, None);
        let moved = MovedHair::new(Moved::Strands, &layer, &binding, None);
        assert_eq!((moved.curves.n_vertices, moved.curves.n_guides(), moved.n_shown()), (64, 50, 64 * 50));
        assert!(moved.ties.iter().all(|&tie| tie == 0.3));
        let drawn = generate(
            &binding,
            &Layer { vertices_per_strand: 64, ..layer.clone() },
            &binding.guides.positions,
            &Pose::default(),
        );
        assert_eq!(drawn.points, moved.curves.positions);
        assert_eq!(n_moved(Moved::Strands, &layer, &binding), drawn.points.len());
    }

    #[test]
    fn where_there_is_no_hair_mesh_guides_are_moved() {
        let mut strands = crate::strands::Strands::default();
        strands.push(&[Vec3::ZERO, Vec3::Y, 2.0 * Vec3::Y, 3.0 * Vec3::Y]);
        let layer = Layer::new("a", Source::Guides(Arc::new(strands)));
        let binding = bind_layer(&layer, None);
        let moved = MovedHair::new(Moved::Mesh, &layer, &binding, None);
        assert_eq!((&moved.curves, moved.follow), (&binding.guides, Follow::Guides));
        let roots = Layer::new("b", Source::HairMesh(Arc::new(straight_grid(2, 0))));
        let moved = MovedHair::new(Moved::Mesh, &roots, &bind_layer(&roots, None), None);
        assert_eq!(moved.follow, Follow::Guides);
    }
}
