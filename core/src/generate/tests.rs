//! Laws of tracing and styling, and what strands from every source look like.

use std::sync::Arc;

use super::*;
use crate::binding::{LayerBinding, Tie, bind_layer, counted_where_full, rebind_layer};
use crate::curve::catmull_rom;
use crate::groom::{Head, Source, StrandCount};
use crate::hair_mesh::tests::straight_grid;
use crate::hair_mesh::{HairMesh, Weld};
use crate::io::Watch;
use crate::lod::LodSettings;
use crate::maps::{MapKind, Maps, ScalpMap};
use crate::mean_value::mean_value_weights;
use crate::mesh::TriMesh;
use crate::mesh_query::tests::sphere;
use crate::strands::polyline_length;
use crate::style::{Blend, Profile, StyleKind, StyleOp};

fn layer(mesh: HairMesh, n_strands: u32) -> Layer {
    Layer { n_strands, vertices_per_strand: 24, ..Layer::new("test", Source::HairMesh(Arc::new(mesh))) }
}

fn make(layer: &Layer, pose: &Pose<'_>) -> (LayerBinding, Strands) {
    let binding = bind_layer(layer, None);
    let strands = generate(&binding, layer, &binding.guides.positions, pose);
    (binding, strands)
}

/// A grid that leans, bends and spreads more from layer to layer.
fn bent_grid() -> HairMesh {
    let mut mesh = straight_grid(3, 0);
    let all: Vec<usize> = (0..9).collect();
    for k in 0..5 {
        let turn = glam::Quat::from_rotation_z(-0.35 * k as f32);
        mesh.extrude(&all, Weld::Neighbours, |v| v.position * Vec3::new(1.1, 1.0, 1.0) + turn * Vec3::Y * 2.0).unwrap();
    }
    mesh
}

#[test]
fn a_straight_hair_mesh_gives_straight_parallel_strands() {
    let (_, strands) = make(&layer(straight_grid(3, 4), 300), &Pose::default());
    for strand in strands.iter() {
        for (v, p) in strand.iter().enumerate() {
            let expected = strand[0] + Vec3::Y * (4.0 * v as f32 / 23.0);
            assert!(p.distance(expected) < 1e-4, "{p} {expected}");
        }
    }
    // Weights sum to 1, and roots are on their face.
    let (binding, _) = make(&layer(bent_grid(), 300), &Pose::default());
    for strand_idx in 0..300 {
        let sum: f32 = binding.influences(strand_idx).iter().map(|i| i.weight).sum();
        assert!((sum - 1.0).abs() < 1e-5);
        assert!(binding.root_offsets[strand_idx].length() < 1e-4);
    }
}

#[test]
fn strands_are_traced_as_the_paper_says() {
    // Yuksel et al. 2009, 3.1: weights of the root in its face, applied in every layer, then the spline.
    let mesh = bent_grid();
    let (binding, strands) = make(&layer(mesh.clone(), 200), &Pose::default());
    let surface = crate::roots::RootSurface::of_hair_mesh(&mesh);
    let roots = surface.sequence(200, 0);
    for (strand_idx, root) in roots.iter().enumerate() {
        let bundle = root.face as usize;
        let corners: Vec<Vec3> = (0..4).map(|c| mesh.corner_positions(bundle, c).next().unwrap()).collect();
        let weights = mean_value_weights(&corners, root.position);
        let control: Vec<Vec3> = (0..mesh.layers.len())
            .map(|k| (0..4).map(|c| weights[c] * mesh.corner_positions(bundle, c).nth(k).unwrap()).sum())
            .collect();
        assert_eq!(binding.ids[strand_idx], strand_idx as u32);
        let length = polyline_length(&control);
        for p in strands.strand(strand_idx) {
            let on_curve = (0..=1000).map(|k| catmull_rom(&control, 5.0 * k as f32 / 1000.0));
            let nearest = on_curve.map(|q| q.distance(*p)).fold(f32::MAX, f32::min);
            // The guides' samples meet the paper's curve at every layer; in between, the curve through the
            // samples leaves the curve through the layers by less than this share of the length.
            assert!(nearest < 2e-3 * length, "{nearest} of {length}");
        }
    }
}

