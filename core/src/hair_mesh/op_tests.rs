//! What the operations promise, one by one and in random sequences.

use std::collections::BTreeMap;

use glam::Vec3;
use proptest::prelude::*;

use super::symmetry::Side;
use super::{
    Along, EdgeId, FaceCut, HairMesh, HairMeshError as E, HairMeshLayer, MeshOp, Report, Scheme, VertexId, Weld,
};

/// As the other tests' grid, but vertex `x + (n + 1) z` is at (x, k, z) in every layer `k`.
pub(super) fn straight_grid(n: u32, n_layers: usize) -> HairMesh {
    let root = &super::tests::straight_grid(n, 0).layers[0];
    let layer = |k: usize| HairMeshLayer {
        positions: root.positions.iter().map(|p| p + Vec3::Y * k as f32).collect(),
        ..root.clone()
    };
    HairMesh { layers: (0..=n_layers).map(layer).collect() }
}

fn id(layer: usize, vertex: u32) -> VertexId {
    VertexId { layer, vertex }
}

/// The vertices of a layer that a report says are copies of others, with those.
fn with_copies(report: &Report, layer: usize) -> Vec<VertexId> {
    let copies = report.new_vertices.iter().filter(|new| new.id.layer == layer);
    copies.flat_map(|new| [Some(new.id), new.copy_of.and_then(|was| report.now(was))]).flatten().collect()
}

/// Positions of every bundle's corners, layer by layer: what a hair mesh is, whatever its vertices are
/// called.
fn corners(mesh: &HairMesh) -> Vec<Vec<Vec<Vec3>>> {
    let of_bundle = |bundle: usize| {
        let faces = mesh.layers.iter().filter_map(move |layer| Some((layer, layer.faces[bundle].as_ref()?)));
        faces.map(|(layer, face)| face.iter().map(|&v| layer.positions[v as usize]).collect()).collect()
    };
    (0..mesh.n_bundles()).map(of_bundle).collect()
}

/// Equal up to the numbers of vertices: the same corners share a vertex, at the same places.
fn same_up_to_numbers(a: &HairMesh, b: &HairMesh) -> bool {
    corners(a) == corners(b)
        && a.layers.iter().zip(&b.layers).all(|(a, b)| {
            let pairs =
                a.faces.iter().zip(&b.faces).flat_map(|(a, b)| {
                    a.iter().flatten().copied().zip(b.iter().flatten().copied()).collect::<Vec<_>>()
                });
            let (mut there, mut back) = (BTreeMap::new(), BTreeMap::new());
            pairs.into_iter().all(|(a, b)| *there.entry(a).or_insert(b) == b && *back.entry(b).or_insert(a) == a)
        })
}

#[test]
fn extruding_and_deleting_tips_are_inverses() {
    let before = straight_grid(3, 2);
    for weld in [Weld::Neighbours, Weld::Apart] {
        let mut mesh = before.clone();
        let op = MeshOp::Extrude { bundles: vec![4, 1, 0], along: Along::Normal, length_cm: 2.0, n_layers: 1, weld };
        let report = mesh.apply(&op).unwrap();
        assert_eq!(report.new_vertices.len(), 8);
        assert!(report.new_vertices.iter().all(|new| new.copy_of.is_some_and(|was| was.layer == 2)));
        assert!(mesh.layers[3].positions.iter().all(|p| (p.y - 4.0).abs() < 1e-6));
        mesh.apply(&MeshOp::DeleteTips { bundles: vec![0, 1, 4] }).unwrap();
        assert_eq!(mesh, before);
    }
    let mut mesh = before.clone();
    mesh.apply(&MeshOp::DeleteTips { bundles: vec![4] }).unwrap();
    let op =
        MeshOp::Extrude { bundles: vec![4], along: Along::Onward, length_cm: 1.0, n_layers: 1, weld: Weld::Neighbours };
    mesh.apply(&op).unwrap();
    assert!(same_up_to_numbers(&mesh, &before), "the face closes the hole again");
}

