//! Strands among guides: the three nearest on the same side of a parting, and tufts of planted ones.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::scatter::{Density, Place, Places, Scalp, scatter};
use super::{LayerBinding, MOST_STRANDS, PARTED};
use crate::groom::{Head, Layer};
use crate::guides::{GuideSet, Influence};
use crate::hash::{combine, random};
use crate::mesh::TriMesh;
use crate::point_grid::PointGrid;
use crate::roots::{Root, RootSurface};
use crate::sculpt::planted::PLANTED;
use crate::sculpt::planting::Planting;
use crate::strands::Strands;

pub(super) fn bind_guides(
    layer: &Layer,
    strands: &Strands,
    scalp: Option<&Scalp<'_>>,
    known: Option<Arc<Places>>,
) -> LayerBinding {
    let guides = GuideSet::of_strands(strands);
    if guides.n_guides() == 0 {
        return LayerBinding::with_capacity(guides, 0);
    }
    let all_roots: Vec<Vec3> = (0..guides.n_guides()).map(|guide_idx| guides.guide(guide_idx)[0]).collect();
    // Planted guides come last, and change nothing about the strands of the others.
    let n_own = (0..guides.n_guides()).take_while(|&guide_idx| strands.id(guide_idx) < PLANTED).count();
    let n_own = if n_own == 0 { all_roots.len() } else { n_own };
    let roots = all_roots[..n_own].to_vec();
    let (grid, spacing) = spaced_grid(&roots);
    let reach = 1.5 * spacing;
    let near_guide = |p: Vec3| grid.nearest::<1>(p).0[0].1 <= reach * reach;
    // The part of the scalp that guides stand on.
    let on_scalp = scalp.and_then(|scalp| {
        let near: Vec<u32> = scalp
            .triangles
            .par_iter()
            .copied()
            .filter(|&triangle_idx| {
                let [a, b, c] = scalp.mesh.corners(triangle_idx as usize);
                let middle = (a + b + c) / 3.0;
                let radius = middle.distance(a).max(middle.distance(b)).max(middle.distance(c));
                grid.nearest::<1>(middle).0[0].1 <= (reach + radius).powi(2)
            })
            .collect();
        let surface = RootSurface::of_triangles(scalp.mesh, near);
        (surface.area() > 0.0).then_some((scalp, surface))
    });
    let (surface, scalp) = match on_scalp {
        Some((scalp, surface)) => (surface, Some(scalp)),
        None => (discs(&roots, 0.6 * spacing), None),
    };
    let middle = roots.iter().sum::<Vec3>() / roots.len() as f32;
    let place = |root: &Root| -> Option<Place> {
        let Some(scalp) = scalp else {
            let normal = (root.position - middle).normalize_or(Vec3::Y);
            return Some(Place { position: root.position, normal, uv: [0.0; 2] });
        };
        near_guide(root.position).then(|| scalp.at(root.face, root.barycentric, root.position))
    };
    let planting = Planting::of(layer);
    let density = Density::new(layer.density().map(|map| &**map).filter(|_| scalp.is_some()), planting.as_ref());
    let n_strands = layer.n_strands.min(MOST_STRANDS) as usize;
    let (scattered, places) = scatter(&surface, (n_strands, layer.count), layer.seed, &density, known, place);
    let influences: Vec<[Influence; 3]> =
        scattered.par_iter().map(|(_, root, _)| three_guides(&guides, &roots, &grid, root.position)).collect();
    let mut strands: Vec<(f64, u32, Place, [Influence; 3])> = scattered
        .into_iter()
        .zip(influences)
        .enumerate()
        .map(|(order, ((id, _, place), influences))| (order as f64, id, place, influences))
        .collect();
    if n_own < all_roots.len() {
        let a_guide = strands.len() as f32 / n_own as f32;
        let tufts = Tufts { guides: &guides, roots: &all_roots, n_own, spacing, n_strands: a_guide, scalp };
        let n_before = strands.len() as f64;
        // Between the others in the order of detail: a share of the layer has a share of every tuft.
        strands.extend(
            tufts.strands(layer.seed).map(|(at, id, place, influences)| (at * n_before, id, place, influences)),
        );
        strands.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
    let mut binding = LayerBinding::with_capacity(guides, strands.len());
    for (_, id, place, influences) in &strands {
        binding.push_influences(*influences);
        binding.push_id(*id, layer);
        binding.push_place(place, scalp);
    }
    binding.places = Some(places);
    binding.offset_at_tip = 1.0;
    binding.measure_offsets();
    binding
}

/// The strands of planted guides: each guide has as many around it as the layer's own have.
pub(super) struct Tufts<'a> {
    pub(super) guides: &'a GuideSet,
    /// Of all guides; those from `n_own` on are planted.
    pub(super) roots: &'a [Vec3],
    pub(super) n_own: usize,
    /// Of the layer's own guides, centimetres.
    pub(super) spacing: f32,
    /// Strands for each guide.
    pub(super) n_strands: f32,
    pub(super) scalp: Option<&'a Scalp<'a>>,
}

