//! What of a layer's hair a solver moves, and how the rest of the layer follows it.
//!
//! - **Guides**: every guide by itself; strands are blended between them.
//! - **Hair mesh** (Yuksel, Schaefer, Keyser 2009, section 4): the edges that lead a vertex of the mesh from layer to layer
//!   are the links of an articulated chain. Guides are splines through its joints, as they are when the mesh is modelled,
//!   so that hair at rest is the same hair.
//! - **Rope**: a braid, a ponytail, a lock is one curve, the middle of a hair mesh's piece that is one on the scalp; guides go
//!   with it as if they were drawn on it.
//! - **Every strand**: the strands themselves, as style and brushes have made them.

mod joints;
mod rope;

use glam::{Quat, Vec3};

use crate::binding::{LayerBinding, MeanTie, Tie};
use crate::curve::{catmull_rom, catmull_rom_slopes, catmull_rom_weights};
use crate::distance_field::DistanceField;
use crate::generate::{Pose, generate};
use crate::groom::{Layer, Source};
use crate::guides::GuideSet;
use crate::hair_mesh::HairMesh;
use crate::simulation::Moved;

/// Density of hair, g/cm3 (Robbins 2012, "Chemical and Physical Behavior of Human Hair").
const HAIR_DENSITY: f32 = 1.32;
/// A centimetre of a whole head of hair: 100,000 of 80 micrometres, g/cm.
const HEAD_G_PER_CM: f32 = 6.6;

/// Curves that a solver moves.
///
/// Without ties nothing is tied.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MovedHair {
    /// At rest, head space.
    pub curves: GuideSet,
    /// How each curve is held to the style.
    pub ties: Vec<Tie>,
    /// Mass of a centimetre of all the hair that the curves stand for together, g/cm.
    pub g_per_cm: f32,
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

/// Guides that lie on curves, or beside them. Vertex `k` of guide `g` follows by `rows[first_rows[g] + k]` the curve
/// `curve_of[g]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spline {
    /// Vertices of a guide.
    pub n_vertices: u32,
    pub curve_of: Vec<u32>,
    pub first_rows: Vec<u32>,
    pub rows: Vec<SplineRow>,
    /// Per guide vertex: from its place on the curve, at rest in head space; it turns with the curve. Empty: none.
    pub offsets: Vec<Vec3>,
    /// Where each vertex of a curve is along its guides, in their vertices, or [`BEYOND`]; a run of them for every first row.
    samples: Vec<f32>,
}

/// A place on a curve: vertices, counted from its root, and their weights; and the weights of the curve's direction there.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SplineRow {
    pub vertices: [u32; 4],
    pub weights: [f32; 4],
    pub slopes: [f32; 4],
}

/// The curve has a vertex where a guide has ended.
const BEYOND: f32 = -1.0;
/// Most vertices of a moved strand: as many as a workgroup of the solver has threads.
const MOST_VERTICES: u32 = 64;
impl MovedHair {
    /// What is moved of a layer that is bound; `field` is the head's, in head space. A layer that is no hair mesh has
    /// nothing but guides to move instead.
    pub fn new(moved: Moved, layer: &Layer, binding: &LayerBinding, field: Option<&DistanceField>) -> Self {
        let hair = match (moved, &layer.source) {
            (Moved::Strands, _) => Self::of_strands(layer, binding, field),
            (Moved::Mesh, Source::HairMesh(mesh)) => Self::of_hair_mesh(mesh, binding, false),
            (Moved::Rope, Source::HairMesh(mesh)) => Self::of_hair_mesh(mesh, binding, true),
            (Moved::Mesh | Moved::Rope | Moved::Guides, _) => Self::of_binding(binding),
        };
        Self { g_per_cm: g_per_cm(layer, binding), ..hair }
    }

    /// Guides by themselves, untied: together a head of hair.
    pub fn of_guides(guides: &[&GuideSet]) -> Vec<Self> {
        let n_guides: usize = guides.iter().map(|guides| guides.n_guides()).sum();
        let of = |guides: &&GuideSet| Self {
            curves: GuideSet::clone(guides),
            g_per_cm: HEAD_G_PER_CM * guides.n_guides() as f32 / n_guides.max(1) as f32,
            ..Self::default()
        };
        guides.iter().map(of).collect()
    }

    fn of_binding(binding: &LayerBinding) -> Self {
        Self { curves: binding.guides.clone(), ties: binding.guide_ties(), ..Self::default() }
    }

