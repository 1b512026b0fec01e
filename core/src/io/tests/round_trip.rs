//! What is written is read back: the same strands, in every unit and axis.

use super::super::{Axis, Format, ReadError, Space, Unit, WriteError, WriteOptions, read_strands, write_strands};
use super::{read, sample_hair, samples, with_attributes};
use crate::io::Watch;
use crate::strands::Strands;

/// Largest distance between two grooms' points.
fn distance(a: &Strands, b: &Strands) -> f32 {
    assert_eq!(a.offsets, b.offsets);
    a.points.iter().zip(&b.points).map(|(p, q)| p.distance(*q)).fold(0.0, f32::max)
}

#[test]
fn every_sample_reads_as_what_it_was_made_from() {
    for (name, format, bytes) in samples() {
        let import = read(name, &bytes).expect("a good file");
        assert_eq!(import.format, format);
        assert_eq!(import.strands.n_strands(), 12, "{name}");
        assert!(import.strands.iter().all(|points| points.len() >= 4));
    }
}

#[test]
fn strands_survive_every_format_unit_and_axis() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let strands = with_attributes(sample_hair(200, |_| 16));
    for extension in ["hair", "tfx", "data"] {
        for unit in Unit::ALL {
            for up in [Axis::Y, Axis::Z] {
                let path = folder.path().join(format!("{}_{}.{extension}", unit.name(), up.name()));
                let options = WriteOptions { unit: Some(unit), up: Some(up) };
                write_strands(&path, &strands, options, Watch::default()).expect("writable");
                let mut import = read_strands(&path, Watch::default()).expect("readable");
                // Inches are rare enough to be taken for a small head in centimetres; a person corrects it.
                if unit != Unit::Inch {
                    assert_eq!(
                        (import.space.unit, import.space.up),
                        (unit, up),
                        "{extension}: {}",
                        import.space_reason
                    );
                }
                import.space = Space::new(unit, up);
                let placed = import.place();
                // 30 cm of f32 in other units and back.
                assert!(distance(&placed.strands, &strands) < 1e-4, "{extension} {unit:?} {up:?}");
                if extension == "hair" {
                    let worst = placed
                        .strands
                        .radii_um
                        .iter()
                        .zip(&strands.radii_um)
                        .map(|(a, b)| (a - b).abs())
                        .fold(0.0, f32::max);
                    assert!(worst < 1e-3, "radii differ by {worst} um");
                    assert_eq!(placed.strands.colours, strands.colours);
                    assert_eq!(placed.strands.opacities, strands.opacities);
                }
                if extension == "tfx" {
                    assert_eq!(placed.strands.root_uvs, strands.root_uvs);
                    assert_eq!(placed.strands.colours, strands.colours);
                    assert!((placed.strands.radii_um[16] - strands.radii_um[16]).abs() < 1e-3);
                }
            }
        }
    }
}

#[test]
fn tressfx_gets_a_vertex_count_that_divides_64_and_pinned_roots() {
    for (n_points, n_written) in [(2, 8), (8, 8), (9, 16), (16, 16), (40, 64), (100, 64)] {
        let strands = sample_hair(5, |_| n_points);
        let bytes = super::written(&strands, "tfx");
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
        assert_eq!((word(4), word(8)), (5, n_written));
        assert_ne!(word(16), 0, "strand texture coordinates are always there");
        for strand_idx in 0..5 {
            for vertex_idx in 0..n_written {
                let at = 160 + 16 * (strand_idx * n_written + vertex_idx) as usize + 12;
                assert_eq!(f32::from_bits(word(at)), if vertex_idx == 0 { 0.0 } else { 1.0 });
            }
        }
        let back = read("a.tfx", &bytes).expect("readable").place().strands;
        for (new, old) in back.iter().zip(strands.iter()) {
            assert!(new[0].distance(old[0]) < 1e-5 && new[new.len() - 1].distance(old[old.len() - 1]) < 1e-5);
        }
    }
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let strands = with_attributes(sample_hair(3, |_| 5));
    let warnings = |name: &str| {
        write_strands(&folder.path().join(name), &strands, WriteOptions::default(), Watch::default())
            .expect("writable")
            .join("\n")
    };
    assert!(warnings("a.data").contains("width"));
    assert!(warnings("a.tfx").contains("resampled to 8"));
    assert!(warnings("a.hair").contains("root texture coordinates"));
    assert_eq!(warnings("a.usda"), "");
    let bare = sample_hair(3, |_| 5);
    let warnings = write_strands(&folder.path().join("b.usda"), &bare, WriteOptions::default(), Watch::default());
    assert!(warnings.expect("writable")[0].contains("no widths"));
}

