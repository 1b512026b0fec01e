//! A hair mesh that another program modelled as plain polygons: imported, traced, simulated, rendered.

use std::fmt::Write as _;

use glam::Vec3;
use lorelei_core::document;
use lorelei_core::groom::Source;
use lorelei_core::mesh_query::MeshQuery;

use super::{lorelei, text};

/// Closed locks of quads that stand on the mannequin and end in points, in metres and Z up as modelling
/// programs export them: polygons and nothing else.
fn locks() -> String {
    let head = lorelei_assets::mannequin();
    let query = MeshQuery::new(&head.mesh).unwrap();
    let (_, hi) = head.mesh.bounds().unwrap();
    let crown = query.closest(Vec3::new(0.0, hi.y, 0.0)).position;
    let mut text = String::from("# made by hand\no hair\n");
    let mut n_vertices = 0;
    for place in 0..6 {
        let (sin, cos) = (place as f32 * std::f32::consts::TAU / 6.0).sin_cos();
        let middle = query.closest(crown + 4.0 * Vec3::new(cos, -0.3, sin)).position;
        let out = Vec3::new(cos, 0.6, sin).normalize();
        let (across, along) = (out.cross(Vec3::Y).normalize(), out.cross(Vec3::Y).normalize().cross(out));
        // Eight corners around, in rings that rise and then fall.
        for ring in 0..7 {
            let t = ring as f32;
            let centre = middle + out * 1.6 * t - Vec3::Y * 0.25 * t * t;
            for corner in 0..8 {
                let (sin, cos) = (corner as f32 * std::f32::consts::TAU / 8.0).sin_cos();
                let p = centre + 1.3 * (cos * across + sin * along) * (1.0 - 0.06 * t);
                let p = if ring == 0 { query.closest(p).position } else { p } / 100.0;
                let _ = writeln!(text, "v {} {} {}", p.x, -p.z, p.y);
            }
        }
        let tip = (middle + out * 11.0 - Vec3::Y * 13.0) / 100.0;
        let _ = writeln!(text, "v {} {} {}", tip.x, -tip.z, tip.y);
        let at = |ring: usize, corner: usize| n_vertices + 8 * ring + corner % 8 + 1;
        // The root faces the head, as the surface of a closed body does.
        let root: Vec<String> = (0..8).rev().map(|corner| at(0, corner).to_string()).collect();
        let _ = writeln!(text, "f {}", root.join(" "));
        for corner in 0..8 {
            for ring in 0..6 {
                let quad = [at(ring, corner), at(ring, corner + 1), at(ring + 1, corner + 1), at(ring + 1, corner)];
                let _ = writeln!(text, "f {}", quad.map(|v| v.to_string()).join(" "));
            }
            let _ = writeln!(text, "f {} {} {}", at(6, corner), at(6, corner + 1), at(7, 0));
        }
        n_vertices += 57;
    }
    text
}

#[test]
fn polygons_of_another_program_become_hair_that_moves_and_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("locks.obj"), locks()).unwrap();
    let done = lorelei(folder, &["convert", "locks.obj", "locks.lorelei", "--hair-mesh"]);
    let told = text(&done.stderr);
    assert!(done.status.success(), "{told}");
    assert!(told.contains("6 faces lie on the scalp") && told.contains("7 layers above the root"), "{told}");
    let groom = document::open(&folder.join("locks.lorelei")).unwrap();
    let Source::HairMesh(mesh) = &groom.layers[0].source else { panic!("a hair mesh") };
    assert_eq!((mesh.n_bundles(), mesh.layers.len()), (6, 8));

    // Traced: strands go from the scalp to the tips.
    let done = lorelei(folder, &["convert", "locks.lorelei", "strands.data"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(std::fs::metadata(folder.join("strands.data")).unwrap().len() > 1_000_000);

    // Simulated and rendered: hair that moves gives another picture than hair at rest, and than none.
    let render = |name: &str, more: &[&str]| {
        let arguments = ["render", "locks.lorelei", "--size", "160x120", "--strands", "3000", "--camera", "front"];
        let done = lorelei(folder, &[&arguments[..], &["--out", name], more].concat());
        assert!(done.status.success(), "{}", text(&done.stderr));
        image::open(folder.join(name)).unwrap().to_rgb8()
    };
    let rest = render("rest.png", &[]);
    let moved = render("moved.png", &["--seconds", "0.5", "--motion", "shake"]);
    let n_different = |a: &image::RgbImage, b: &image::RgbImage| {
        a.pixels().zip(b.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 24)).count()
    };
    assert!(n_different(&rest, &moved) > 100, "{}", n_different(&rest, &moved));
    std::fs::write(folder.join("bald.ron"), "[SetLayerVisible(layer_idx: 0, visible: false)]").unwrap();
    let done = lorelei(folder, &["apply", "locks.lorelei", "--edits", "bald.ron", "--out", "locks.lorelei"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(n_different(&rest, &render("bald.png", &[])) > 300);
}

#[test]
fn a_hair_mesh_leaves_as_polygons_and_comes_back_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["bob.obj", "bob.glb"] {
        let done = lorelei(folder, &["convert", "bob", name]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let back = name.replace('.', "-") + ".lorelei";
        let done = lorelei(folder, &["convert", name, &back, "--hair-mesh"]);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let groom = document::open(&folder.join(&back)).unwrap();
        let bob = lorelei_assets::hairstyle("bob").unwrap();
        let first = bob.layers.iter().find(|layer| matches!(layer.source, Source::HairMesh(_))).unwrap();
        assert!(groom.layers[0].source == first.source, "{name}");
    }
    std::fs::write(folder.join("cube.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let refused = lorelei(folder, &["convert", "cube.obj", "cube.lorelei", "--hair-mesh"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).contains("layer_0"), "{}", text(&refused.stderr));
}