impl Tufts<'_> {
    /// Places in the order of detail (0-1), ids, places and weights.
    pub(super) fn strands(&self, seed: u32) -> impl Iterator<Item = (f64, u32, Place, [Influence; 3])> {
        let (grid, n_each) = (PointGrid::new(self.roots, self.spacing), self.n_strands.ceil().max(1.0) as u32);
        let middle = self.roots.iter().sum::<Vec3>() / self.roots.len() as f32;
        let tuft = |guide_idx: usize| {
            let root = self.roots[guide_idx];
            let project = |p: Vec3| match self.scalp {
                Some(scalp) => scalp.project(p),
                None => Some(Place { position: p, normal: (p - middle).normalize_or(Vec3::Y), uv: [0.0; 2] }),
            };
            let normal = project(root).map_or(Vec3::Y, |place| place.normal);
            let (x, y) = normal.any_orthonormal_pair();
            let of_tuft = combine(
                combine(seed, PLANTED),
                root.x.to_bits() ^ root.y.to_bits().rotate_left(11) ^ root.z.to_bits().rotate_left(22),
            );
            let strand = |i: u32| {
                // Vogel 1979: even over a disc, every beginning of it too.
                let radius = self.spacing * TUFT * ((i as f32 + 0.5) / n_each as f32).sqrt();
                let (sin, cos) = (i as f32 * 2.399_963 + 6.3 * random(of_tuft, 0)).sin_cos();
                let place = project(root + radius * (cos * x + sin * y))?;
                let at = (f64::from(i) + f64::from(random(of_tuft, 1 + i))) / f64::from(n_each);
                Some((
                    at,
                    combine(of_tuft, i) | PLANTED,
                    place,
                    three_guides(self.guides, self.roots, &grid, place.position),
                ))
            };
            (0..n_each).filter_map(strand).collect::<Vec<_>>()
        };
        (self.n_own..self.roots.len()).flat_map(tuft).collect::<Vec<_>>().into_iter()
    }
}

/// Radius of the disc that a guide has for itself, in spacings of guides: pi r^2 is the area of one in a grid.
const TUFT: f32 = 0.62;

/// Places spread over the scalp of a head, as (position, way out of it): the beginning, `n_places(area)` long, of a
/// sequence that is the same for every length. Area in square centimetres.
pub(crate) fn scalp_places(head: &Head, n_places: impl Fn(f32) -> usize, seed: u32) -> Vec<(Vec3, Vec3)> {
    let Some(scalp) = Scalp::new(&head.mesh) else { return Vec::new() };
    let surface = RootSurface::of_triangles(scalp.mesh, scalp.triangles.iter().copied());
    let roots = surface.sequence(n_places(surface.area() as f32), seed);
    let place = |root: &Root| scalp.at(root.face, root.barycentric, root.position);
    roots.par_iter().map(place).map(|place| (place.position, place.normal)).collect()
}

/// A grid over points and their mean spacing in centimetres.
pub(crate) fn spaced_grid(points: &[Vec3]) -> (PointGrid<'_>, f32) {
    let first = points.first().copied().unwrap_or_default();
    let (lo, hi) = points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p)));
    let size = (hi - lo).max_element();
    let coarse = PointGrid::new(points, size / (points.len() as f32).sqrt());
    let distances = points.iter().map(|&p| coarse.nearest::<2>(p).0[1].1.sqrt()).filter(|d| d.is_finite());
    let (sum, n) = distances.fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
    let spacing = if n > 0 && sum > 0.0 { sum / n as f32 } else { 1.0 };
    (PointGrid::new(points, spacing), spacing)
}

/// Hexagons around points, across the way out of their middle: a root surface where there is no scalp.
fn discs(points: &[Vec3], radius: f32) -> RootSurface {
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let mut mesh = TriMesh::default();
    for &p in points {
        let (x, y) = (p - middle).normalize_or(Vec3::Y).any_orthonormal_pair();
        let first = mesh.positions.len() as u32;
        mesh.positions.push(p);
        for k in 0..6_u32 {
            let (sin, cos) = (k as f32 / 6.0 * std::f32::consts::TAU).sin_cos();
            mesh.positions.push(p + radius * (cos * x + sin * y));
            mesh.triangles.push([first, first + 1 + k, first + 1 + (k + 1) % 6]);
        }
    }
    RootSurface::of_triangles(&mesh, 0..mesh.triangles.len() as u32)
}

/// The three nearest guides with barycentric weights on their plane; guides across a parting get none.
pub(super) fn three_guides(guides: &GuideSet, roots: &[Vec3], grid: &PointGrid<'_>, p: Vec3) -> [Influence; 3] {
    let (nearest, n_found) = grid.nearest::<3>(p);
    let guide_idx = |i: usize| if i < n_found { nearest[i].0 } else { nearest[0].0 };
    let [a, b, c] = [guide_idx(0), guide_idx(1), guide_idx(2)];
    let (u, v, w) = (roots[b] - roots[a], roots[c] - roots[a], p - roots[a]);
    // Compute barycentric coordinates of p's projection (Ericson 2005, section 3.4).
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let determinant = uu * vv - uv * uv;
    let mut weights = if determinant > 1e-3 * uu * vv {
        let (beta, gamma) = ((vv * wu - uv * wv) / determinant, (uu * wv - uv * wu) / determinant);
        [1.0 - beta - gamma, beta, gamma]
    } else {
        // Guides in a row: by distance.
        std::array::from_fn(|i| if i < n_found { 1.0 / (nearest[i].1 + 1e-6) } else { 0.0 })
    };
    let path = |guide_idx: usize| {
        let guide = guides.guide(guide_idx);
        (guide[guide.len() / 2] - guide[0]).normalize_or(Vec3::Y)
    };
    for (i, weight) in weights.iter_mut().enumerate() {
        let same_side = i == 0 || path(guide_idx(i)).dot(path(a)) > PARTED;
        *weight = if same_side { weight.max(0.0) } else { 0.0 };
    }
    weights[0] = if weights.iter().sum::<f32>() > 0.0 { weights[0] } else { 1.0 };
    let sum: f32 = weights.iter().sum();
    std::array::from_fn(|i| Influence { guide_idx: guide_idx(i) as u32, weight: weights[i] / sum })
}