#[test]
fn extruding_follows_gravity_directions_and_curves() {
    let extruded = |along: Along| {
        let mut mesh = straight_grid(1, 1);
        mesh.apply(&MeshOp::Extrude { bundles: vec![0], along, length_cm: 6.0, n_layers: 3, weld: Weld::Apart })
            .unwrap();
        assert_eq!(mesh.layers.len(), 5);
        mesh.layers[4].positions.clone()
    };
    let tip = |positions: &[Vec3]| positions.iter().sum::<Vec3>() / 4.0;
    assert!(tip(&extruded(Along::Gravity { pull: 1.0 })).distance(Vec3::new(0.5, -5.0, 0.5)) < 1e-5);
    assert!(tip(&extruded(Along::Gravity { pull: 0.0 })).distance(Vec3::new(0.5, 7.0, 0.5)) < 1e-5);
    assert!(tip(&extruded(Along::Direction(Vec3::X * 9.0))).distance(Vec3::new(6.5, 1.0, 0.5)) < 1e-5);
    // A quarter of a circle turns the face with it.
    let arc = (0..=8).map(|k| {
        let (sin, cos) = (k as f32 / 8.0 * std::f32::consts::FRAC_PI_2).sin_cos();
        Vec3::new(1.0 - cos, sin, 0.0)
    });
    let positions = extruded(Along::Curve(arc.collect()));
    let normal = (positions[1] - positions[0]).cross(positions[2] - positions[0]).normalize();
    assert!(normal.x > 0.7, "{normal}");
    let mut mesh = straight_grid(1, 1);
    let along = Along::Curve(vec![Vec3::X; 3]);
    let op = MeshOp::Extrude { bundles: vec![0], along, length_cm: 6.0, n_layers: 3, weld: Weld::Apart };
    assert_eq!(mesh.apply(&op), Err(E::NoDirection { what: "the curve" }));
}

#[test]
fn a_bundle_joins_the_side_of_a_parting_that_it_shares_an_edge_with() {
    let mut mesh = straight_grid(2, 0);
    mesh.extrude(&[0], Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
    mesh.extrude(&[3], Weld::Apart, |v| v.position + 2.0 * Vec3::Y).unwrap();
    // Bundle 2 touches bundle 0 and bundle 3 along an edge each, and both own a copy of the middle.
    mesh.extrude(&[2], Weld::Neighbours, |v| v.position + 3.0 * Vec3::Y).unwrap();
    mesh.check().unwrap();
    let shared = |a: usize, b: usize| {
        let face = mesh.face(1, a).unwrap();
        mesh.face(1, b).unwrap().iter().filter(|v| face.contains(v)).count()
    };
    assert_eq!((shared(0, 2) + shared(3, 2), shared(0, 3)), (3, 0));
}

#[test]
fn inserting_and_removing_a_layer_are_inverses() {
    let mut before = straight_grid(3, 3);
    before.apply(&MeshOp::SeparateVertices { vertices: vec![id(2, 5)] }).unwrap();
    for layer in 1..=3 {
        let mut mesh = before.clone();
        let report = mesh.apply(&MeshOp::InsertLayer { bundles: vec![2], layer, at: 0.25 }).unwrap();
        assert_eq!((mesh.layers.len(), mesh.layers[layer].positions.len()), (5, before.layers[layer].positions.len()));
        assert!(mesh.layers[layer].positions.iter().all(|p| (p.y - (layer as f32 - 0.75)).abs() < 1e-5));
        assert_eq!(report.now(id(layer, 3)), Some(id(layer + 1, 3)));
        mesh.apply(&MeshOp::RemoveLayer { bundles: vec![7], layer }).unwrap();
        assert_eq!(mesh, before);
    }
    let mut mesh = before.clone();
    assert!(matches!(mesh.apply(&MeshOp::RemoveLayer { bundles: vec![2], layer: 0 }), Err(E::RootLayer { .. })));
    assert!(matches!(mesh.apply(&MeshOp::InsertLayer { bundles: vec![2], layer: 4, at: 0.5 }), Err(E::NoLayer { .. })));
    assert_eq!(mesh, before);
}

#[test]
fn a_layer_is_inserted_and_removed_only_where_faces_are_connected() {
    let mut mesh = straight_grid(2, 0);
    mesh.extrude(&[0, 2], Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
    mesh.extrude(&[1, 3], Weld::Apart, |v| v.position + Vec3::Y).unwrap();
    mesh.extrude(&[1, 3], Weld::Neighbours, |v| v.position + Vec3::Y).unwrap();
    let before = mesh.clone();
    mesh.apply(&MeshOp::InsertLayer { bundles: vec![3], layer: 1, at: 0.5 }).unwrap();
    assert_eq!([0, 1, 2, 3].map(|bundle| mesh.tip_layer(bundle)), [1, 3, 1, 3].map(Some));
    mesh.apply(&MeshOp::RemoveLayer { bundles: vec![1], layer: 1 }).unwrap();
    assert!(same_up_to_numbers(&mesh, &before));
    mesh.apply(&MeshOp::RemoveLayer { bundles: vec![1], layer: 1 }).unwrap();
    assert_eq!([0, 1, 2, 3].map(|bundle| mesh.tip_layer(bundle)), [1; 4].map(Some));
}

#[test]
fn separating_opens_the_layers_above_and_welding_closes_those_below() {
    let before = straight_grid(3, 4);
    let mut mesh = before.clone();
    let report = mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(2, 5)] }).unwrap();
    // Four faces meet there: three copies in layers 2, 3 and 4.
    let n_new: Vec<usize> = (0..5).map(|k| mesh.layers[k].positions.len() - before.layers[k].positions.len()).collect();
    assert_eq!((n_new, report.new_vertices.len()), (vec![0, 0, 3, 3, 3], 9));
    assert_eq!(corners(&mesh), corners(&before), "nothing moves");
    // Welding the tips welds all of them, down to layer 2.
    mesh.apply(&MeshOp::WeldVertices { vertices: with_copies(&report, 4) }).unwrap();
    assert!(same_up_to_numbers(&mesh, &before));
    assert_eq!(
        mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(1, 0)] }),
        Err(E::VertexOfOneFace { layer: 1, vertex: 0 })
    );
    assert!(matches!(mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(0, 5)] }), Err(E::RootLayer { .. })));
    assert!(matches!(mesh.apply(&MeshOp::SeparateVertices { vertices: vec![] }), Err(E::NothingSelected { .. })));
    let twins = vec![id(2, 4), id(2, 5), id(3, 5)];
    assert_eq!(mesh.apply(&MeshOp::WeldVertices { vertices: twins }), Err(E::NoTwinVertex { layer: 2, vertex: 4 }));
}

