//! Files that other programs wrote, where they are at hand.

use super::super::{Axis, ImportOptions, Space, Unit, import_groom, info, read_mesh, read_strands};
use super::shared_file;
use crate::groom::Source;
use crate::io::Watch;

#[test]
fn five_files_of_one_groom_read_as_the_same_strands() {
    let names = ["Bangs_100.hair", "Bangs_100.data", "Bangs_100.bin", "Bangs_100_ascii.ply", "Bangs_100_binary.ply"];
    let mut first = None;
    for name in names {
        let Some(path) = shared_file(name) else { return };
        let import = read_strands(&path, Watch::default()).expect("a good file");
        assert_eq!((import.strands.n_strands(), import.strands.n_points()), (100, 1165), "{name}");
        assert_eq!((import.space.unit, import.space.up), (Unit::Millimetre, Axis::X), "{}", import.space_reason);
        let shape = (import.strands.points, import.strands.offsets);
        assert_eq!(first.get_or_insert_with(|| shape.clone()), &shape, "{name}");
    }
}

#[test]
fn the_bangs_and_their_head_come_upright_and_together() {
    let (Some(hair), Some(head)) = (shared_file("Bangs_100.hair"), shared_file("Bangs_head.ply")) else { return };
    let import = import_groom(&hair, Some(&head), ImportOptions::default(), Watch::default()).expect("good files");
    assert_eq!((import.space.unit, import.space.up, import.space.front), (Unit::Millimetre, Axis::X, Axis::NegY));
    assert_eq!(import.head_space, None);
    let mesh = &import.groom.head.expect("a head was given").mesh;
    assert_eq!(mesh.uvs.len(), mesh.positions.len());
}

#[test]
fn sintel_stands_upright_with_her_hair_in_place() {
    let (Some(hair), Some(head)) = (shared_file("sintel_hair_16points.tfx"), shared_file("sintel.obj")) else { return };
    let summary = info(&hair, Watch::default()).expect("a good file");
    assert_eq!((summary.strands, summary.points), (11_400, 182_400));
    assert_eq!((summary.unit, summary.up), (Unit::Metre, Axis::Y), "{}", summary.space_reason);
    assert!((summary.bounds_cm.max.y - 167.5).abs() < 0.2);

    let import = import_groom(&hair, Some(&head), ImportOptions::default(), Watch::default()).expect("good files");
    assert_eq!(import.head_space, None, "{:?}", import.warnings);
    let (min, max) = import.groom.head.as_ref().expect("a head was given").mesh.bounds().expect("vertices");
    assert!((max.y - 165.52).abs() < 0.01 && (min.y - 122.54).abs() < 0.01);
    let layer = &import.groom.layers[0];
    let Source::Strands(strands) = &layer.source else { panic!("imported strands are their own guides") };
    assert_eq!((layer.n_strands, layer.vertices_per_strand, strands.n_points()), (11_400, 16, 182_400));
    let mesh = read_mesh(&head, Watch::default()).expect("a good file");
    assert_eq!(mesh.mesh.triangles.len(), 5952);
}

#[test]
fn what_a_person_decides_is_not_guessed() {
    let Some(hair) = shared_file("sintel_hair_16points.tfx") else { return };
    let options = ImportOptions { unit: Some(Unit::Inch), up: Some(Axis::Z), front: None };
    let import = import_groom(&hair, None, options, Watch::default()).expect("a good file");
    assert_eq!((import.space.unit, import.space.up, import.space.front), (Unit::Inch, Axis::Z, Axis::NegY));
}

#[test]
fn a_face_cannot_look_up() {
    let options = ImportOptions { up: Some(Axis::Z), front: Some(Axis::NegZ), ..ImportOptions::default() };
    assert_eq!(options.decide(Space::default()).front, Axis::NegY);
    assert!(options.reason(Space::default(), "guessed".to_owned()).contains("Z up, -Y front: as was asked for"));
    assert_eq!(ImportOptions::default().reason(Space::default(), "guessed".to_owned()), "guessed");
}

#[test]
fn files_that_are_not_read_yet_say_so() {
    for name in ["Bangs_100.abc", "blender.abc", "blender.usdc"] {
        let Some(path) = shared_file(name) else { return };
        let error = read_strands(&path, Watch::default()).expect_err("not a format of this version");
        assert!(error.to_string().contains("not read yet"), "{error}");
    }
}
