//! What sculpt layers promise: strokes outlive every change below them, and layers add up.

use std::sync::Arc;

use glam::Vec3;

use super::*;
use crate::binding::bind_layer;
use crate::generate::{Pose, generate};
use crate::groom::{Head, Source};
use crate::hair_mesh::{HairMesh, Weld};
use crate::maps::ScalpMap;
use crate::mesh_query::tests::sphere;
use crate::point_grid::PointGrid;
use crate::strands::Strands;

pub(crate) fn ball() -> Head {
    let mut ball = sphere(Vec3::ZERO, 8.0, 48);
    ball.uvs = ball.positions.iter().map(|p| [0.5 + p.x / 20.0, 0.5 + p.z / 20.0]).collect();
    Head::new("ball", ball)
}

/// A cap of `n` x `n` faces on the ball, whose layers fall to all sides.
pub(crate) fn fallen_hair(n: u32) -> Layer {
    let side = n + 1;
    let at = |i: u32| {
        let [x, z] = [i % side, i / side].map(|c| 6.0 * c as f32 / n as f32 - 3.0);
        Vec3::new(x, 4.0, z).normalize() * 8.0
    };
    let faces = (0..n * n).map(|i| i % n + side * (i / n)).map(|c| vec![c, c + side, c + side + 1, c + 1]);
    let mut mesh = HairMesh::from_polygons((0..side * side).map(at).collect(), faces.collect()).unwrap();
    let all: Vec<usize> = (0..mesh.n_bundles()).collect();
    for k in 1..7 {
        mesh.extrude(&all, Weld::Neighbours, |v| {
            v.position + Vec3::new(0.18 * v.position.x, 0.9 - 0.55 * k as f32, 0.18 * v.position.z)
        })
        .unwrap();
    }
    Layer { n_strands: 3000, vertices_per_strand: 24, ..Layer::new("hair", Source::HairMesh(Arc::new(mesh))) }
}

/// Sculpted by a field over the scalp that is not the same anywhere.
fn sculpted(mut layer: Layer, head: &Head) -> Layer {
    layer.sculpt.roots = Arc::new(SculptRoots::of_layer(&layer, Some(head)));
    let mut sculpt = SculptLayer::new("by hand");
    let strokes = Arc::make_mut(&mut sculpt.strokes);
    for (id, p) in layer.sculpt.roots.positions.iter().enumerate() {
        // Only one side: the other is not stored.
        if p.x > -1.0 {
            let x = (p.x + 1.0).min(2.0);
            let offset = |k: usize| {
                let along = k as f32 / (K - 1) as f32;
                [1.2 * x * along, 0.8 * along * (0.4 * p.z).sin(), 0.5 * x * along * along]
            };
            strokes.ids.push(id as u32);
            strokes.guides.push(SculptGuide {
                offsets: std::array::from_fn(offset),
                length: 1.0 + 0.1 * x,
                ..SculptGuide::default()
            });
        }
    }
    layer.sculpt.layers.push(sculpt);
    layer
}

/// Roots and what sculpting does to the tips.
fn displacements(layer: &Layer, head: &Head) -> (Vec<Vec3>, Vec<Vec3>) {
    let binding = bind_layer(layer, Some(head));
    let bare = Layer { sculpt: Sculpt::default(), ..layer.clone() };
    let make = |layer: &Layer| -> Strands { generate(&binding, layer, &binding.guides.positions, &Pose::default()) };
    let (with, without) = (make(layer), make(&bare));
    let tip = |strands: &Strands, s: usize| *strands.strand(s).last().unwrap();
    let moved = (0..binding.n_strands()).map(|s| tip(&with, s) - tip(&without, s)).collect();
    (binding.roots, moved)
}