#[test]
fn a_line_of_edges_opens_a_parting_and_a_single_inner_edge_is_refused() {
    let before = straight_grid(4, 2);
    let mut mesh = before.clone();
    assert_eq!(
        mesh.apply(&MeshOp::SeparateEdges { edges: vec![EdgeId::new(1, 12, 11)] }),
        Err(E::EdgeStaysClosed { layer: 1, a: 11, b: 12 })
    );
    assert_eq!(
        mesh.apply(&MeshOp::SeparateEdges { edges: vec![EdgeId::new(1, 0, 1)] }),
        Err(E::EdgeOfOneFace { layer: 1, a: 0, b: 1 })
    );
    // From the border inwards: the border's vertex and the next one open, the last holds.
    let edges = vec![EdgeId::new(1, 10, 11), EdgeId::new(1, 11, 12)];
    let report = mesh.apply(&MeshOp::SeparateEdges { edges }).unwrap();
    assert_eq!(report.new_vertices.len(), 4);
    assert_eq!(mesh.layers[1].positions.len(), before.layers[1].positions.len() + 2);
    let now = |was: VertexId| report.now(was).unwrap().vertex;
    let copy = |was: VertexId| report.new_vertices.iter().find(|new| new.copy_of == Some(was)).unwrap().id.vertex;
    let (a, b, end) = (id(2, 10), id(2, 11), now(id(2, 12)));
    let both_sides = vec![
        EdgeId::new(2, now(a), now(b)),
        EdgeId::new(2, copy(a), copy(b)),
        EdgeId::new(2, now(b), end),
        EdgeId::new(2, copy(b), end),
    ];
    assert_eq!(
        mesh.apply(&MeshOp::WeldEdges { edges: vec![both_sides[0], both_sides[2]] }),
        Err(E::NoTwinEdge { layer: 2, a: 10, b: 11 })
    );
    mesh.apply(&MeshOp::WeldEdges { edges: both_sides }).unwrap();
    assert!(same_up_to_numbers(&mesh, &before));
}