#[test]
fn a_write_that_fails_leaves_what_was_there() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("groom.hair");
    let strands = sample_hair(3, |_| 5);
    write_strands(&path, &strands, WriteOptions::default(), Watch::default()).expect("writable");
    let before = std::fs::read(&path).expect("readable");

    let cancel = std::sync::atomic::AtomicBool::new(true);
    let large = sample_hair(4000, |_| 60);
    let cancelled =
        write_strands(&path, &large, WriteOptions::default(), Watch { on_progress: None, cancel: Some(&cancel) });
    assert!(matches!(cancelled, Err(WriteError::Cancelled { .. })));
    let nothing = write_strands(&path, &Strands::default(), WriteOptions::default(), Watch::default());
    assert!(matches!(nothing, Err(WriteError::Refused { .. })));
    let name = write_strands(&folder.path().join("groom.xyz"), &strands, WriteOptions::default(), Watch::default());
    assert!(matches!(name, Err(WriteError::Refused { .. })));
    let no_folder =
        write_strands(&folder.path().join("no/groom.hair"), &strands, WriteOptions::default(), Watch::default());
    assert!(matches!(no_folder, Err(WriteError::Io { .. })));

    assert_eq!(std::fs::read(&path).expect("readable"), before);
    assert_eq!(std::fs::read_dir(folder.path()).expect("listable").count(), 1, "no temporary file stays");
}

#[test]
fn usd_text_has_as_many_values_as_it_announces() {
    let strands = with_attributes(sample_hair(3, |strand_idx| 4 + strand_idx));
    let text = String::from_utf8(super::written(&strands, "usda")).expect("text");
    assert!(text.starts_with("#usda 1.0\n"));
    assert!(text.contains("int[] curveVertexCounts = [4, 5, 6]"));
    assert!(
        text.contains("upAxis = \"Y\"")
            && text.contains("metersPerUnit = 0.01")
            && text.contains("defaultPrim = \"Hair\"")
    );
    let n_in = |start: &str| {
        let line = text.lines().find(|line| line.trim_start().starts_with(start)).expect("the attribute is there");
        line.matches(", ").count() + 1
    };
    assert_eq!(n_in("point3f[] points"), 3 * 15);
    assert_eq!(n_in("float[] widths"), 15);
    assert_eq!(n_in("texCoord2f[] primvars:st"), 2 * 3);
    assert!(!text.contains("normals"));
}

#[test]
fn widths_that_are_no_hairs_keep_their_proportion() {
    let mut strands = sample_hair(30, |_| 8);
    strands.radii_um = (0..240).map(|k| if k % 8 == 0 { 50_000.0 } else { 25_000.0 }).collect();
    let placed = read("a.hair", &super::written(&strands, "hair")).expect("readable").place();
    assert_eq!(placed.radius_um, Some(40.0));
    assert!((placed.strands.radii_um[1] - 20.0).abs() < 1e-3);
    assert_eq!(placed.warnings.len(), 1);
    // One number for all is a placeholder.
    strands.radii_um = vec![5000.0; 240];
    let placed = read("a.hair", &super::written(&strands, "hair")).expect("readable").place();
    assert_eq!((placed.radius_um, placed.strands.radii_um.len()), (None, 0));
}

#[test]
fn a_mesh_is_not_taken_for_strands_nor_strands_for_a_mesh() {
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let error = super::super::read_strands_from_bytes("head.obj", obj).expect_err("a mesh");
    assert!(matches!(error, ReadError::WrongKind { .. }) && error.to_string().contains("as the head"));
    for (name, format, bytes) in samples() {
        let error = super::super::read_mesh_from_bytes(name, &bytes).expect_err("strands");
        assert!(error.to_string().contains("holds strands"), "{format:?}: {error}");
    }
    assert_eq!(Format::Obj.contents(), super::super::Contents::Mesh);
}