/// How much two sculpted layers differ in what sculpting does at the same places: mean over places, as a share of
/// the mean displacement.
fn difference(a: &Layer, b: &Layer, head: &Head) -> f32 {
    let ((roots, moved), (other_roots, other)) = (displacements(a, head), displacements(b, head));
    let grid = PointGrid::new(&roots, 0.3);
    let (mut error, mut size, mut n) = (0.0, 0.0, 0);
    for (root, other) in other_roots.iter().zip(&other) {
        let (nearest, squared) = grid.nearest::<1>(*root).0[0];
        if squared < 0.04 {
            error += moved[nearest].distance(*other);
            size += moved[nearest].length();
            n += 1;
        }
    }
    assert!(n > 300, "{n} places to compare");
    error / size
}

#[test]
fn changing_density_count_seed_and_the_hair_mesh_keeps_every_stroke() {
    let head = ball();
    let first = sculpted(fallen_hair(6), &head);
    // What two throws of the dice of the same hair differ by, as their roots lie up to 2 mm apart.
    let floor = difference(&first, &Layer { seed: 9, n_strands: 4000, ..first.clone() }, &head);
    assert!(floor < 0.08, "another seed: {floor}");
    let more = Layer { n_strands: 20_000, ..first.clone() };
    let mut thin = first.clone();
    let map = ScalpMap::filled(40, 40, 60);
    thin.maps.insert(MapKind::Density, Arc::new(map));
    let mut moved = first.clone();
    let Source::HairMesh(mesh) = &mut moved.source else { panic!("hair mesh") };
    Arc::make_mut(mesh).move_vertices(4, |_, p| p + Vec3::new(0.3, 0.2, -0.3));
    Arc::make_mut(mesh).move_vertices(6, |_, p| p + Vec3::new(0.5, 0.4, 0.2));
    // Another topology: four faces, and four times four, where there was one.
    let mut finer = fallen_hair(12);
    finer.sculpt = first.sculpt.clone();
    let mut coarser = fallen_hair(3);
    coarser.sculpt = first.sculpt.clone();
    for (what, changed) in
        [("count", more), ("density", thin), ("moved", moved), ("finer", finer), ("coarser", coarser)]
    {
        let differs = difference(&first, &changed, &head);
        eprintln!(
            "{what}: the sculpted displacement differs by {:.1} % (another seed: {:.1} %)",
            100.0 * differs,
            100.0 * floor
        );
        assert!(differs < 0.12, "{what}: {differs}");
    }
}

#[test]
fn the_same_strand_is_sculpted_alike_whatever_the_count() {
    let head = ball();
    let first = sculpted(fallen_hair(6), &head);
    let (roots, moved) = displacements(&first, &head);
    let (more_roots, more) = displacements(&Layer { n_strands: 9000, ..first }, &head);
    assert_eq!(roots[..], more_roots[..3000]);
    assert_eq!(moved[..], more[..3000]);
}

#[test]
fn a_hair_mesh_that_grows_over_more_scalp_gets_further_guides_and_keeps_the_old() {
    let head = ball();
    let small = fallen_hair(6);
    let Source::HairMesh(mesh) = &small.source else { panic!("hair mesh") };
    let mut part = HairMesh::clone(mesh);
    for layer in &mut part.layers {
        layer.faces[..18].fill(None);
    }
    let half = Layer { source: Source::HairMesh(Arc::new(part)), ..small.clone() };
    let roots = SculptRoots::of_layer(&half, Some(&head));
    assert_eq!(roots.positions.len(), N_GUIDES);
    assert_eq!(roots.covering(&half, Some(&head)), None);
    let all = roots.covering(&small, Some(&head)).unwrap();
    assert_eq!(all.positions[..N_GUIDES], roots.positions[..]);
    let n_more = all.positions.len() - N_GUIDES;
    // As dense over the other half as the sequence of the whole is.
    assert!((N_GUIDES / 4..N_GUIDES * 3 / 4).contains(&n_more), "{n_more}");
    assert_eq!(SculptRoots::default().covering(&half, Some(&head)), Some(roots));
}