#[test]
fn welded_vertices_lie_in_the_middle_of_those_they_were() {
    let mut mesh = straight_grid(2, 1);
    let report = mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(1, 4)] }).unwrap();
    let twins = with_copies(&report, 1);
    for (i, new) in report.new_vertices.iter().enumerate() {
        mesh.layers[1].positions[new.id.vertex as usize] += Vec3::X * (i + 1) as f32;
    }
    let report = mesh.apply(&MeshOp::WeldVertices { vertices: twins }).unwrap();
    assert_eq!(mesh.layers[1].positions[4], Vec3::new(1.0 + 1.5, 1.0, 1.0));
    assert_eq!(report.now(id(1, 11)), Some(id(1, 4)), "what was welded away is told where it went");
}

#[test]
fn dividing_a_face_divides_its_bundle() {
    let mut mesh = straight_grid(2, 2);
    let report = mesh.apply(&MeshOp::DivideFace { bundle: 1, cut: FaceCut::Corners(3, 1) }).unwrap();
    assert_eq!(report.new_bundles, [4]);
    assert!([1, 4].iter().all(|&b| mesh.face(2, b).unwrap().len() == 3 && mesh.tip_layer(b) == Some(2)));
    let refused = mesh.apply(&MeshOp::DivideFace { bundle: 0, cut: FaceCut::Corners(1, 2) });
    assert_eq!(refused, Err(E::CornersDoNotDivide { bundle: 0, a: 1, b: 2, n_corners: 4 }));
    let report = mesh.apply(&MeshOp::DivideFace { bundle: 0, cut: FaceCut::Fan }).unwrap();
    assert_eq!((report.new_bundles.len(), report.new_vertices.len()), (3, 3));
    let report = mesh.apply(&MeshOp::DivideFace { bundle: 3, cut: FaceCut::Quads }).unwrap();
    assert_eq!((report.new_bundles.len(), report.new_vertices.len()), (3, 15));
    // Its neighbours across the edge have five corners now (one of them was a triangle).
    assert_eq!([2, 1].map(|b| mesh.face(1, b).unwrap().len()), [5, 4]);
}

#[test]
fn an_edge_is_divided_on_both_sides_of_a_parting() {
    let mut mesh = straight_grid(2, 2);
    mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(2, 4)] }).unwrap();
    mesh.apply(&MeshOp::DivideEdge { edge: EdgeId::new(1, 1, 4), at: 0.25 }).unwrap();
    let n_at = |layer: usize| {
        let place = Vec3::new(1.0, layer as f32, 0.25);
        mesh.layers[layer].positions.iter().filter(|p| p.distance(place) < 1e-6).count()
    };
    // One vertex where the two faces share the edge, two above where they do not.
    assert_eq!([n_at(0), n_at(1), n_at(2)], [1, 1, 2]);
    assert_eq!([0, 1, 2].map(|b| mesh.face(2, b).unwrap().len()), [5, 5, 4]);
}

#[test]
fn subdivision_fits_neighbours_and_keeps_the_root_on_the_scalp() {
    let grid = straight_grid(3, 2);
    for scheme in [Scheme::CatmullClark, Scheme::Linear] {
        let mut mesh = grid.clone();
        mesh.apply(&MeshOp::Subdivide { bundles: vec![], scheme }).unwrap();
        assert_eq!((mesh.n_bundles(), mesh.layers[1].positions.len()), (36, 49));
        assert!(grid.layers[0].positions.iter().all(|p| mesh.layers[0].positions.contains(p)));
        let mut mesh = grid.clone();
        mesh.apply(&MeshOp::Subdivide { bundles: vec![4], scheme }).unwrap();
        assert_eq!([0, 1, 3, 5, 7].map(|b| mesh.face(2, b).unwrap().len()), [4, 5, 5, 5, 5]);
        assert!(grid.layers[1].positions.iter().all(|p| mesh.layers[1].positions.contains(p)), "the edge holds still");
    }
    let mut mesh = grid.clone();
    let refused = mesh.apply(&MeshOp::Subdivide { bundles: vec![4], scheme: Scheme::Loop });
    assert_eq!(refused, Err(E::NotTriangle { bundle: 4, n_corners: 4 }));
    for bundle in 0..9 {
        mesh.apply(&MeshOp::DivideFace { bundle, cut: FaceCut::Corners(0, 2) }).unwrap();
    }
    mesh.apply(&MeshOp::Subdivide { bundles: vec![], scheme: Scheme::Loop }).unwrap();
    assert_eq!((mesh.n_bundles(), mesh.layers[1].positions.len()), (72, 49));
}

