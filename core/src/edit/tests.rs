//! Random sequences of every edit, applied and taken back; also edits for other tests.

use proptest::prelude::*;

use super::*;
use crate::hair_mesh::{Along, FaceCut, Weld};
use crate::lod::LodChoice;
use crate::look::{Scattering, Shadowing};
use crate::maps::Tile;
use crate::maps::paint::StrokePoint;
use crate::maps::tests::any_kind;
use crate::mesh::TriMesh;
use crate::sculpt::{SculptGuide, SculptMask};
use crate::strands::Strands;
use crate::style::{Profile, StyleKind};

fn layer_named(name: &str) -> Layer {
    let mut strands = Strands::default();
    strands.push(&[Vec3::ZERO, Vec3::new(0.0, -0.1, name.len() as f32)]);
    Layer::from_strands(name, strands)
}

fn any_leaf() -> impl Strategy<Value = Edit> {
    let layer_idx = || 0_usize..5;
    prop_oneof![
        "[a-z]{0,6}".prop_map(Edit::SetName),
        any::<bool>().prop_map(|with_head| { Edit::SetHead(with_head.then(|| Head::new("head", TriMesh::default()))) }),
        (-2.0..2.0_f32, any::<bool>()).prop_map(|(exposure, kk)| {
            let scattering = if kk { Scattering::KajiyaKay } else { Scattering::Marschner };
            Edit::SetLook(Box::new(Look { exposure, scattering, shadowing: Shadowing::Off, ..Look::default() }))
        }),
        proptest::option::of(0.0..3.0_f32).prop_map(|light| {
            let panorama = |light| Panorama { width: 2, height: 1, texels: vec![light; 6], ..Panorama::default() };
            Edit::SetPanorama(light.map(|light| Arc::new(panorama(light))))
        }),
        (0.0..3.0_f32).prop_map(|level| {
            Edit::SetLod(Box::new(LodSettings { choice: LodChoice::Level(level), ..LodSettings::default() }))
        }),
        (0_usize..4).prop_map(|n| Edit::SetLights(vec![Light::directional("l", 1.0, 2.0, 3.0, [1.0; 3]); n])),
        (0.0..500.0_f32).prop_map(|wind_speed| {
            Edit::SetSimulation(Box::new(SimulationSettings { wind_speed, ..SimulationSettings::default() }))
        }),
        (0.0..3.0_f32, 0_usize..3).prop_map(|(radius, n)| Edit::SetPins(vec![Pin { radius, ..Pin::default() }; n])),
        (layer_idx(), "[a-z]{1,4}")
            .prop_map(|(layer_idx, name)| Edit::AddLayer { layer_idx, layer: Box::new(layer_named(&name)) }),
        layer_idx().prop_map(|layer_idx| Edit::RemoveLayer { layer_idx }),
        (layer_idx(), layer_idx()).prop_map(|(from, to)| Edit::MoveLayer { from, to }),
        (layer_idx(), "[a-z]{1,4}")
            .prop_map(|(layer_idx, name)| Edit::SetLayer { layer_idx, layer: Box::new(layer_named(&name)) }),
        (layer_idx(), "[a-z]{1,4}").prop_map(|(layer_idx, name)| Edit::SetLayerName { layer_idx, name }),
        (layer_idx(), any::<bool>()).prop_map(|(layer_idx, visible)| Edit::SetLayerVisible { layer_idx, visible }),
        (layer_idx(), 0.0..8.0_f32).prop_map(|(layer_idx, eumelanin)| Edit::SetMaterial {
            layer_idx,
            material: HairMaterial { eumelanin, ..HairMaterial::default() }
        }),
        (layer_idx(), 0_u32..4).prop_map(|(layer_idx, seed)| {
            let kind = StyleKind::Clump { strands_per_clump: 50.0, flare: 0.0, stray: 0.0 };
            let curve = Profile::of_ramp(seed as f32);
            let op = StyleOp { strength: 0.5, solo: seed == 2, curve, seed, ..StyleOp::new(kind) };
            Edit::SetStyle { layer_idx, style: vec![op; seed as usize] }
        }),
        (layer_idx(), any_kind(), proptest::collection::vec((0_u32..20, any::<u8>()), 0..4)).prop_map(
            |(layer_idx, kind, tiles)| {
                let change = |(tile_idx, texel)| TileChange { tile_idx, tile: Arc::new(Tile::filled(texel)) };
                Edit::PaintTiles { layer_idx, kind, tiles: tiles.into_iter().map(change).collect() }
            }
        ),
        (layer_idx(), any_kind(), -1.0..1.0_f32).prop_map(|(layer_idx, kind, x)| {
            let points = [x, x + 0.5].map(|x| StrokePoint { position: Vec3::new(x, 0.0, 0.0), pressure: 1.0 });
            let stroke = MapStroke { points: points.to_vec(), value: 0.25, ..MapStroke::default() };
            Edit::PaintStroke { layer_idx, kind, stroke }
        }),
        (layer_idx(), 0_usize..3, sculpt_changes()).prop_map(|(layer_idx, sculpt_idx, changes)| Edit::Sculpt {
            layer_idx,
            sculpt_idx,
            changes
        }),
        (layer_idx(), 0_usize..9).prop_map(|(layer_idx, n)| {
            let positions = (0..n).map(|i| Vec3::X * i as f32).collect();
            Edit::SetSculptRoots { layer_idx, roots: Arc::new(SculptRoots { positions, uvs: Vec::new() }) }
        }),
        (layer_idx(), 0_usize..3, sculpt_changes()).prop_map(|(layer_idx, sculpt_idx, changes)| {
            let mut sculpt = Box::new(SculptLayer::new("added"));
            Arc::make_mut(&mut sculpt.strokes).apply(&changes);
            Edit::AddSculpt { layer_idx, sculpt_idx, sculpt }
        }),
        (layer_idx(), 0_usize..3).prop_map(|(layer_idx, sculpt_idx)| Edit::RemoveSculpt { layer_idx, sculpt_idx }),
        (layer_idx(), 0_usize..3, 0_usize..3).prop_map(|(layer_idx, from, to)| Edit::MoveSculpt {
            layer_idx,
            from,
            to
        }),
        (layer_idx(), 0_usize..3, "[a-z]{0,4}", -1.0..2.0_f32).prop_map(|(layer_idx, sculpt_idx, name, weight)| {
            let info = SculptInfo { name, on: weight > 0.0, weight, mask: SculptMask::Inverted };
            Edit::SetSculptInfo { layer_idx, sculpt_idx, info }
        }),
        (layer_idx(), any_kind(), proptest::option::of((1_u32..300, any::<u8>()))).prop_map(
            |(layer_idx, kind, map)| {
                let map = map.map(|(side, texel)| Arc::new(ScalpMap::filled(side, 70, texel)));
                Edit::SetMap { layer_idx, kind, map }
            }
        ),
    ]
}