#[test]
fn guides_without_hair_are_left_out_and_come_back() {
    let head = ball();
    let mut layer = sculpted(fallen_hair(6), &head);
    let paths = GuidePaths::new(&layer, Some(&head), &layer.sculpt.roots);
    assert!(paths.is_there.iter().all(|there| *there));
    let Source::HairMesh(mesh) = &mut layer.source else { panic!("hair mesh") };
    for layer in &mut Arc::make_mut(mesh).layers {
        layer.faces[..12].fill(None);
    }
    let paths = GuidePaths::new(&layer, Some(&head), &layer.sculpt.roots);
    let n_there = paths.is_there.iter().filter(|there| **there).count();
    assert!(n_there > N_GUIDES / 2 && n_there < N_GUIDES * 9 / 10, "{n_there}");
}

#[test]
fn every_source_has_guides_that_follow_its_hair() {
    let head = ball();
    let hair = fallen_hair(6);
    let binding = bind_layer(&Layer { n_strands: 400, ..hair.clone() }, Some(&head));
    let strands = generate(&binding, &hair, &binding.guides.positions, &Pose::default());
    let imported = Layer::from_strands("strands", strands.clone());
    let guides = Layer { n_strands: 2000, ..Layer::new("guides", Source::Guides(Arc::new(strands))) };
    for layer in [imported, guides] {
        let layer = sculpted(layer, &head);
        assert!(layer.sculpt.roots.positions.len() >= 400);
        let (roots, moved) = displacements(&layer, &head);
        let at = |side: f32| roots.iter().zip(&moved).filter(move |(p, _)| side * p.x > 2.0).map(|(_, m)| m.length());
        assert!(at(1.0).sum::<f32>() / at(1.0).count() as f32 > 1.0);
        assert!(at(-1.0).fold(0.0, f32::max) < 1e-4);
    }
}

#[test]
fn layers_add_up_by_their_weights_and_masks_and_merge_without_a_change() {
    let head = ball();
    let mut layer = sculpted(fallen_hair(6), &head);
    let mut second = layer.sculpt.layers[0].clone();
    for guide in &mut Arc::make_mut(&mut second.strokes).guides {
        guide.offsets = guide.offsets.map(|[x, y, z]| [-0.4 * y, 0.3 * x, -z]);
        guide.keep = 0.5;
        guide.masked = 0.25;
    }
    second.weight = 0.5;
    second.mask = SculptMask::Painted;
    layer.sculpt.layers.push(second);
    let first = layer.sculpt.layers[0].strokes.guides[7];
    let id = layer.sculpt.layers[0].strokes.ids[7] as usize;
    let composed = Composite::of(&layer).guides[id];
    let share = 0.5 * 0.75;
    assert!((composed[9][0] - (first.offsets[9][0] - share * 0.4 * first.offsets[9][1])).abs() < 1e-5);
    assert!((composed[2][3] - (1.0 - share * 0.5)).abs() < 1e-5);
    let merged = layer.sculpt.merged_down(&layer.maps, 1).unwrap();
    let mut one = layer.clone();
    one.sculpt.layers = vec![merged];
    let (a, b) = (Composite::of(&layer), Composite::of(&one));
    for (a, b) in a.guides.iter().zip(&b.guides) {
        assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-4));
    }
    // A painted map of the layer as a mask: only where it is painted.
    let kind = MapKind::Mask("side".to_owned());
    let map = ScalpMap::filled(64, 64, 255);
    layer.sculpt.layers.truncate(1);
    layer.sculpt.layers[0].mask = SculptMask::Map(kind.clone());
    assert!(Composite::of(&layer).guides.iter().all(|guide| guide[9][0] == 0.0), "an empty mask covers nothing");
    layer.maps.insert(kind, Arc::new(map));
    assert!(Composite::of(&layer).guides.iter().any(|guide| guide[9][0] != 0.0));
}