/// The limit rules on a cube's layer, by hand (Catmull and Clark 1978; Loop 1987).
#[test]
fn smooth_schemes_follow_their_rules_around_an_inner_vertex() {
    let raised = |scheme: Scheme, n: u32| {
        let mut mesh = straight_grid(n, 1);
        if scheme == Scheme::Loop {
            for bundle in 0..(n * n) as usize {
                mesh.apply(&MeshOp::DivideFace { bundle, cut: FaceCut::Corners(0, 2) }).unwrap();
            }
        }
        mesh.layers[1].positions[4].y += 1.0;
        mesh.apply(&MeshOp::Subdivide { bundles: vec![], scheme }).unwrap();
        mesh.layers[1].positions[4].y - 1.0
    };
    // F = 1/4, R = 1/2, (F + 2 R + P) / 4 of a raised middle.
    assert!((raised(Scheme::CatmullClark, 2) - (0.25 + 1.0 + 1.0) / 4.0).abs() < 1e-6);
    // Valence 6: 1 - 6 * 3/48.
    assert!((raised(Scheme::Loop, 2) - 0.625).abs() < 1e-6);
}

#[test]
fn pinned_vertices_stay_when_the_inside_is_relaxed() {
    let mut mesh = straight_grid(4, 4);
    mesh.layers[2].positions[12] += Vec3::X * 0.4;
    mesh.layers[2].positions[6] += Vec3::X * 0.4;
    mesh.apply(&MeshOp::SetPinned { vertices: vec![id(2, 12)], pinned: true }).unwrap();
    assert!(mesh.is_pinned(id(2, 12)) && !mesh.is_pinned(id(2, 6)));
    let before = mesh.clone();
    mesh.apply(&MeshOp::Relax).unwrap();
    assert_eq!(mesh.layers[2].positions[12], before.layers[2].positions[12]);
    assert_ne!(mesh.layers[2].positions[6], before.layers[2].positions[6]);
    mesh.apply(&MeshOp::DeleteBundles { bundles: vec![0] }).unwrap();
    assert!(mesh.is_pinned(id(2, 11)), "a pin moves with its vertex");
    assert!(mesh.apply(&MeshOp::SetPinned { vertices: vec![id(2, 99)], pinned: true }).is_err());
}

#[test]
fn smoothing_flattens_a_spike_and_leaves_the_root() {
    let mut mesh = straight_grid(4, 3);
    mesh.layers[2].positions[12] += Vec3::X;
    mesh.layers[0].positions[12] += Vec3::Y * 0.1;
    let vertices = vec![id(2, 12), id(0, 12)];
    mesh.apply(&MeshOp::SmoothVertices { vertices, strength: 0.5, n_times: 1 }).unwrap();
    assert!((mesh.layers[2].positions[12].x - 2.5).abs() < 1e-6);
    assert_eq!(mesh.layers[0].positions[12].y, 0.1);
}

