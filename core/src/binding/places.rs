//! The hair at given places of the scalp, wherever the layer's own strands grow: what sculpt guides are made of.

use glam::Vec3;
use rayon::prelude::*;

use super::{LayerBinding, PARTED, Place, Scalp, root_layer_normals, spaced_grid, three_guides};
use crate::groom::{Head, Layer, Source};
use crate::guides::{GuideSet, Influence};
use crate::hair_mesh::HairMesh;
use crate::mean_value::weights_within;
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;
use crate::point_grid::PointGrid;
use crate::strands::Strands;

/// A place this far from every root face of a hair mesh has no hair, in centimetres. Faces are chords: the
/// scalp bulges half a centimetre over one of six.
const OFF_THE_MESH: f32 = 1.0;

/// One strand for each of `positions` (on the scalp, head space), in their order, and whether hair grows there.
/// Seeds and ids are the indices.
pub fn bind_places(layer: &Layer, head: Option<&Head>, positions: &[Vec3]) -> (LayerBinding, Vec<bool>) {
    let scalp = head.and_then(|head| Scalp::new(&head.mesh));
    let scalp = scalp.as_ref();
    let middle = positions.iter().sum::<Vec3>() / positions.len().max(1) as f32;
    let place_of = |p: Vec3| -> Place {
        let outwards = (p - middle).normalize_or(Vec3::Y);
        let bare = Place { position: p, normal: outwards, uv: [0.0; 2] };
        scalp.and_then(|scalp| scalp.project(p)).map_or(bare, |place| Place { position: p, ..place })
    };
    let mut places: Vec<Place> = positions.par_iter().map(|&p| place_of(p)).collect();
    let mut bundles = Vec::new();
    let mut knots = None;
    let (guides, shares) = match &layer.source {
        Source::HairMesh(mesh) => {
            let found = in_hair_mesh(mesh, scalp.is_none(), &mut places);
            bundles = found.bundles;
            knots = Some(found.knots);
            (found.guides, found.shares)
        }
        Source::Guides(guides) => among_guides(guides, positions),
        Source::Strands(strands) => at_strands(strands, positions),
    };
    let mut binding = LayerBinding::with_capacity(guides, positions.len());
    binding.knots = knots.unwrap_or(binding.knots);
    let mut is_there = Vec::with_capacity(positions.len());
    for (i, (place, share)) in places.iter().zip(shares).enumerate() {
        is_there.push(share.is_some() && binding.guides.n_guides() > 0);
        binding.push_influences(share.unwrap_or_default());
        binding.push_id(i as u32, layer);
        binding.push_place(place, scalp);
    }
    if let Source::HairMesh(mesh) = &layer.source {
        let n_gaps = |bundle: u32| mesh.tip_layer(bundle as usize).unwrap_or(0) as u32;
        let first_knots = bundles.iter().map(|&bundle| n_gaps(bundle) * binding.guides.n_vertices);
        binding.first_knots = first_knots.collect();
    }
    binding.offset_at_tip = if matches!(layer.source, Source::HairMesh(_)) { 0.0 } else { 1.0 };
    binding.measure_offsets();
    (binding, is_there)
}

type Shares = Vec<Option<Vec<Influence>>>;

/// Places in a hair mesh: the chains with the parameters of their vertices, and each place's share in them and
/// bundle (0 where no hair grows).
struct InHairMesh {
    guides: GuideSet,
    knots: Vec<f32>,
    shares: Shares,
    bundles: Vec<u32>,
}