/// A quad with two layers above it, one vertex moved by `bend`.
fn hair_mesh_source(bend: f32) -> Source {
    let positions = vec![Vec3::ZERO, Vec3::Z, Vec3::X + Vec3::Z, Vec3::X];
    let mut mesh = HairMesh::from_polygons(positions, vec![vec![0, 1, 2, 3]]).unwrap();
    for _ in 0..2 {
        mesh.extrude(&[0], Weld::Neighbours, |v| v.position + Vec3::new(bend, 1.0, 0.0)).unwrap();
    }
    Source::HairMesh(Arc::new(mesh))
}

fn any_hair_mesh_edit() -> impl Strategy<Value = Edit> {
    let layer_idx = || 0_usize..3;
    let vertex = || (0_usize..4, 0_u32..6).prop_map(|(layer, vertex)| VertexId { layer, vertex });
    let op = prop_oneof![
        (0_usize..3, 0.5..3.0_f32).prop_map(|(bundle, length_cm)| MeshOp::Extrude {
            bundles: vec![bundle],
            along: Along::Onward,
            length_cm,
            n_layers: 1,
            weld: Weld::Neighbours
        }),
        (0_usize..3).prop_map(|bundle| MeshOp::DeleteTips { bundles: vec![bundle] }),
        (0_usize..2).prop_map(|bundle| MeshOp::DivideFace { bundle, cut: FaceCut::Corners(0, 2) }),
        (vertex(), any::<bool>()).prop_map(|(id, pinned)| MeshOp::SetPinned { vertices: vec![id], pinned }),
        vertex().prop_map(|id| MeshOp::SeparateVertices { vertices: vec![id] }),
    ];
    prop_oneof![
        (layer_idx(), 0.0..1.0_f32)
            .prop_map(|(layer_idx, bend)| Edit::SetSource { layer_idx, source: hair_mesh_source(bend) }),
        (layer_idx(), op).prop_map(|(layer_idx, op)| Edit::HairMesh { layer_idx, op }),
        (layer_idx(), proptest::collection::vec((vertex(), -2.0..2.0_f32), 0..4)).prop_map(|(layer_idx, moves)| {
            let moves = moves.into_iter().map(|(id, x)| (id, Vec3::new(x, 1.0, -x))).collect();
            Edit::MoveVertices { layer_idx, moves }
        }),
    ]
}