/// An operation of any kind on places that are often there.
fn any_op() -> impl Strategy<Value = MeshOp> {
    let bundles = || prop::collection::vec(0_usize..14, 1..5);
    let vertices = || prop::collection::vec((0_usize..4, 0_u32..20).prop_map(|(k, v)| id(k, v)), 1..6);
    let edge = || (0_usize..4, 0_u32..20, 0_u32..20).prop_map(|(k, a, b)| EdgeId::new(k, a, b));
    let along = prop_oneof![
        Just(Along::Normal),
        Just(Along::Onward),
        (0.0..1.0_f32).prop_map(|pull| Along::Gravity { pull }),
        Just(Along::Direction(Vec3::new(1.0, 2.0, 0.5))),
        Just(Along::Curve(vec![Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 2.0, 0.0)])),
    ];
    let weld = prop_oneof![Just(Weld::Neighbours), Just(Weld::Apart)];
    let scheme = prop_oneof![Just(Scheme::CatmullClark), Just(Scheme::Loop), Just(Scheme::Linear)];
    let cut = prop_oneof![
        (0_usize..5, 0_usize..5).prop_map(|(a, b)| FaceCut::Corners(a, b)),
        Just(FaceCut::Fan),
        Just(FaceCut::Quads)
    ];
    prop_oneof![
        4 => (bundles(), along, 0.5..3.0_f32, 1_u32..3, weld).prop_map(|(bundles, along, length_cm, n_layers, weld)| {
            MeshOp::Extrude { bundles, along, length_cm, n_layers, weld }
        }),
        1 => bundles().prop_map(|bundles| MeshOp::DeleteTips { bundles }),
        1 => (0_usize..14).prop_map(|bundle| MeshOp::DeleteBundles { bundles: vec![bundle] }),
        2 => (bundles(), 0_usize..4, 0.1..0.9_f32)
            .prop_map(|(bundles, layer, at)| MeshOp::InsertLayer { bundles, layer, at }),
        1 => (bundles(), 0_usize..4).prop_map(|(bundles, layer)| MeshOp::RemoveLayer { bundles, layer }),
        3 => vertices().prop_map(|vertices| MeshOp::SeparateVertices { vertices }),
        3 => prop::collection::vec(edge(), 1..4).prop_map(|edges| MeshOp::SeparateEdges { edges }),
        2 => vertices().prop_map(|vertices| MeshOp::WeldVertices { vertices }),
        2 => prop::collection::vec(edge(), 1..6).prop_map(|edges| MeshOp::WeldEdges { edges }),
        2 => (0_usize..14, cut).prop_map(|(bundle, cut)| MeshOp::DivideFace { bundle, cut }),
        2 => (edge(), 0.1..0.9_f32).prop_map(|(edge, at)| MeshOp::DivideEdge { edge, at }),
        1 => (bundles(), scheme).prop_map(|(bundles, scheme)| MeshOp::Subdivide { bundles, scheme }),
        1 => (vertices(), any::<bool>()).prop_map(|(vertices, pinned)| MeshOp::SetPinned { vertices, pinned }),
        1 => Just(MeshOp::Relax),
        1 => any::<bool>().prop_map(|left| {
            MeshOp::Mirror { from: if left { Side::PlusX } else { Side::MinusX }, tolerance_cm: 0.2 }
        }),
        1 => (vertices(), 0.0..1.0_f32)
            .prop_map(|(vertices, strength)| MeshOp::SmoothVertices { vertices, strength, n_times: 2 }),
    ]
}

/// An edge that is there, so that random operations on edges are often possible: the `n`th of them all.
fn edge_of(mesh: &HairMesh, n: usize) -> Option<EdgeId> {
    let all: Vec<EdgeId> = mesh
        .layers
        .iter()
        .enumerate()
        .flat_map(|(k, layer)| layer.faces.iter().flatten().map(move |face| (k, face)))
        .flat_map(|(k, face)| (0..face.len()).map(move |i| EdgeId::new(k, face[i], face[(i + 1) % face.len()])))
        .collect();
    (!all.is_empty()).then(|| all[n % all.len()])
}

/// Edges and vertices of an operation, replaced by some that the mesh has.
fn aimed(mesh: &HairMesh, op: MeshOp) -> MeshOp {
    let aim = |edge: EdgeId| edge_of(mesh, edge.ends[0] as usize * 31 + edge.ends[1] as usize).unwrap_or(edge);
    match op {
        MeshOp::SeparateEdges { edges } => MeshOp::SeparateEdges { edges: edges.into_iter().map(aim).collect() },
        MeshOp::WeldEdges { edges } => {
            // All edges of the layer: those with twins are welded.
            let layer = edges[0].layer;
            let all = (0..400).filter_map(|n| edge_of(mesh, n)).filter(|edge| edge.layer == layer);
            MeshOp::WeldEdges { edges: all.collect() }
        }
        MeshOp::WeldVertices { vertices } => {
            let layer = vertices[0].layer;
            let n = mesh.layers.get(layer).map_or(0, |layer| layer.positions.len() as u32);
            MeshOp::WeldVertices { vertices: (0..n).map(|v| id(layer, v)).collect() }
        }
        MeshOp::DivideEdge { edge, at } => MeshOp::DivideEdge { edge: aim(edge), at },
        other => other,
    }
}

/// Pairs of bundles that share a vertex in a layer.
fn touching(mesh: &HairMesh, layer: usize) -> Vec<(usize, usize)> {
    let n = mesh.n_bundles();
    let pairs = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
    let touch = |&(a, b): &(usize, usize)| match (mesh.face(layer, a), mesh.face(layer, b)) {
        (Some(a), Some(b)) => a.iter().any(|v| b.contains(v)),
        _ => false,
    };
    pairs.filter(touch).collect()
}