#[test]
fn strokes_keep_their_order_and_changes_come_back() {
    let guide = |x: f32| Some(Box::new(SculptGuide { length: x, ..SculptGuide::default() }));
    let set = |guide: u32, to| SculptChange { guide, to };
    let mut strokes = SculptStrokes::default();
    let first = strokes.apply(&[set(3, guide(1.5)), set(8, guide(2.0))]);
    let second = strokes.apply(&[set(1, guide(3.0)), set(3, None), set(8, guide(4.0)), set(9, guide(5.0))]);
    assert_eq!(strokes.ids, [1, 8, 9]);
    assert_eq!(strokes.check(10), Ok(()));
    assert!(strokes.check(9).is_err());
    let mut both = first.clone();
    join_changes(&mut both, &second);
    let last = strokes.clone();
    let redo = strokes.apply(&both);
    assert_eq!(strokes, SculptStrokes::default());
    strokes.apply(&redo);
    assert_eq!(strokes, last);
    strokes.apply(&second);
    strokes.apply(&first);
    assert_eq!(strokes, SculptStrokes::default());
    assert!(refuses(&second, 9).unwrap().contains("no sculpt guide 9"));
    assert!(refuses(&[second[1].clone(), second[0].clone()], 99).is_some());
}

#[test]
fn a_composite_tells_which_guides_changed() {
    let before = Composite { guides: vec![compose::UNTOUCHED; 100] };
    let mut after = before.clone();
    assert!(after.changed_since(&before).is_empty());
    for at in [3, 5, 60] {
        after.guides[at][4][1] = 1.0;
    }
    assert_eq!(after.changed_since(&before), [3..6, 60..61]);
}

/// Sculpted by a stroke of the add brush over one side: twice and a half as dense there.
fn planted(mut layer: Layer, head: &Head) -> Layer {
    layer.sculpt.roots = Arc::new(SculptRoots::of_layer(&layer, Some(head)));
    let mut sculpt = SculptLayer::new("planted");
    let strokes = Arc::make_mut(&mut sculpt.strokes);
    for (id, p) in layer.sculpt.roots.positions.iter().enumerate().filter(|(_, p)| p.x > 0.0) {
        let keep = 1.0 + 1.5 * (p.x / 0.5).min(1.0);
        strokes.ids.push(id as u32);
        strokes.guides.push(SculptGuide { keep, ..SculptGuide::default() });
    }
    layer.sculpt.layers.push(sculpt);
    layer
}

#[test]
fn planting_adds_strands_where_it_was_painted_and_outlives_count_density_and_hair_mesh() {
    let head = ball();
    let bind = |layer: &Layer| bind_layer(layer, Some(&head));
    let dense = |roots: &[Vec3]| roots.iter().filter(|p| p.x > 0.6).count() as f32;
    let bare = |roots: &[Vec3]| roots.iter().filter(|p| p.x < -0.1).count() as f32;
    let hair = fallen_hair(6);
    let strands = {
        let binding = bind(&Layer { n_strands: 300, ..hair.clone() });
        generate(&binding, &hair, &binding.guides.positions, &Pose::default())
    };
    let guides = Layer { n_strands: 3000, ..Layer::new("guides", Source::Guides(Arc::new(strands))) };
    for layer in [hair.clone(), guides] {
        let with = planted(layer.clone(), &head);
        let (before, after) = (bind(&layer), bind(&with));
        let set = |ids: &[u32]| ids.iter().copied().collect::<std::collections::BTreeSet<u32>>();
        assert!(set(&before.ids).is_subset(&set(&after.ids)), "planting takes no strand away");
        for (s, id) in before.ids.iter().enumerate() {
            let again = after.ids.iter().position(|known| known == id).unwrap();
            assert_eq!((before.roots[s], before.seeds[s]), (after.roots[again], after.seeds[again]));
        }
        let share = dense(&after.roots) / dense(&before.roots);
        assert!((share - 2.5).abs() < 0.3, "{share} times as many");
        assert_eq!(bare(&after.roots), bare(&before.roots), "none where nothing was painted");
        // Half of the order of detail has half of the planted strands.
        let half = &after.roots[..after.n_strands() / 2];
        let (of_half, of_all) = (dense(half) / half.len() as f32, dense(&after.roots) / after.n_strands() as f32);
        assert!((of_half / of_all - 1.0).abs() < 0.1);
        // More strands: the planted ones are among them.
        let more = bind(&Layer { n_strands: 5000, ..with.clone() });
        assert!(set(&after.ids).is_subset(&set(&more.ids)));
        // A density map takes some of all.
        let mut thin = with.clone();
        thin.maps.insert(MapKind::Density, Arc::new(ScalpMap::filled(40, 40, 128)));
        let thin = bind(&thin);
        assert!(set(&thin.ids).is_subset(&set(&after.ids)));
        let share = dense(&thin.roots) / dense(&after.roots);
        assert!((share - 0.5).abs() < 0.1, "{share}");
        // A layer that is counted in all gets the planted strands on top.
        let total = |layer: &Layer| bind(&Layer { count: crate::groom::StrandCount::Total, ..layer.clone() });
        let (before, after) = (total(&layer), total(&with));
        assert!(set(&before.ids).is_subset(&set(&after.ids)) && after.n_strands() > before.n_strands() * 5 / 4);
        // Off, weighted or undone, as any sculpting.
        let mut off = with.clone();
        off.sculpt.layers[0].on = false;
        assert_eq!(bind(&off).ids, bind(&layer).ids);
        let mut less = with.clone();
        less.sculpt.layers[0].weight = 0.5;
        let share = dense(&bind(&less).roots) / dense(&bind(&layer).roots);
        assert!((share - 1.75).abs() < 0.25, "{share} at half the weight");
    }
    // Another hair mesh, with four faces where there was one: as dense in the same place.
    let mut finer = fallen_hair(12);
    finer.sculpt = planted(hair, &head).sculpt;
    let plain = Layer { sculpt: Sculpt::default(), ..finer.clone() };
    let share = dense(&bind(&finer).roots) / dense(&bind(&plain).roots);
    assert!((share - 2.5).abs() < 0.3, "{share} times as many on another hair mesh");
}