    fn of_hair_mesh(mesh: &HairMesh, binding: &LayerBinding, is_rope: bool) -> Self {
        let chains = mesh.chains();
        // A mesh of roots alone has no edge to move; and guides that were bound before the mesh changed are of another.
        let is_bound = chains.chains.len() == binding.guides.n_guides();
        if mesh.layers.len() < 2 || !is_bound {
            return Self::of_binding(binding);
        }
        let (curves, spline) = if is_rope {
            rope::ropes_of(mesh, &chains, &binding.guides)
        } else {
            joints::joints_of(mesh, &chains, binding.guides.n_vertices)
        };
        let hair = Self { curves, follow: Follow::Spline(spline), ..Self::default() };
        Self { ties: hair.ties_of(binding), ..hair }
    }

    fn of_strands(layer: &Layer, binding: &LayerBinding, field: Option<&DistanceField>) -> Self {
        let n_vertices = moved_vertices(layer);
        let layer = Layer { vertices_per_strand: n_vertices, ..layer.clone() };
        let strands = generate(binding, &layer, &binding.guides.positions, &Pose { field, ..Pose::default() });
        let curves = GuideSet { n_vertices, positions: strands.points };
        Self { curves, ties: binding.strand_ties(), follow: Follow::Strands, ..Self::default() }
    }

    /// How curves are held to the style, where the layer's ties may be others than when they were made. What is one curve
    /// is held as its guides are in the mean.
    pub fn ties_of(&self, binding: &LayerBinding) -> Vec<Tie> {
        match &self.follow {
            Follow::Guides => binding.guide_ties(),
            Follow::Strands => binding.strand_ties(),
            Follow::Spline(spline) => {
                let mut means = vec![MeanTie::default(); self.curves.n_guides()];
                for (tie, &curve_idx) in binding.guide_ties().into_iter().zip(&spline.curve_of) {
                    means[curve_idx as usize].add(tie, 1.0);
                }
                means.into_iter().map(MeanTie::tie).collect()
            }
        }
    }

    /// The curves of guides, or of strands, that are at `shown`: the inverse of following, as far as there is one.
    pub fn curves_of(&self, shown: &[Vec3]) -> Vec<Vec3> {
        let Follow::Spline(spline) = &self.follow else { return shown.to_vec() };
        let (n_guide, n_curve) = (spline.n_vertices as usize, self.curves.n_vertices as usize);
        let mut sums = vec![(Vec3::ZERO, 0.0_f32); self.curves.positions.len()];
        for (guide_idx, guide) in shown.chunks_exact(n_guide).enumerate().take(spline.curve_of.len()) {
            let first = spline.curve_of[guide_idx] as usize * n_curve;
            let run = spline.first_rows[guide_idx] as usize / n_guide * n_curve;
            let samples = sums[first..].iter_mut().zip(&spline.samples[run..run + n_curve]);
            for (sum, &at) in samples.filter(|(_, at)| **at != BEYOND) {
                *sum = (sum.0 + catmull_rom(guide, at), sum.1 + 1.0);
            }
        }
        // What lies around a curve has it in its middle.
        sums.into_iter().map(|(sum, n)| sum / n.max(1.0)).collect()
    }

    /// Vertices of what is drawn from: guides, or strands.
    pub fn n_shown(&self) -> usize {
        match &self.follow {
            Follow::Guides | Follow::Strands => self.curves.positions.len(),
            Follow::Spline(spline) => spline.first_rows.len() * spline.n_vertices as usize,
        }
    }
}

/// Mass of a centimetre of all of a layer's strands side by side, as thick as they are drawn, g/cm: fewer and thicker
/// ones are as much hair.
pub fn g_per_cm(layer: &Layer, binding: &LayerBinding) -> f32 {
    let (radius_cm, tip) = (layer.radius_um * 1e-4, layer.tip_radius);
    let cross_section = std::f32::consts::PI * radius_cm * radius_cm * (1.0 + tip + tip * tip) / 3.0;
    HAIR_DENSITY * cross_section * binding.n_strands() as f32
}

/// Vertices of the guides, or of the strands, that [`MovedHair::new`] moves of a layer.
pub fn n_moved(moved: Moved, layer: &Layer, binding: &LayerBinding) -> usize {
    match moved {
        Moved::Strands => binding.n_strands() * moved_vertices(layer) as usize,
        Moved::Guides | Moved::Mesh | Moved::Rope => binding.guides.positions.len(),
    }
}

/// Vertices of a strand that is moved by itself.
pub fn moved_vertices(layer: &Layer) -> u32 {
    layer.vertices_per_strand.clamp(4, MOST_VERTICES)
}

impl Spline {
    /// Where a guide's vertex is, of a head that is turned by `rotation`; `curve` are the vertices of its curve now,
    /// `tangent` the curve's direction there at rest. Twin in sim_follow.wgsl.
    pub fn place(row: &SplineRow, curve: impl Fn(u32) -> Vec3, offset: Option<(Vec3, Vec3)>, rotation: Quat) -> Vec3 {
        let sum = |weights: [f32; 4]| -> Vec3 { row.vertices.iter().zip(weights).map(|(&v, w)| w * curve(v)).sum() };
        let on_curve = sum(row.weights);
        let Some((offset, tangent)) = offset else { return on_curve };
        on_curve + turned(rotation * offset, rotation * tangent, sum(row.slopes))
    }
}