fn in_hair_mesh(mesh: &HairMesh, needs_normals: bool, places: &mut [Place]) -> InHairMesh {
    let none = |n: usize| {
        let guides = GuideSet { n_vertices: 2, positions: Vec::new() };
        InHairMesh { knots: guides.even_knots(), guides, shares: vec![None; n], bundles: vec![0; n] }
    };
    if mesh.layers.is_empty() || mesh.check().is_err() {
        return none(places.len());
    }
    // The root faces as fans, as the root surface has them.
    let (mut fans, mut bundle_of) = (TriMesh::default(), Vec::new());
    for bundle in 0..mesh.n_bundles() {
        let Some(face) = mesh.face(0, bundle).filter(|_| mesh.face(1, bundle).is_some()) else { continue };
        let first = fans.positions.len() as u32;
        let corners = face.iter().map(|&v| mesh.layers[0].positions[v as usize]);
        fans.positions.push(corners.clone().sum::<Vec3>() / face.len() as f32);
        fans.positions.extend(corners);
        let n = face.len() as u32;
        fans.triangles.extend((0..n).map(|i| [first, first + 1 + i, first + 1 + (i + 1) % n]));
        bundle_of.extend(std::iter::repeat_n(bundle, face.len()));
    }
    let Ok(query) = MeshQuery::new(&fans) else { return none(places.len()) };
    let chains = mesh.chains();
    let normals = root_layer_normals(mesh);
    let (shares, bundles) = places
        .par_iter_mut()
        .map(|place| {
            let hit = query.closest_within(place.position, OFF_THE_MESH)?;
            let bundle = bundle_of[hit.triangle_idx as usize];
            let face = mesh.face(0, bundle)?;
            let corners: Vec<Vec3> = face.iter().map(|&v| mesh.layers[0].positions[v as usize]).collect();
            let weights = weights_within(&corners, hit.position);
            if needs_normals {
                let normal: Vec3 = face.iter().zip(&weights).map(|(&v, w)| *w * normals[v as usize]).sum();
                place.normal = normal.normalize_or(place.normal);
            }
            let of_corner = chains.of_bundle[bundle].iter().zip(weights);
            let share: Vec<Influence> = of_corner.map(|(&guide_idx, weight)| Influence { guide_idx, weight }).collect();
            Some((share, bundle as u32))
        })
        .map(Option::unzip)
        .map(|(share, bundle)| (share, bundle.unwrap_or(0)))
        .unzip();
    let (guides, knots) = GuideSet::of_chains(mesh, &chains);
    InHairMesh { guides, knots, shares, bundles }
}

fn among_guides(strands: &Strands, positions: &[Vec3]) -> (GuideSet, Shares) {
    let guides = GuideSet::of_strands(strands);
    if guides.n_guides() == 0 {
        return (guides, vec![None; positions.len()]);
    }
    let roots: Vec<Vec3> = (0..guides.n_guides()).map(|guide_idx| guides.guide(guide_idx)[0]).collect();
    let (grid, spacing) = spaced_grid(&roots);
    let reach = 1.5 * spacing;
    let shares = positions
        .par_iter()
        .map(|&p| {
            let is_near = grid.nearest::<1>(p).0[0].1 <= reach * reach;
            is_near.then(|| three_guides(&guides, &roots, &grid, p).to_vec())
        })
        .collect();
    (guides, shares)
}

fn at_strands(strands: &Strands, positions: &[Vec3]) -> (GuideSet, Shares) {
    let guides = GuideSet::of_strands(strands);
    let usable: Vec<u32> = (0..strands.n_strands() as u32).filter(|&s| strands.strand(s as usize).len() >= 2).collect();
    if usable.is_empty() {
        return (guides, vec![None; positions.len()]);
    }
    let roots: Vec<Vec3> = usable.iter().map(|&s| strands.strand(s as usize)[0]).collect();
    let (grid, _) = spaced_grid(&roots);
    let shares = positions
        .par_iter()
        .map(|&p| {
            let (nearest, squared) = grid.nearest::<1>(p).0[0];
            let influence = Influence { guide_idx: usable.get(nearest).copied()?, weight: 1.0 };
            (squared <= OFF_THE_MESH * OFF_THE_MESH).then(|| vec![influence])
        })
        .collect();
    (guides, shares)
}

/// For each place the guides among `roots` whose hair it shares, up to eight as (index, distance), nearest
/// first: those across a parting are left out. `towards` are the unit directions of places' and roots' hair.
pub fn same_side(grid: &PointGrid<'_>, roots_towards: &[Vec3], p: Vec3, towards: Vec3) -> Vec<(usize, f32)> {
    let (nearest, n_found) = grid.nearest::<8>(p);
    let nearest = &nearest[..n_found];
    let mut same: Vec<(usize, f32)> = nearest
        .iter()
        .filter(|(root, _)| roots_towards[*root].dot(towards) > PARTED)
        .map(|&(root, squared)| (root, squared.sqrt()))
        .collect();
    if same.is_empty() {
        same.extend(nearest.first().map(|&(root, squared)| (root, squared.sqrt())));
    }
    same
}