/// Of few guides, some of them out of range.
fn sculpt_changes() -> impl Strategy<Value = Vec<SculptChange>> {
    proptest::collection::btree_map(0_u32..10, proptest::option::of(-2.0..2.0_f32), 0..5).prop_map(|changes| {
        let guide = |x: f32| Box::new(SculptGuide { length: x, offsets: [[x; 3]; sculpt::K], ..Default::default() });
        changes.into_iter().map(|(at, x)| SculptChange { guide: at, to: x.map(guide) }).collect()
    })
}

pub(crate) fn any_edit() -> impl Strategy<Value = Edit> {
    prop_oneof![4 => any_leaf(), 2 => any_hair_mesh_edit(), 1 => proptest::collection::vec(any_leaf(), 0..4).prop_map(Edit::Batch)]
}

pub(crate) fn small_groom() -> Groom {
    let top = Layer::new("top", hair_mesh_source(0.2));
    Groom { layers: vec![layer_named("fringe"), top, layer_named("back")], ..Groom::default() }
}

proptest! {
    #[test]
    fn undoing_every_edit_gives_the_first_groom(edits in proptest::collection::vec(any_edit(), 0..40)) {
        let first = small_groom();
        let first_text = ron::to_string(&first).unwrap();
        let mut groom = first.clone();
        let mut inverses = Vec::new();
        for edit in edits {
            let before = groom.clone();
            if let Ok(inverse) = groom.apply(edit) {
                inverses.push(inverse);
            } else {
                prop_assert_eq!(&groom, &before, "a refused edit changes nothing");
            }
        }
        for inverse in inverses.into_iter().rev() {
            groom.apply(inverse).unwrap();
        }
        prop_assert_eq!(&groom, &first);
        prop_assert_eq!(ron::to_string(&groom).unwrap(), first_text);
    }
}

#[test]
fn layers_that_share_a_hair_mesh_go_on_sharing_it() {
    let mut groom = small_groom();
    let mut frizz = groom.layers[1].clone();
    frizz.name = "frizz".to_owned();
    groom.layers.push(frizz);
    let before = groom.clone();
    let mesh_of = |groom: &Groom, layer_idx: usize| match &groom.layers[layer_idx].source {
        Source::HairMesh(mesh) => Arc::clone(mesh),
        Source::Guides(_) | Source::Strands(_) => panic!("made of a hair mesh"),
    };
    let id = VertexId { layer: 1, vertex: 0 };
    let moves = vec![(id, Vec3::new(1.0, 2.0, 3.0))];
    let mut undo = vec![groom.apply(Edit::MoveVertices { layer_idx: 3, moves }).unwrap()];
    assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)));
    assert_eq!(mesh_of(&groom, 1).position(id), Some(Vec3::new(1.0, 2.0, 3.0)));
    undo.push(groom.apply(Edit::HairMesh { layer_idx: 1, op: MeshOp::DeleteTips { bundles: vec![0] } }).unwrap());
    assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)));
    for edit in undo.into_iter().rev() {
        groom.apply(edit).unwrap();
    }
    assert_eq!(groom, before);
    assert!(Arc::ptr_eq(&mesh_of(&groom, 1), &mesh_of(&groom, 3)), "undo keeps them together");
}

#[test]
fn a_batch_that_fails_in_the_middle_changes_nothing() {
    let mut groom = small_groom();
    let before = groom.clone();
    let batch = Edit::Batch(vec![Edit::SetName("other".into()), Edit::RemoveLayer { layer_idx: 9 }]);
    assert_eq!(groom.apply(batch), Err(EditError::NoSuchLayer { layer_idx: 9, n_layers: 3 }));
    assert_eq!(groom, before);
}

#[test]
fn a_picture_of_the_environment_that_is_none_is_refused() {
    let mut groom = small_groom();
    let before = groom.clone();
    for (width, height, texels, why) in [
        (2, 1, vec![0.5; 3], "3 numbers are no picture of 2 x 1"),
        (u32::MAX, u32::MAX, vec![0.5; 3], "3 numbers are no picture"),
        (0, 0, Vec::new(), "0 numbers are no picture of 0 x 0"),
        (1, 1, vec![1.0, f32::NAN, 1.0], "NaN is no amount of light"),
        (1, 1, vec![1.0, -2.0, 1.0], "-2 is no amount of light"),
    ] {
        let panorama = Panorama { width, height, texels, ..Panorama::default() };
        let refused = groom.apply(Edit::SetPanorama(Some(Arc::new(panorama)))).unwrap_err().to_string();
        assert!(refused.contains(why), "{refused}");
        assert_eq!(groom, before);
    }
}
