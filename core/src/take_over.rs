//! What a groom becomes when hair stays where it has moved to: as the rest of the layer that it belongs to, or as a layer of
//! guides of its own.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;

use crate::curve::catmull_rom;
use crate::edit::Edit;
use crate::groom::{Groom, Layer, Source};
use crate::guides::GuideSet;
use crate::hair_mesh::{HairMesh, VertexId};
use crate::maps::MapKind;
use crate::sculpt::Sculpt;
use crate::strands::Strands;

impl Groom {
    /// The edit after which layer `layer_idx` rests where its guides (`moved`, head space, of the layer's own guide set) are.
    /// Roots stay. `None` where there is no such layer, or the guides are not the layer's.
    pub fn rest_at(&self, layer_idx: usize, moved: &GuideSet) -> Option<Edit> {
        let layer = self.layers.get(layer_idx)?;
        if !moved.positions.iter().all(|p| p.is_finite()) {
            return None;
        }
        match &layer.source {
            Source::Guides(strands) => {
                let source = Source::Guides(Arc::new(strands_at(strands, moved)?));
                Some(Edit::SetSource { layer_idx, source })
            }
            Source::Strands(strands) => {
                let source = Source::Strands(Arc::new(strands_at(strands, moved)?));
                Some(Edit::SetSource { layer_idx, source })
            }
            Source::HairMesh(mesh) => Some(Edit::MoveVertices { layer_idx, moves: vertices_at(mesh, moved)? }),
        }
    }

    /// The edit that adds a layer of guides as they are now, above all others, which looks like layer `layer_idx`. At a parting
    /// of a hair mesh guides begin a little on their own side. `None` where there is no such layer, or no guide.
    pub fn baked(&self, layer_idx: usize, moved: &GuideSet) -> Option<Edit> {
        let layer = self.layers.get(layer_idx)?;
        if moved.n_guides() == 0 || !moved.positions.iter().all(|p| p.is_finite()) {
            return None;
        }
        let asides = match &layer.source {
            Source::HairMesh(mesh) => asides_at_partings(mesh),
            Source::Guides(_) | Source::Strands(_) => Vec::new(),
        };
        let mut strands = Strands::default();
        for guide_idx in 0..moved.n_guides() {
            let aside = asides.get(guide_idx).copied().unwrap_or_default();
            let n = moved.n_vertices.max(2) as f32 - 1.0;
            let beside = |(k, p): (usize, &Vec3)| *p + aside * (1.0 - k as f32 / n);
            strands.push(&moved.guide(guide_idx).iter().enumerate().map(beside).collect::<Vec<_>>());
        }
        let source = Source::Guides(Arc::new(strands));
        let baked = Layer {
            name: format!("{}, baked", layer.name),
            source,
            // Strokes lie on guides of the scalp that the new layer may choose otherwise.
            sculpt: Sculpt::default(),
            ..layer.clone()
        };
        Some(Edit::AddLayer { layer_idx: self.layers.len(), layer: Box::new(baked) })
    }
}

impl Groom {
    /// As [`Groom::baked`], of strands that were moved themselves: a layer of strands as they are, with nothing left of the
    /// style that made them.
    pub fn baked_strands(&self, layer_idx: usize, moved: &GuideSet) -> Option<Edit> {
        let Edit::AddLayer { layer_idx: at, mut layer } = self.baked(layer_idx, moved)? else { return None };
        let Source::Guides(strands) = &layer.source else { return None };
        layer.n_strands = strands.n_strands() as u32;
        layer.source = Source::Strands(Arc::clone(strands));
        layer.style.clear();
        // They are cut and placed already.
        layer.maps.remove(&MapKind::Length);
        layer.maps.remove(&MapKind::Density);
        Some(Edit::AddLayer { layer_idx: at, layer })
    }
}

/// Strands with as many points as before, along guides that were made of them.
fn strands_at(strands: &Strands, moved: &GuideSet) -> Option<Strands> {
    if moved.n_guides() != strands.n_strands() {
        return None;
    }
    let mut result = strands.clone();
    let mut at = 0;
    for (guide_idx, points) in strands.iter().enumerate() {
        let guide = moved.guide(guide_idx);
        let is_whole = points.len() == guide.len();
        let length: f32 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let mut along = 0.0;
        for (k, point) in points.iter().enumerate() {
            if k > 0 {
                along += point.distance(points[k - 1]);
            }
            // Resampled guides have their vertices evenly along the strand.
            let u = if is_whole { k as f32 } else { along / length.max(1e-6) * (guide.len() - 1) as f32 };
            result.points[at] = if k == 0 { *point } else { catmull_rom(guide, u) };
            at += 1;
        }
    }
    Some(result)
}

/// How much nearer to the middle of their faces two guides begin that have one root.
const ASIDE: f32 = 0.15;