proptest! {
    #[test]
    fn every_operation_keeps_the_invariants_or_changes_nothing(ops in prop::collection::vec(any_op(), 1..14)) {
        let mut mesh = straight_grid(3, 1);
        for layer in 0..2 {
            // Now the middle of a column of faces lies on X = 0.
            mesh.move_vertices(layer, |_, p| p - 1.5 * Vec3::X);
        }
        for op in ops {
            let before = mesh.clone();
            let op = aimed(&mesh, op);
            let Ok(report) = mesh.apply(&op) else {
                prop_assert_eq!(&mesh, &before, "refused: {:?}", op);
                continue;
            };
            mesh.check().unwrap();
            // What the paper promises of one-to-many vertices: neighbours are neighbours at the root.
            let at_root = touching(&mesh, 0);
            for layer in 1..mesh.layers.len() {
                prop_assert!(touching(&mesh, layer).iter().all(|pair| at_root.contains(pair)));
                prop_assert!(!mesh.layers[layer].faces.iter().all(Option::is_none));
            }
            // The report tells every vertex once.
            let mut told: Vec<VertexId> = report.new_vertices.iter().map(|new| new.id).collect();
            let mut kept: Vec<VertexId> = report.renumbered.iter().flatten().copied().flatten().collect();
            kept.sort_unstable();
            kept.dedup();
            told.extend(kept);
            told.sort_unstable();
            let n_of = |k: usize| mesh.layers[k].positions.len() as u32;
            let all = (0..mesh.layers.len()).flat_map(|k| (0..n_of(k)).map(move |v| id(k, v)));
            prop_assert_eq!(told, all.collect::<Vec<_>>(), "{:?}", op);
            // Data that replays: the same operation, written and read, does the same.
            let mut again = before;
            let read: MeshOp = ron::from_str(&ron::to_string(&op).unwrap()).unwrap();
            again.apply(&read).unwrap();
            prop_assert_eq!(&again, &mesh);
        }
    }

    #[test]
    fn inverse_operations_undo_each_other_on_any_hair_mesh(
        ops in prop::collection::vec(any_op(), 0..8), bundle in 0_usize..14, layer in 1_usize..5, vertex in 0_u32..30,
    ) {
        let mut before = straight_grid(3, 1);
        for op in ops {
            let op = aimed(&before, op);
            drop(before.apply(&op));
        }
        let mut mesh = before.clone();
        let op = MeshOp::Extrude {
            bundles: vec![bundle], along: Along::Onward, length_cm: 1.0, n_layers: 1, weld: Weld::Neighbours,
        };
        if mesh.apply(&op).is_ok() {
            mesh.apply(&MeshOp::DeleteTips { bundles: vec![bundle] }).unwrap();
            prop_assert_eq!(&mesh, &before);
        }
        if mesh.apply(&MeshOp::InsertLayer { bundles: vec![bundle], layer, at: 0.5 }).is_ok() {
            mesh.apply(&MeshOp::RemoveLayer { bundles: vec![bundle], layer }).unwrap();
            prop_assert!(same_up_to_numbers(&mesh, &before));
        }
        let mut mesh = before.clone();
        if let Ok(report) = mesh.apply(&MeshOp::SeparateVertices { vertices: vec![id(layer, vertex)] }) {
            // Each vertex's copies are welded by themselves: others may stand on the same root vertex. A vertex
            // in a higher layer may have had several from the start, so from the top down.
            let mut olds: Vec<VertexId> = report.new_vertices.iter().filter_map(|new| new.copy_of).collect();
            olds.sort_unstable();
            olds.dedup();
            let mut now: BTreeMap<VertexId, Vec<VertexId>> = BTreeMap::new();
            for old in olds {
                let copies = report.new_vertices.iter().filter(|new| new.copy_of == Some(old)).map(|new| new.id);
                now.insert(old, copies.chain(report.now(old)).collect());
            }
            while let Some((_, vertices)) = now.pop_last() {
                let mut unique = vertices.clone();
                unique.sort_unstable();
                unique.dedup();
                if unique.len() > 1 {
                    let report = mesh.apply(&MeshOp::WeldVertices { vertices: unique }).unwrap();
                    for id in now.values_mut().flatten() {
                        *id = report.now(*id).unwrap();
                    }
                }
            }
            prop_assert!(same_up_to_numbers(&mesh, &before));
        }
    }
}