/// A vector turned by the shortest way that takes direction `from` to direction `to`; as it is where one has none, or they
/// are opposite.
fn turned(v: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let (Some(from), Some(to)) = (from.try_normalize(), to.try_normalize()) else { return v };
    let cos = from.dot(to);
    if cos < -0.999 {
        return v;
    }
    let axis = from.cross(to);
    v + axis.cross(v) + axis.cross(axis.cross(v)) / (1.0 + cos)
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
        return SplineRow { vertices: [joints[0]; 4], weights: [1.0, 0.0, 0.0, 0.0], slopes: [0.0; 4] };
    }
    let u = u.clamp(0.0, last as f32);
    let segment = (u as usize).min(last - 1);
    let within = |[mut before, mut here, mut next, mut after]: [f32; 4]| {
        if segment == 0 {
            (here, next, before) = (here + 2.0 * before, next - before, 0.0);
        }
        if segment + 2 > last {
            (here, next, after) = (here - after, next + 2.0 * after, 0.0);
        }
        [before, here, next, after]
    };
    let x = u - segment as f32;
    let (weights, slopes) = (within(catmull_rom_weights(x)), within(catmull_rom_slopes(x)));
    let vertices =
        [joints[segment.saturating_sub(1)], joints[segment], joints[segment + 1], joints[(segment + 2).min(last)]];
    SplineRow { vertices, weights, slopes }
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
            let curve = moved.curves.guide(spline.curve_of[guide] as usize);
            let place = Spline::place(&row, |v| curve[v as usize], None, Quat::IDENTITY);
            assert!(place.distance(*expected) < 1e-5, "guide {guide}, vertex {k}: {place} {expected}");
            assert!((row.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6);
            assert!(row.slopes.iter().sum::<f32>().abs() < 1e-5);
        }
        // And back: joints are vertices of their guide, others lie on the spline through it.
        let curves = moved.curves_of(&binding.guides.positions);
        let farthest = curves.iter().zip(&moved.curves.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(farthest < 0.01 && curves.len() == moved.curves.positions.len(), "{farthest} cm");
    }

    #[test]
    fn guides_go_with_a_rope_as_if_they_were_drawn_on_it() {
        let layer = Layer { n_strands: 20, ..Layer::new("a", Source::HairMesh(Arc::new(bent_mesh()))) };
        let binding = bind_layer(&layer, None);
        let moved = MovedHair::new(Moved::Rope, &layer, &binding, None);
        let Follow::Spline(spline) = &moved.follow else { panic!() };
        assert_eq!((moved.curves.n_guides(), moved.ties.len()), (1, 1), "two bundles side by side are one rope");
        assert_eq!(moved.n_shown(), binding.guides.positions.len());
        let place_all = |curve: &[Vec3], rotation: Quat| -> Vec<Vec3> {
            let n = spline.n_vertices as usize;
            let place = |idx: usize| {
                let row = &spline.rows[spline.first_rows[idx / n] as usize + idx % n];
                let tangent: Vec3 =
                    row.vertices.iter().zip(row.slopes).map(|(&v, w)| w * moved.curves.positions[v as usize]).sum();
                let offset = Some((spline.offsets[idx], tangent));
                Spline::place(row, |v| curve[v as usize], offset, rotation)
            };
            (0..moved.n_shown()).map(place).collect()
        };
        let farthest = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let at_rest = &binding.guides.positions;
        assert!(farthest(&place_all(&moved.curves.positions, Quat::IDENTITY), at_rest) < 1e-5);
        // Turned as a whole, everything turns; by the head, or by the shortest way alone.
        let turn = Quat::from_rotation_z(0.7);
        let turned = |points: &[Vec3]| -> Vec<Vec3> { points.iter().map(|p| turn * *p).collect() };
        assert!(farthest(&place_all(&turned(&moved.curves.positions), turn), &turned(at_rest)) < 1e-4);
        let loose = place_all(&turned(&moved.curves.positions), Quat::IDENTITY);
        let wide = |points: &[Vec3]| points[0].distance(points[points.len() / 2]);
        assert!((wide(&loose) - wide(at_rest)).abs() < 0.05 && loose.iter().all(|p| p.is_finite()));
        let curves = moved.curves_of(at_rest);
        assert!(farthest(&curves, &moved.curves.positions) < 0.6, "{}", farthest(&curves, &moved.curves.positions));
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
        assert!(moved.ties.iter().all(|&tie| tie == Tie::up_to(0.3)));
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