/// Per chain how far its root is to go towards the middle of its own faces: where chains part from one root, hair would else
/// not know which of them it is nearest to, and lie across the parting.
fn asides_at_partings(mesh: &HairMesh) -> Vec<Vec3> {
    let chains = mesh.chains();
    let Some(roots) = mesh.layers.first().map(|layer| &layer.positions) else { return Vec::new() };
    let mut n_from = vec![0; roots.len()];
    chains.chains.iter().for_each(|chain| n_from[chain[0] as usize] += 1);
    let mut middles = vec![(Vec3::ZERO, 0.0); chains.chains.len()];
    for corners in chains.of_bundle.iter().filter(|corners| !corners.is_empty()) {
        let root = |&chain: &u32| roots[chains.chains[chain as usize][0] as usize];
        let middle = corners.iter().map(root).sum::<Vec3>() / corners.len() as f32;
        for &chain in corners {
            let (sum, n) = &mut middles[chain as usize];
            (*sum, *n) = (*sum + middle, *n + 1.0);
        }
    }
    let aside = |(chain, (sum, n)): (&Vec<u32>, (Vec3, f32))| {
        let root = chain[0] as usize;
        if n_from[root] > 1 { ASIDE * (sum / n - roots[root]) } else { Vec3::ZERO }
    };
    chains.chains.iter().zip(middles).map(aside).collect()
}

