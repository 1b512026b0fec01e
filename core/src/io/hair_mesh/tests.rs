//! Hair meshes as other programs write them come in with what they are made of, and what goes out comes back the same.

use std::fmt::Write as _;
use std::path::Path;

use glam::Vec3;

use super::*;
use crate::hair_mesh::{EdgeId, FaceCut, MeshOp, VertexId, Weld};
use crate::mesh_query::tests::sphere;

fn read(name: &str, text: &str, head: Option<&TriMesh>) -> Result<HairMeshImport, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    read_hair_mesh(&path, head, ImportOptions::default(), Watch::default())
}

/// A hair mesh with a parting, bundles of different heights, a deleted one, n-gons and pins.
fn odd_mesh() -> HairMesh {
    let mut mesh = crate::hair_mesh::tests::straight_grid(3, 3);
    mesh.move_vertices(1, |v, p| p + Vec3::new(0.1, 0.3333, 1e-7) * v as f32);
    for op in [
        MeshOp::DeleteTips { bundles: vec![0, 4] },
        MeshOp::DeleteBundles { bundles: vec![8] },
        MeshOp::DivideEdge { edge: EdgeId::new(0, 5, 9), at: 0.3 },
        MeshOp::DivideFace { bundle: 3, cut: FaceCut::Fan },
        MeshOp::SeparateVertices { vertices: vec![VertexId { layer: 2, vertex: 3 }] },
        MeshOp::SetPinned { vertices: vec![VertexId { layer: 1, vertex: 2 }], pinned: true },
    ] {
        drop(mesh.apply(&op));
    }
    assert!(mesh.layers[1].pinned == [2] && mesh.n_bundles() > 9);
    mesh
}

#[test]
fn what_is_written_is_read_back_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in [odd_mesh(), crate::hair_mesh::tests::straight_grid(2, 0)] {
        for name in ["hair.obj", "hair.glb"] {
            let path = folder.path().join(name);
            write_hair_mesh(&path, &mesh).unwrap();
            let import = read_hair_mesh(&path, None, ImportOptions::default(), Watch::default()).unwrap();
            assert_eq!(import.mesh, mesh, "{name}");
            assert!(import.found[0].contains("as Lorelei writes it"), "{:?}", import.found);
        }
    }
    // Other programs see metres and one mesh a layer.
    let mesh = super::super::read_mesh(&folder.path().join("hair.glb"), Watch::default()).unwrap();
    assert_eq!(mesh.mesh.triangles.len(), 8);
    assert!(mesh.mesh.bounds().unwrap().1.max_element() < 0.1);
    let error = write_hair_mesh(Path::new("hair.ply"), &odd_mesh()).unwrap_err().to_string();
    assert!(error.contains(".obj or .glb"), "{error}");
}