#[test]
fn deleted_strands_are_not_exported() {
    use crate::groom::Groom;
    use crate::io::{What, strands_of};
    let head = ball();
    let hair = fallen_hair(6);
    let binding = bind_layer(&Layer { n_strands: 900, ..hair.clone() }, Some(&head));
    let strands = generate(&binding, &hair, &binding.guides.positions, &Pose::default());
    let imported = Layer::from_strands("strands", strands.clone());
    let guides = Layer { n_strands: 2000, ..Layer::new("guides", Source::Guides(Arc::new(strands))) };
    for layer in [hair, imported, guides] {
        let mut bald = layer.clone();
        bald.sculpt.roots = Arc::new(SculptRoots::of_layer(&layer, Some(&head)));
        let mut sculpt = SculptLayer::new("bald on one side");
        let strokes = Arc::make_mut(&mut sculpt.strokes);
        for (id, p) in bald.sculpt.roots.positions.iter().enumerate().filter(|(_, p)| p.x > 0.0) {
            strokes.ids.push(id as u32);
            strokes.guides.push(SculptGuide { keep: if p.x > 0.3 { 0.0 } else { 0.5 }, ..SculptGuide::default() });
        }
        bald.sculpt.layers.push(sculpt);
        let groom = |layer: &Layer| Groom { head: Some(head.clone()), layers: vec![layer.clone()], ..Groom::default() };
        for what in [What::Strands, What::Guides] {
            let (before, after) = (strands_of(&groom(&layer), what), strands_of(&groom(&bald), what));
            let on_the_right = |strands: &Strands| strands.iter().filter(|points| points[0].x > 0.9).count();
            assert!(on_the_right(&before) > 5, "{what:?}");
            assert_eq!(on_the_right(&after), 0, "{what:?} of {}", layer.name);
            assert!(after.n_strands() < before.n_strands() * 3 / 4 && after.n_strands() > before.n_strands() / 4);
            assert!(after.iter().all(|points| crate::strands::polyline_length(points) > 0.5), "no strand is a point");
            assert_eq!(
                (after.radii_um.len(), after.points.len()),
                (after.n_points(), after.offsets[after.n_strands()] as usize)
            );
        }
    }
}