/// Where the vertices of a hair mesh's chains are along guides that were made of them; the root layer stays.
fn vertices_at(mesh: &HairMesh, moved: &GuideSet) -> Option<Vec<(VertexId, Vec3)>> {
    let chains = mesh.chains();
    let (at_rest, _) = GuideSet::of_chains(mesh, &chains);
    if (at_rest.n_vertices, at_rest.n_guides()) != (moved.n_vertices, moved.n_guides()) {
        return None;
    }
    // Chains may share a vertex: it goes to the middle of where they have it.
    let mut places: BTreeMap<VertexId, (Vec3, f32)> = BTreeMap::new();
    for (guide_idx, chain) in chains.chains.iter().enumerate() {
        let samples = GuideSet::samples_of_chain(chain.len(), moved.n_vertices as usize);
        for (layer, (&vertex, sample)) in chain.iter().zip(samples).enumerate().skip(1) {
            let place = places.entry(VertexId { layer, vertex }).or_insert((Vec3::ZERO, 0.0));
            *place = (place.0 + moved.guide(guide_idx)[sample], place.1 + 1.0);
        }
    }
    Some(places.into_iter().map(|(vertex, (sum, n))| (vertex, sum / n)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::{HairMeshLayer, Weld};
    use crate::moved::MovedHair;
    use crate::simulation::Moved;

    fn groom_of(source: Source) -> Groom {
        Groom { layers: vec![Layer::new("a", source)], ..Groom::default() }
    }

    fn guides_of(groom: &Groom) -> GuideSet {
        match &groom.layers[0].source {
            Source::HairMesh(mesh) => GuideSet::of_chains(mesh, &mesh.chains()).0,
            Source::Guides(strands) | Source::Strands(strands) => GuideSet::of_strands(strands),
        }
    }

    fn blown(guides: &GuideSet) -> GuideSet {
        let n = guides.n_vertices as usize;
        let positions =
            guides.positions.iter().enumerate().map(|(i, p)| *p + Vec3::X * (0.2 * (i % n) as f32)).collect();
        GuideSet { positions, ..guides.clone() }
    }

    fn mesh() -> HairMesh {
        let layer = |y: f32| HairMeshLayer {
            positions: [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[x, z]| Vec3::new(x, y, z)).to_vec(),
            faces: vec![Some(vec![0, 1, 2, 3])],
            pinned: Vec::new(),
        };
        HairMesh { layers: (0..5).map(|k| layer(-3.0 * k as f32)).collect() }
    }

    fn strands(lengths: &[usize]) -> Strands {
        let mut strands = Strands::default();
        for (i, &n) in lengths.iter().enumerate() {
            let points: Vec<Vec3> =
                (0..n).map(|k| Vec3::new(i as f32, -8.0 * k as f32 / (n - 1) as f32, 0.0)).collect();
            strands.push(&points);
        }
        strands
    }

    #[test]
    fn what_rests_where_it_moved_to_has_those_guides_and_undo_brings_it_back() {
        for source in [
            Source::Guides(Arc::new(strands(&[6, 6, 6]))),
            Source::Strands(Arc::new(strands(&[9, 9]))),
            Source::HairMesh(Arc::new(mesh())),
        ] {
            let mut groom = groom_of(source);
            let before = groom.clone();
            let moved = blown(&guides_of(&groom));
            let undo = groom.apply(groom.rest_at(0, &moved).unwrap()).unwrap();
            let now = guides_of(&groom);
            let farthest = now.positions.iter().zip(&moved.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            // Between a hair mesh's layers a spline may differ from the way that hair has bent.
            assert!(farthest < 0.1, "{farthest} cm");
            groom.apply(undo).unwrap();
            assert_eq!(groom, before);
        }
    }

    #[test]
    fn strands_of_many_lengths_keep_their_points_and_their_roots() {
        let mut groom = groom_of(Source::Strands(Arc::new(strands(&[3, 20, 90]))));
        let moved = blown(&guides_of(&groom));
        groom.apply(groom.rest_at(0, &moved).unwrap()).unwrap();
        let Source::Strands(after) = &groom.layers[0].source else { panic!() };
        assert_eq!(after.offsets, strands(&[3, 20, 90]).offsets);
        for (idx, points) in after.iter().enumerate() {
            assert_eq!(points[0], Vec3::new(idx as f32, 0.0, 0.0));
            assert!(points[points.len() - 1].distance(moved.guide(idx)[moved.n_vertices as usize - 1]) < 1e-3);
        }
    }

    #[test]
    fn guides_of_another_layer_and_numbers_that_are_none_are_refused() {
        let groom = groom_of(Source::Guides(Arc::new(strands(&[6, 6]))));
        let mut moved = guides_of(&groom);
        assert!(groom.rest_at(1, &moved).is_none());
        let fewer = GuideSet { n_vertices: 6, positions: moved.positions[..6].to_vec() };
        assert!(groom.rest_at(0, &fewer).is_none());
        moved.positions[3].x = f32::NAN;
        assert!(groom.rest_at(0, &moved).is_none() && groom.baked(0, &moved).is_none());
    }

    #[test]
    fn a_baked_layer_has_the_guides_and_stands_above_the_others() {
        let mut groom = groom_of(Source::HairMesh(Arc::new(mesh())));
        let moved = blown(&guides_of(&groom));
        groom.apply(groom.baked(0, &moved).unwrap()).unwrap();
        assert_eq!(groom.layers.len(), 2);
        let Source::Guides(strands) = &groom.layers[1].source else { panic!() };
        assert_eq!(GuideSet::of_strands(strands), moved);
    }

    #[test]
    fn a_parting_is_still_there_when_it_was_baked() {
        let mut mesh = crate::hair_mesh::tests::straight_grid(2, 0);
        let away = |sign: f32| move |p: Vec3| p + Vec3::new(3.0 * sign, -1.0, 0.0);
        for _ in 0..3 {
            mesh.extrude(&[0, 2], Weld::Neighbours, |v| away(-1.0)(v.position)).unwrap();
            mesh.extrude(&[1, 3], Weld::Apart, |v| away(1.0)(v.position)).unwrap();
        }
        let mut groom = groom_of(Source::HairMesh(Arc::new(mesh)));
        groom.layers[0].n_strands = 400;
        let moved = guides_of(&groom);
        groom.apply(groom.baked(0, &moved).unwrap()).unwrap();
        let binding = crate::binding::bind_layer(&groom.layers[1], None);
        let n = binding.guides.n_vertices as usize;
        let mut n_seen = 0;
        for strand_idx in 0..binding.n_strands() {
            let from_parting = binding.roots[strand_idx].x - 1.0;
            let tip_of = |guide_idx: u32| binding.guides.positions[guide_idx as usize * n + n - 1].x - 1.0;
            for influence in binding.influences(strand_idx) {
                // Nearer than a twentieth of a face it may be either.
                if from_parting.abs() > 0.05 && influence.weight > 0.01 {
                    n_seen += 1;
                    assert_eq!(tip_of(influence.guide_idx) > 0.0, from_parting > 0.0, "{from_parting} cm from it");
                }
            }
        }
        assert!(n_seen > 300, "{n_seen}");
    }

    #[test]
    fn baked_strands_are_drawn_where_they_are_whatever_style_had_made_them() {
        let mut groom = groom_of(Source::HairMesh(Arc::new(mesh())));
        groom.layers[0].n_strands = 30;
        let binding = crate::binding::bind_layer(&groom.layers[0], None);
        let hair = MovedHair::new(Moved::Strands, &groom.layers[0], &binding, None);
        let moved = blown(&hair.curves);
        groom.apply(groom.baked_strands(0, &moved).unwrap()).unwrap();
        let baked = &groom.layers[1];
        let binding = crate::binding::bind_layer(baked, None);
        assert_eq!((binding.n_strands(), baked.style.len()), (30, 0));
        let hair = MovedHair::new(Moved::Strands, baked, &binding, None);
        // In whatever order: each is where one was.
        for strand in hair.curves.positions.chunks(hair.curves.n_vertices as usize) {
            let near = moved
                .positions
                .chunks(moved.n_vertices as usize)
                .map(|other| strand.iter().zip(other).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max));
            assert!(near.fold(f32::INFINITY, f32::min) < 1e-3);
        }
    }
}