/// Two quads side by side as parts of one name each, one centimetre above each other, on a head of 9 cm.
fn two_quads(names: [&str; 3], n_on_top: usize) -> String {
    let mut text = String::new();
    for (k, name) in names.iter().enumerate() {
        let _ = writeln!(text, "o {name}");
        for (x, z) in [(-1, 0), (0, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            let _ = writeln!(text, "v {x} {} {z}", 9.0 + k as f32);
        }
        let first = 6 * k + 1;
        let quads = [[0, 3, 4, 1], [1, 4, 5, 2]];
        for quad in &quads[if k == 2 { 2 - n_on_top } else { 0 }..] {
            let _ = writeln!(text, "f {}", quad.map(|v| (v + first).to_string()).join(" "));
        }
    }
    text
}

fn head() -> TriMesh {
    sphere(Vec3::ZERO, 9.0, 48)
}

#[test]
fn layers_are_found_by_their_names() {
    let text = two_quads(["Hair.Layer-1", "Hair.Layer-2", "Hair.Layer-3"], 1);
    let import = read("a.obj", &text, Some(&head())).unwrap();
    assert_eq!((import.mesh.layers.len(), import.mesh.n_bundles()), (3, 2));
    // The last layer has one face: it stands on the nearest.
    assert_eq!((import.mesh.tip_layer(0), import.mesh.tip_layer(1)), (Some(1), Some(2)));
    assert!(import.found[0].contains("3 layers by their names"), "{:?}", import.found);
    assert_eq!(import.space.unit, Unit::Centimetre);
    let wrong = two_quads(["layer_0", "layer_1", "layer_2"], 2) + "f 13 14 15\n";
    let error = read("a.obj", &wrong, Some(&head())).unwrap_err().to_string();
    assert!(error.contains("3 faces and `layer_1` below it only 2"), "{error}");
}

#[test]
fn alike_parts_are_layers_and_the_one_on_the_head_is_the_root() {
    let import = read("a.obj", &two_quads(["roots", "middle", "tips"], 2), Some(&head())).unwrap();
    assert_eq!((import.mesh.layers.len(), import.mesh.n_bundles()), (3, 2));
    assert!(import.found[0].contains("3 groups of 2 alike faces"), "{:?}", import.found);
    // In metres and with the tips first.
    let mut text = String::new();
    for line in two_quads(["tips", "middle", "roots"], 2).lines() {
        let words: Vec<&str> = line.split(' ').collect();
        if words[0] == "v" {
            let y: f32 = words[2].parse().unwrap();
            let [x, y, z] = [words[1].parse::<f32>().unwrap(), 20.0 - y, words[3].parse().unwrap()].map(|n| n / 100.0);
            let _ = writeln!(text, "v {x} {y} {z}");
        } else {
            let _ = writeln!(text, "{line}");
        }
    }
    let import = read("a.obj", &text, Some(&head())).unwrap();
    assert_eq!(import.space.unit, Unit::Metre, "{}", import.space_reason);
    assert!((import.mesh.layers[0].positions[0].y - 9.0).abs() < 1e-4);
    assert!(import.found.iter().any(|found| found.contains("nearest to the scalp")), "{:?}", import.found);
}

/// A closed lock of `n` x 1 quads around, pointed at its end, standing on the crown.
fn lock(is_closed: bool, is_pointed: bool) -> String {
    let (mut text, mut faces) = (String::new(), String::new());
    let square = [(-1.0, -0.8), (-1.0, 0.8), (0.0, 0.8), (1.0, 0.8), (1.0, -0.8), (0.0, -0.8)];
    for k in 0..5 {
        for (x, z) in square {
            let root = (81.0_f32 - x * x - z * z).sqrt();
            let (up, out) = if k == 0 { (root, 0.0) } else { (9.0 + 1.5 * k as f32, 0.4 * (k * k) as f32) };
            let _ = writeln!(text, "v {} {up} {z}", x + out);
        }
        for i in 0..6 {
            let (a, b) = (6 * k + i + 1, 6 * k + (i + 1) % 6 + 1);
            if k < 4 {
                let _ = writeln!(faces, "f {} {} {} {}", a, b, b + 6, a + 6);
            } else if is_pointed {
                let _ = writeln!(faces, "f {a} {b} 31");
            }
        }
    }
    let _ = writeln!(text, "v 8 17 0");
    if is_closed {
        // From below, so that the closed surface faces out everywhere.
        let _ = writeln!(faces, "f 1 6 3 2\nf 3 6 5 4");
    }
    text + &faces
}

#[test]
fn a_closed_lock_is_followed_up_from_its_faces_on_the_scalp() {
    let import = read("lock.obj", &lock(true, true), Some(&head())).unwrap();
    let mesh = &import.mesh;
    // Four rings and the point.
    assert_eq!((mesh.n_bundles(), mesh.layers.len()), (2, 6), "{:?}", import.found);
    assert!(import.found.iter().any(|found| found.contains("2 faces lie on the scalp")), "{:?}", import.found);
    let root = mesh.face(0, 0).unwrap().iter().map(|&v| mesh.layers[0].positions[v as usize]).collect::<Vec<_>>();
    assert!((root[1] - root[0]).cross(root[2] - root[0]).y > 0.0, "turned to face out");
    assert!(mesh.layers[5].positions.iter().all(|p| p.distance(Vec3::new(8.0, 17.0, 0.0)) < 0.5));
}

#[test]
fn an_open_tube_stands_on_its_rim_and_ends_at_its_opening() {
    let import = read("tube.obj", &lock(false, false), Some(&head())).unwrap();
    assert_eq!((import.mesh.n_bundles(), import.mesh.layers.len()), (1, 5), "{:?}", import.found);
    assert_eq!(import.mesh.face(0, 0).unwrap().len(), 6, "the rim is one polygon of six corners");
    let error = read("tube.obj", &lock(false, false), None).unwrap_err().to_string();
    assert!(error.contains("no head to follow"), "{error}");
    let far = lock(true, true).replace("v ", "v 4");
    assert!(read("far.obj", &far, Some(&head())).is_err());
}

#[test]
fn inner_vertices_of_a_patch_lie_between_its_ring() {
    // A patch of 2 x 2 quads with walls around it: its middle vertex has no wall.
    let mut text = String::new();
    let mut mesh = crate::hair_mesh::tests::straight_grid(2, 0);
    mesh.move_vertices(0, |_, p| {
        let p = p - Vec3::new(1.0, 0.0, 1.0);
        Vec3::new(p.x, (81.0 - p.x * p.x - p.z * p.z).sqrt(), p.z)
    });
    mesh.extrude(&[0, 1, 2, 3], Weld::Neighbours, |v| v.position + Vec3::Y * 2.0).unwrap();
    for p in mesh.layers.iter().flat_map(|layer| &layer.positions) {
        let _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z);
    }
    for bundle in 0..4 {
        let (below, above) = (mesh.face(0, bundle).unwrap(), mesh.face(1, bundle).unwrap());
        let _ = writeln!(text, "f {}", below.iter().rev().map(|v| (v + 1).to_string()).collect::<Vec<_>>().join(" "));
        for i in 0..4 {
            let j = (i + 1) % 4;
            let shared = (0..4).any(|other| {
                let face = mesh.face(0, other).unwrap();
                (0..4).any(|k| face[k] == below[j] && face[(k + 1) % 4] == below[i])
            });
            if !shared {
                let corners = [below[i], below[j], above[j] + 9, above[i] + 9].map(|v| (v + 1).to_string());
                let _ = writeln!(text, "f {}", corners.join(" "));
            }
        }
    }
    let import = read("patch.obj", &text, Some(&head())).unwrap();
    assert_eq!((import.mesh.n_bundles(), import.mesh.n_vertices()), (4, 18), "{:?}", import.found);
    let middle = import.mesh.layers[1].positions.iter().find(|p| p.x.abs() < 0.3 && p.z.abs() < 0.3).unwrap();
    assert!((middle.y - 10.9).abs() < 0.25, "{middle}");
}

#[test]
fn bad_files_are_errors_that_say_where() {
    for (text, words) in [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "line 4"),
        ("v 0 0 nan\nf 1 1 1\n", "line 1"),
        ("v 0 0 0\nv 1 0 0\n", "no faces"),
        ("v 0 0\n", "line 1"),
    ] {
        let error = read("bad.obj", text, None).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // Files that claim to be written here and are not whole are read as any other.
    let mut text: Vec<u8> = Vec::new();
    own::write_obj(&odd_mesh(), &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    for cut in (0..text.len()).step_by(97) {
        drop(read("cut.obj", &text[..cut], None));
    }
    drop(read("lie.obj", &text.replace("bundles ", "bundles 99999999999"), None));
    let glb = own::glb(&odd_mesh()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.glb");
    for cut in (20..glb.len()).step_by(211) {
        std::fs::write(&path, &glb[..cut]).unwrap();
        drop(read_hair_mesh(&path, None, ImportOptions::default(), Watch::default()));
    }
}