#[test]
fn strands_at_corners_run_along_their_edges() {
    let mesh = bent_grid();
    let mut binding = bind_layer(&layer(mesh.clone(), 16), None);
    let chains = mesh.chains();
    for corner in 0..4 {
        binding.influences[corner] = crate::guides::Influence { guide_idx: chains.of_bundle[4][corner], weight: 1.0 };
        binding.influence_offsets[corner + 1] = corner as u32 + 1;
        binding.root_offsets[corner] = Vec3::ZERO;
    }
    let layer = Layer { vertices_per_strand: 128, ..layer(mesh.clone(), 16) };
    let strands = generate(&binding, &layer, &binding.guides.positions, &Pose { lod: 0.25, ..Pose::default() });
    assert!((4..=5).contains(&strands.n_strands()));
    for corner in 0..4 {
        for p in mesh.corner_positions(4, corner) {
            // Vertices are evenly spaced along the mean length and need not lie at the layers: their chords do.
            let from_chord = |ends: &[Vec3]| {
                let along = ends[1] - ends[0];
                let t = ((p - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                (ends[0] + t * along).distance(p)
            };
            let nearest = strands.strand(corner).windows(2).map(from_chord).fold(f32::MAX, f32::min);
            assert!(nearest < 1e-3, "{nearest}");
        }
    }
}

#[test]
fn moving_vertices_moves_guides_and_nothing_else() {
    let mesh = bent_grid();
    let layer = Layer { style: vec![StyleOp::new(StyleKind::DEFAULTS[0])], ..layer(mesh.clone(), 500) };
    let binding = bind_layer(&layer, None);
    let mut bent = mesh.clone();
    bent.layers[3].positions[5] += Vec3::new(0.1, 0.4, -0.2);
    assert!(mesh.differs_in_shape_only(&bent));
    let moved = binding.moved(&bent);
    let anew = bind_layer(&Layer { source: Source::HairMesh(Arc::new(bent.clone())), ..layer }, None);
    assert!(moved == anew, "the quick way and the long way agree");
    assert!(moved.clumps == binding.clumps && moved.guides != binding.guides);
    bent.layers[0].positions[5] += Vec3::X * 0.1;
    assert!(!mesh.differs_in_shape_only(&bent), "other roots, other strands");
}

fn styled(kind: StyleKind) -> Layer {
    Layer { style: vec![StyleOp::new(kind)], ..layer(bent_grid(), 2000) }
}

#[test]
fn every_style_kind_does_what_it_says() {
    let (_, plain) = make(&layer(bent_grid(), 2000), &Pose::default());
    for kind in StyleKind::DEFAULTS {
        let styled = styled(kind);
        let (binding, strands) = make(&styled, &Pose::default());
        assert!(strands.points.iter().all(|p| p.is_finite()));
        assert!(strands != plain, "{} does nothing", kind.label());
        let off = Layer { style: vec![StyleOp { strength: 0.0, ..StyleOp::new(kind) }], ..styled.clone() };
        assert!(make(&off, &Pose::default()).1 == plain, "{} at strength 0 does something", kind.label());
        let mut n_moved = 0;
        for strand_idx in 0..2000 {
            let (a, b) = (plain.strand(strand_idx), strands.strand(strand_idx));
            assert!(a[0].distance(b[0]) < 1e-5, "{} moves the root", kind.label());
            let shift = a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            n_moved += usize::from(shift > 1e-3);
            let (long_before, long) = (polyline_length(a), polyline_length(b));
            match kind {
                StyleKind::Length { variation, .. } => {
                    assert!((1.0 - variation - 0.05..=1.001).contains(&(long / long_before)), "{long} {long_before}");
                }
                StyleKind::Clump { .. } => {
                    let middle = binding.clumps.middle(strand_idx, Some(0));
                    let apart = |strands: &Strands| strands.strand(strand_idx)[18].distance(strands.strand(middle)[18]);
                    assert!(apart(&strands) <= apart(&plain) + 1e-4);
                }
                StyleKind::Wave { amplitude, .. } => assert!(shift <= 1.31 * amplitude),
                StyleKind::Curl { radius, loosen, .. } => assert!(shift <= 1.21 * radius * (1.0 + loosen)),
                StyleKind::Frizz { amplitude, .. } => assert!(shift <= 3.0 * amplitude),
                StyleKind::Deviate { amplitude, .. } => assert!(shift <= 1.01 * amplitude),
                StyleKind::Bend { .. } => {
                    let falls = |points: &[Vec3]| (points[23] - points[22]).normalize().dot(Vec3::NEG_Y);
                    assert!((long / long_before - 1.0).abs() < 1e-4 && falls(b) > falls(a) - 1e-3);
                }
                StyleKind::Smooth { .. } => {
                    assert!(long < long_before + 1e-4 && a[23].distance(b[23]) < 1e-4, "ironed, ends where they were");
                }
                StyleKind::Part { .. } => {
                    assert!((long / long_before - 1.0).abs() < 1e-4 && b[12].x >= a[12].x - 1e-3);
                }
                StyleKind::Wisp { radius, fuzz, .. } => {
                    let middle = plain.strand(binding.clumps.middle(strand_idx, Some(0)));
                    // Strands stand out by up to 2 fuzz of their place and wander by up to 3 fuzz of the radius.
                    let most = radius * (1.0 + 5.0 * fuzz) + 0.1;
                    for p in &b[8..] {
                        let nearest = middle.iter().map(|q| q.distance(*p)).fold(f32::MAX, f32::min);
                        assert!(nearest < most, "{nearest} > {most}");
                    }
                }
            }
        }
        let expected = match kind {
            StyleKind::Deviate { share, .. } => 2000.0 * share,
            // The middles stay where they are.
            StyleKind::Length { .. } | StyleKind::Clump { .. } => 1950.0,
            StyleKind::Wave { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Frizz { .. }
            | StyleKind::Bend { .. }
            | StyleKind::Smooth { .. }
            | StyleKind::Part { .. }
            | StyleKind::Wisp { .. } => 1990.0,
        };
        assert!((n_moved as f32 - expected).abs() < 4.0 * expected.sqrt(), "{}: {n_moved}", kind.label());
    }
}

/// Strands of the bent grid under a stack.
fn under(style: Vec<StyleOp>) -> (LayerBinding, Strands) {
    make(&Layer { style, ..layer(bent_grid(), 2000) }, &Pose::default())
}

fn farthest(a: &Strands, b: &Strands) -> f32 {
    a.points.iter().zip(&b.points).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn replace_forgets_what_was_before_and_modulate_adds_nothing_itself() {
    let op = |kind: StyleKind, blend: Blend| StyleOp { blend, ramp: 0.0, ..StyleOp::new(kind) };
    let wave = StyleKind::Wave { amplitude: 0.5, wavelength: 3.0, strands_per_clump: 1.0 };
    let frizz = StyleKind::Frizz { amplitude: 0.3, wavelength: 2.0, strands_per_clump: 1.0 };
    let (_, plain) = under(Vec::new());
    let (_, wave_alone) = under(vec![op(wave, Blend::Add)]);
    let (_, frizz_alone) = under(vec![op(frizz, Blend::Add)]);
    let (_, replaced) = under(vec![op(frizz, Blend::Add), op(wave, Blend::Replace)]);
    assert!(farthest(&replaced, &wave_alone) < 1e-5 && farthest(&replaced, &frizz_alone) > 0.1);
    let (_, added) = under(vec![op(frizz, Blend::Add), op(wave, Blend::Add)]);
    for ((p, sum), (a, b)) in
        plain.points.iter().zip(&added.points).zip(wave_alone.points.iter().zip(&frizz_alone.points))
    {
        assert!((*sum - *p).distance(*a + *b - 2.0 * *p) < 1e-4, "displacements add up");
    }
    assert!(farthest(&under(vec![op(wave, Blend::Modulate)]).1, &plain) == 0.0);
    let (_, modulated) = under(vec![op(frizz, Blend::Add), op(wave, Blend::Modulate)]);
    assert!(farthest(&modulated, &frizz_alone) > 0.05);
    // A bend cannot modulate: that counts as adding.
    let bend =
        StyleKind::Bend { heading_deg: 0.0, elevation_deg: 0.0, gravity: 0.0, variation: 0.0, strands_per_clump: 1.0 };
    assert!(under(vec![op(bend, Blend::Modulate)]).1 == under(vec![op(bend, Blend::Add)]).1);
    // A cut or a clump that replaces forgets the cuts or clumps before it.
    let cut = |variation: f32| StyleKind::Length { variation, strands_per_clump: 1.0 };
    let other = StyleOp { seed: 5, ..op(cut(0.2), Blend::Replace) };
    assert!(under(vec![op(cut(0.9), Blend::Add), other.clone()]).1 == under(vec![other]).1);
    let clump = |strands_per_clump: f32| StyleKind::Clump { strands_per_clump, flare: 0.0, stray: 0.0 };
    let forgets = |blend: Blend| under(vec![op(clump(400.0), Blend::Add), op(clump(20.0), blend)]).1;
    let alone = under(vec![op(clump(20.0), Blend::Add)]).1;
    assert!(farthest(&forgets(Blend::Replace), &alone) < 1e-4 && farthest(&forgets(Blend::Add), &alone) > 0.1);
}

#[test]
fn a_drawn_curve_says_where_an_operator_acts() {
    let wave = StyleOp::new(StyleKind::Wave { amplitude: 0.5, wavelength: 3.0, strands_per_clump: 1.0 });
    let curve = Profile::of(&[[0.0, 0.0], [0.45, 0.0], [0.5, 1.0], [0.6, 0.0], [1.0, 0.0]]);
    let (_, plain) = under(Vec::new());
    let (_, drawn) = under(vec![StyleOp { curve, ..wave }]);
    let moved = |v: usize| (0..2000).any(|s| drawn.strand(s)[v].distance(plain.strand(s)[v]) > 1e-3);
    assert!((0..10).chain(15..24).all(|v| !moved(v)) && (11..14).all(moved));
}

#[test]
fn operators_before_a_wisp_act_on_whole_wisps() {
    let wisp = StyleOp::new(StyleKind::Wisp {
        strands_per_clump: 50.0,
        radius: 0.3,
        gather: 0.2,
        fuzz: 0.0,
        twist: 0.0,
        length_variation: 0.0,
    });
    let wave = StyleOp {
        ramp: 0.0,
        ..StyleOp::new(StyleKind::Wave { amplitude: 0.8, wavelength: 4.0, strands_per_clump: 1.0 })
    };
    let (binding, alone) = under(vec![wisp.clone()]);
    let (_, before) = under(vec![wave.clone(), wisp.clone()]);
    let (_, after) = under(vec![wisp, wave]);
    let spread = |styled: &Strands| -> f32 {
        let apart = (50..2000).map(|s| {
            let middle = binding.clumps.middle(s, Some(0));
            let moved = |s: usize| styled.strand(s)[16] - alone.strand(s)[16];
            moved(s).distance(moved(middle))
        });
        apart.sum::<f32>() / 1950.0
    };
    assert!(spread(&before) < 0.1 && spread(&after) > 0.4, "{} {}", spread(&before), spread(&after));
    // Roots stay on the scalp, and every strand of a wisp lies within its radius of it.
    let (_, plain) = under(Vec::new());
    for s in 0..2000 {
        assert!(alone.strand(s)[0].distance(plain.strand(s)[0]) < 1e-5);
        let middle = alone.strand(binding.clumps.middle(s, Some(0)));
        assert!(alone.strand(s)[16].distance(middle[16]) < 0.3 + 1e-3);
    }
}

#[test]
fn a_parting_divides_hair_that_lies_across_it() {
    // All strands lean to +x; the line runs through the middle of the grid.
    let part = StyleOp::new(StyleKind::Part { offset: 1.5, turn_deg: 0.0, width: 6.0 });
    let (binding, plain) = under(Vec::new());
    let (_, parted) = under(vec![part]);
    for s in 0..2000 {
        let side = binding.roots[s].x - 1.5;
        let pushed = parted.strand(s)[10].x - plain.strand(s)[10].x;
        if side.abs() > 0.1 {
            assert!(pushed * side >= -1e-4, "{side} {pushed}");
        }
        if (-1.0..-0.1).contains(&side) {
            assert!(pushed < -0.3, "{pushed}");
        }
    }
}

/// How much farther than a vertex of the hair mesh any vertex of any strand moves, for a move of 1 mm in several
/// directions at several places; not one strand is left out.
fn most_moved(style: &[StyleOp]) -> f32 {
    let styled = Layer { style: style.to_vec(), ..layer(bent_grid(), 2000) };
    let (_, before) = make(&styled, &Pose::default());
    let mut most: f32 = 0.0;
    for (layer_idx, vertex, towards) in [
        (1, 5, Vec3::X),
        (1, 6, Vec3::NEG_Y),
        (2, 10, Vec3::Z),
        (3, 6, Vec3::new(0.5, -0.6, 0.6)),
        (4, 0, Vec3::Y),
        (5, 9, Vec3::new(-0.5, 0.6, 0.6)),
    ] {
        let mut mesh = bent_grid();
        mesh.layers[layer_idx].positions[vertex] += 0.1 * towards.normalize();
        let moved = Layer { source: Source::HairMesh(Arc::new(mesh)), ..styled.clone() };
        let (_, after) = make(&moved, &Pose::default());
        most = most.max(farthest(&before, &after) / 0.1);
    }
    most
}

#[test]
fn moving_one_vertex_by_a_millimetre_moves_no_strand_by_much_more() {
    // The path itself follows its vertex; a spline swings beyond it a little.
    let plain = most_moved(&[]);
    assert!(plain < 1.2, "{plain}");
    for kind in StyleKind::DEFAULTS {
        // A wave, a curl or noise also slides along the strand as the path to it becomes longer: a curl of 0.6 cm
        // radius and 2 cm pitch turns by 2 pi 0.6 / 2 = 1.9 mm for a millimetre.
        let multiple = most_moved(&[StyleOp::new(kind)]);
        assert!(multiple < 2.5, "{}: 1 mm became {multiple} mm", kind.label());
    }
    let coarse = StyleOp::new(StyleKind::Clump { strands_per_clump: 300.0, flare: 0.0, stray: 0.2 });
    let mut stack: Vec<StyleOp> = StyleKind::DEFAULTS.into_iter().map(StyleOp::new).collect();
    stack.insert(0, coarse);
    let multiple = most_moved(&stack);
    assert!(multiple < 2.5, "1 mm became {multiple} mm under one of each");
    for preset in crate::style::presets::presets() {
        let multiple = most_moved(&preset.for_strands(2000));
        // Most under tight curls: 3.1.
        assert!(multiple < 4.0, "{}: 1 mm became {multiple} mm", preset.name);
    }
}

#[test]
fn covered_area_stays_over_levels_of_detail_and_nothing_pops() {
    let (binding, full) = make(&layer(bent_grid(), 3000), &Pose::default());
    let layer = layer(bent_grid(), 3000);
    let area = |strands: &Strands| -> f32 {
        (0..strands.n_strands())
            .map(|s| polyline_length(strands.strand(s)) * strands.radii_um[strands.range(s).start])
            .sum()
    };
    let at = |lod| generate(&binding, &layer, &binding.guides.positions, &Pose { lod, ..Pose::default() });
    for step in 1..=20 {
        let lod = 0.05 * step as f32;
        let ratio = area(&at(lod)) / area(&full);
        assert!((ratio - 1.0).abs() < 0.03, "{ratio} at {lod}");
    }
    for lod in [0.1, 0.3337, 0.8, 0.999] {
        let (a, b) = (at(lod), at(lod + 1e-3));
        for s in 0..b.n_strands() {
            let width = |strands: &Strands| strands.radii_um.get(s * 24).copied().unwrap_or(0.0);
            // The detail grows by a share of itself; no width changes by more than a dozen such shares.
            assert!(
                (width(&a) - width(&b)).abs() < 12.0 * (1e-3 / lod) * layer.radius_um / lod,
                "{s} {} {}",
                width(&a),
                width(&b)
            );
        }
    }
    assert_eq!(at(1.0).radii_um[0], layer.radius_um);
    assert!(at(0.0).n_strands() <= 2);
}

#[test]
fn strands_stay_out_of_the_head_in_their_order_and_turn_with_it() {
    let head = Head::new("ball", sphere(Vec3::ZERO, 8.0, 64));
    let field = DistanceField::from_mesh(&head.mesh, 64).unwrap();
    // A patch on top that lies over the ball and sinks into it.
    let mut mesh = straight_grid(4, 0);
    mesh.move_vertices(0, |_, p| 8.0 * ((p - Vec3::new(2.0, 0.0, 2.0)) * 0.7 + Vec3::Y * 6.0).normalize());
    let all: Vec<usize> = (0..16).collect();
    for k in 1..6 {
        let deep = 8.2 - 0.4 * k as f32;
        mesh.extrude(&all, Weld::Neighbours, |v| (glam::Quat::from_rotation_x(0.3) * v.position).normalize() * deep)
            .unwrap();
    }
    let layer = Layer { vertices_per_strand: 32, ..layer(mesh, 1000) };
    let binding = bind_layer(&layer, Some(&head));
    let rest = Pose { field: Some(&field), ..Pose::default() };
    let free = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
    let kept = generate(&binding, &layer, &binding.guides.positions, &rest);
    let n_inside = |strands: &Strands| strands.points.iter().filter(|p| p.length() < 7.95).count();
    assert!(n_inside(&free) > free.n_points() / 3);
    assert_eq!(n_inside(&kept), 0);
    assert!(binding.roots.iter().all(|root| (root.length() - 8.0).abs() < 0.02));
    assert!((0..1000).all(|s| kept.strand(s)[0].distance(binding.roots[s]) < 1e-4));

    let world_from_head =
        Affine3A::from_rotation_translation(glam::Quat::from_rotation_y(1.0), Vec3::new(3.0, 1.0, 2.0));
    let guides: Vec<Vec3> = binding.guides.positions.iter().map(|p| world_from_head.transform_point3(*p)).collect();
    let turned = generate(&binding, &layer, &guides, &Pose { world_from_head, ..rest });
    for (a, b) in kept.points.iter().zip(&turned.points) {
        assert!(world_from_head.transform_point3(*a).distance(*b) < 1e-3);
    }
}

#[test]
fn a_painted_map_places_every_strand_where_it_is_painted() {
    let mut ball = sphere(Vec3::ZERO, 8.0, 64);
    ball.uvs = ball.positions.iter().map(|p| [0.5 + p.x / 16.0, 0.5 + p.z / 16.0]).collect();
    let head = Head::new("ball", ball);
    let mut mesh = straight_grid(4, 0);
    mesh.move_vertices(0, |_, p| 8.0 * ((p - Vec3::new(2.0, 0.0, 2.0)) * 0.7 + Vec3::Y * 2.0).normalize());
    mesh.extrude(&(0..16).collect::<Vec<_>>(), Weld::Neighbours, |v| 1.3 * v.position).unwrap();
    // A strip one twentieth of the ball wide.
    let density = |map| Maps::from([(MapKind::Density, Arc::new(map))]);
    let map = ScalpMap::from_fn(40, 40, |x, _| if x == 22 || x == 23 { 255 } else { 0 }).unwrap();
    let layer = Layer { maps: density(map), count: StrandCount::Total, ..layer(mesh, 3000) };
    let binding = bind_layer(&layer, Some(&head));
    assert_eq!(binding.n_strands(), 3000);
    for uv in &binding.root_uvs {
        assert!((21.5 / 40.0..24.5 / 40.0).contains(&uv[0]), "{uv:?}");
    }
    let empty = Layer { maps: density(ScalpMap::filled(1, 1, 0)), ..layer };
    assert_eq!(bind_layer(&empty, Some(&head)).n_strands(), 0);
}

/// A ball whose texture coordinates are its x and z, and a hair mesh that stands out of its top.
fn ball_with_hair() -> (Head, HairMesh) {
    let mut ball = sphere(Vec3::ZERO, 8.0, 48);
    ball.uvs = ball.positions.iter().map(|p| [0.5 + p.x / 16.0, 0.5 + p.z / 16.0]).collect();
    let head = Head::new("ball", ball);
    let mut mesh = straight_grid(4, 0);
    mesh.move_vertices(0, |_, p| 8.0 * ((p - Vec3::new(2.0, 0.0, 2.0)) * 0.7 + Vec3::Y * 2.0).normalize());
    mesh.extrude(&(0..16).collect::<Vec<_>>(), Weld::Neighbours, |v| 1.3 * v.position).unwrap();
    (head, mesh)
}

#[test]
fn every_strand_knows_what_the_maps_say_at_its_root() {
    let (head, mesh) = ball_with_hair();
    let ramp = Arc::new(ScalpMap::from_fn(128, 128, |x, _| 2 * x as u8).unwrap());
    let mut layer = layer(mesh, 500);
    layer.maps = [MapKind::Length, MapKind::Width, MapKind::Density].map(|kind| (kind, Arc::clone(&ramp))).into();
    let binding = bind_layer(&layer, Some(&head));
    assert_eq!(binding.maps, [MapKind::Length, MapKind::Width], "density is in the number of strands");
    let [length, width] = [MapKind::Length, MapKind::Width].map(|kind| binding.map_idx(&kind));
    for (strand_idx, uv) in binding.root_uvs.iter().enumerate() {
        let share = 2.0 * (128.0 * uv[0] - 0.5) / 255.0;
        assert!((binding.map_value(strand_idx, length, 1.0) - share).abs() < 1e-3, "{uv:?}");
        assert!((binding.map_value(strand_idx, width, 1.0) - share * 255.0 / 128.0).abs() < 2e-3);
        assert_eq!(binding.map_value(strand_idx, None, 0.5), 0.5);
    }
    // Other maps of the same roots are asked without binding again.
    let mut other = layer.clone();
    other.maps.insert(MapKind::Curl, Arc::new(ScalpMap::filled(4, 4, 51)));
    let mut resampled = binding;
    resampled.resample_maps(&other);
    assert_eq!(resampled, bind_layer(&other, Some(&head)));
    assert!((resampled.map_value(7, resampled.map_idx(&MapKind::Curl), 1.0) - 0.2).abs() < 1e-6);
    // Guides are tied as far as their strands say, or as the layer does where that is more.
    other.maps.insert(MapKind::Tied, Arc::new(ScalpMap::filled(4, 4, 102)));
    other.maps.insert(MapKind::Hold, Arc::new(ScalpMap::filled(4, 4, 51)));
    for (tied, expected) in [(0.0, 0.4), (0.7, 0.7)] {
        other.tied = tied;
        resampled.resample_maps(&other);
        let ties = resampled.guide_ties();
        assert_eq!(ties.len(), resampled.guides.n_guides());
        let strands_of = |guide_idx: usize| resampled.influences.iter().any(|i| i.guide_idx as usize == guide_idx);
        let is_painted = |tie: &Tie| (tie.tied - expected).abs() < 1e-5 && (tie.hold - 0.2).abs() < 1e-5;
        assert!((0..ties.len()).all(|g| is_painted(&ties[g]) || !strands_of(g)), "{ties:?}");
        assert!(resampled.strand_ties().iter().all(is_painted));
    }
}

#[test]
fn guides_and_imported_strands_make_strands_too() {
    let head = Head::new("ball", sphere(Vec3::ZERO, 8.0, 48));
    let mut guides = Strands::default();
    for i in 0..60 {
        let (sin, cos) = (i as f32 * 2.4).sin_cos();
        let r = 0.35 * (i as f32).sqrt();
        let out = Vec3::new(r * cos, 6.0, r * sin).normalize();
        guides.push(&[0, 1, 2, 3, 4].map(|k| out * (8.0 + 1.5 * k as f32) - Vec3::Y * 0.2 * (k * k) as f32));
    }
    guides.ids = (100..160).collect();
    for head in [None, Some(&head)] {
        let layer = Layer { n_strands: 2000, ..Layer::new("guides", Source::Guides(Arc::new(guides.clone()))) };
        let binding = bind_layer(&layer, head);
        assert_eq!((binding.n_strands(), binding.guides.n_guides()), (2000, 60));
        let strands = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
        for s in 0..2000 {
            let root = strands.strand(s)[0];
            assert!((root.length() - 8.0).abs() < 0.5, "{root}");
            let nearest = guides.iter().map(|g| g[0].distance(root)).fold(f32::MAX, f32::min);
            assert!(nearest < 1.5, "{nearest}");
            let length = polyline_length(strands.strand(s));
            assert!((2.5..8.0).contains(&length), "{length}");
        }
    }
    let layer = Layer { vertices_per_strand: 5, ..Layer::from_strands("strands", guides.clone()) };
    let binding = bind_layer(&layer, Some(&head));
    let strands = generate(&binding, &layer, &binding.guides.positions, &Pose::default());
    for s in 0..60 {
        let original = guides.strand(binding.ids[s] as usize - 100);
        assert!(strands.strand(s).iter().zip(original).all(|(a, b)| a.distance(*b) < 1e-4));
    }
    for source in [Source::Guides(Arc::default()), Source::Strands(Arc::default()), Source::HairMesh(Arc::default())] {
        let layer = Layer::new("nothing", source);
        let binding = bind_layer(&layer, None);
        assert_eq!(generate(&binding, &layer, &binding.guides.positions, &Pose::default()).n_strands(), 0);
    }
    let no_triangles = Head::new("empty", TriMesh::default());
    assert_eq!(bind_layer(&layer, Some(&no_triangles)).n_strands(), 60);
}

#[test]
fn another_density_chooses_among_known_places() {
    let (head, mesh) = ball_with_hair();
    let mut layer = layer(mesh, 20_000);
    let first = bind_layer(&layer, Some(&head));
    let half = ScalpMap::from_fn(512, 512, |x, _| if x < 256 { 255 } else { 120 }).unwrap();
    layer.maps = Maps::from([(MapKind::Density, Arc::new(half))]);
    let again = |known: &LayerBinding| rebind_layer(&layer, Some(&head), Some(known), Watch::default()).unwrap();
    let second = again(&first);
    let third = again(&second);
    assert_eq!(second.ids, bind_layer(&layer, Some(&head)).ids);
    assert_eq!(third, second);
    // Painting took strands away and moved none; more density brings them back.
    let before: std::collections::HashSet<u32> = first.ids.iter().copied().collect();
    assert!((12_000..18_000).contains(&second.n_strands()), "{}", second.n_strands());
    assert!(second.ids.iter().all(|id| before.contains(id)));
    // Where density says only where, it is others that stand for them; counted so, about as many.
    let total = Layer { count: StrandCount::Total, n_strands: 10_000, ..layer.clone() };
    let counted = bind_layer(&counted_where_full(&total, Some(&head)), Some(&head)).n_strands();
    assert!((counted as f32 / 10_000.0 - 1.0).abs() < 0.03, "{counted}");
}

#[test]
fn levels_of_detail_keep_the_covered_area_where_maps_are_painted_too() {
    let (head, mesh) = ball_with_hair();
    let mut layer = layer(mesh, 20_000);
    // Level 1 keeps half of what it has on one side.
    let half = ScalpMap::from_fn(64, 64, |x, _| if x < 32 { 255 } else { 128 }).unwrap();
    layer.maps.insert(MapKind::LodDensity(1), Arc::new(half));
    let binding = bind_layer(&layer, Some(&head));
    let settings = LodSettings::default();
    // Area of each side, and strands of each side that are drawn.
    let at = |level: f32| -> ([f32; 2], [usize; 2]) {
        let pose = Pose { blend: settings.blend(level), ..Pose::default() };
        let strands = generate(&binding, &layer, &binding.guides.positions, &pose);
        let (mut areas, mut counts) = ([0.0; 2], [0; 2]);
        for s in 0..strands.n_strands() {
            let side = usize::from(binding.root_uvs[s][0] > 0.5);
            let radius = strands.radii_um[strands.range(s).start];
            areas[side] += polyline_length(strands.strand(s)) * radius;
            counts[side] += usize::from(radius > 0.0);
        }
        (areas, counts)
    };
    let (full, _) = at(0.0);
    for step in 0..=30 {
        let (areas, _) = at(0.1 * step as f32);
        let ratio = (areas[0] + areas[1]) / (full[0] + full[1]);
        assert!((ratio - 1.0).abs() < 0.03, "level {}: {ratio}", 0.1 * step as f32);
    }
    let (areas, counts) = at(1.0);
    let (kept, covered) = (counts[1] as f32 / counts[0] as f32, areas[1] / areas[0] / (full[1] / full[0]));
    assert!((0.45..0.56).contains(&kept), "{counts:?}");
    assert!((covered - 1.0).abs() < 0.06, "{areas:?} of {full:?}");
}
