//! Files that are damaged, lying, or something else: an error that says so, and nothing worse.

use super::super::{ReadError, read_mesh, read_strands};
use super::{as_bin, as_ply, read, sample_hair, samples, written};
use crate::io::Watch;
use crate::strands::Strands;
use glam::Vec3;

#[test]
fn a_file_cut_off_anywhere_is_an_error_with_its_place() {
    for (name, _, bytes) in samples() {
        let full = read(name, &bytes).expect("the whole file is good");
        for n in 0..bytes.len() {
            match read(name, &bytes[..n]) {
                // The last line end of a text file is no loss.
                Ok(import) => {
                    assert!(n + 1 == bytes.len() && import.strands == full.strands, "{name} cut at {n} was read");
                }
                Err(message) => assert!(message.starts_with(name) && message.len() > name.len() + 20, "{message}"),
            }
        }
    }
}

/// A `.hair` header with the counts and flags given, and `rest` after it.
fn hair_file(n_strands: u32, n_points: u32, flags: u32, default_segments: u32, rest: &[u8]) -> Vec<u8> {
    let mut bytes = b"HAIR".to_vec();
    for value in [n_strands, n_points, flags, default_segments] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.resize(128, 0);
    bytes.extend(rest);
    bytes
}

#[test]
fn four_billion_points_in_a_small_file_are_refused_before_anything_is_allocated() {
    let huge = u32::MAX;
    let mut tfx = 4.0f32.to_le_bytes().to_vec();
    for value in [huge, huge, 160, 0, 0, 0, 0] {
        tfx.extend(value.to_le_bytes());
    }
    tfx.resize(400, 0);
    let ply = |encoding: &str| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex 4294967295\nproperty float x\nproperty float y\nproperty float z\n\
             element strand 4294967295\nproperty ushort nsegs\nend_header\n0 0 0\n"
        )
        .into_bytes()
    };
    let mut data = huge.to_le_bytes().to_vec();
    data.resize(100, 0);
    let files = [
        ("points.hair", hair_file(1, huge, 3, 0, &[0; 64])),
        ("strands.hair", hair_file(huge, 2, 3, 0, &[0; 64])),
        ("default.hair", hair_file(huge, huge, 2, 0, &[0; 64])),
        ("segments.hair", hair_file(2, 4, 2, huge, &[0; 64])),
        ("a.tfx", tfx),
        ("ascii.ply", ply("ascii")),
        ("binary.ply", ply("binary_little_endian")),
        ("a.data", data.clone()),
        ("a.bin", data),
    ];
    for (name, bytes) in files {
        let error = read(name, &bytes).expect_err("the counts lie");
        assert!(error.starts_with(name), "{error}");
    }
}

#[test]
fn counts_that_do_not_add_up_are_named() {
    let mut bytes = written(&sample_hair(4, |_| 5), "hair");
    bytes[128..130].copy_from_slice(&6u16.to_le_bytes());
    let error = read("a.hair", &bytes).expect_err("22 points by segments, 20 by header");
    assert!(error.contains("22 points by its strands, but 20 by its header"), "{error}");

    let mut bytes = as_ply(&sample_hair(4, |_| 5), "ascii");
    let at = bytes.len() - 2;
    bytes[at] = b'9';
    let error = read("a.ply", &bytes).expect_err("the runs do not fit the vertices");
    assert!(error.contains("add up to"), "{error}");
}

#[test]
fn a_position_that_is_no_number_is_refused_with_its_strand() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38] {
        let mut strands = sample_hair(6, |_| 8);
        strands.points[3 * 8 + 5].y = bad;
        let files = [
            ("a.hair", hair_bytes(&strands)),
            ("a.bin", as_bin(&strands)),
            ("a.ply", as_ply(&strands, "ascii")),
            ("b.ply", as_ply(&strands, "binary_little_endian")),
        ];
        for (name, bytes) in files {
            let error = read(name, &bytes).expect_err("a position is no place");
            assert!(error.contains("strand 3, point 5"), "{error}");
        }
    }
}

/// `.hair` as the writer would, without its own check.
fn hair_bytes(strands: &Strands) -> Vec<u8> {
    let mut bytes = Vec::new();
    super::super::hair::write(&mut bytes, strands, 1.0).expect("a vector takes everything");
    bytes
}

#[test]
fn strands_of_one_point_are_left_out_with_a_warning_and_ids_stay() {
    let mut strands = sample_hair(3, |_| 4);
    strands.push(&[Vec3::ONE]);
    strands.push(&[Vec3::ONE, Vec3::ONE]);
    strands.push(&[Vec3::ZERO, Vec3::Y]);
    for (name, bytes) in
        [("a.hair", hair_bytes(&strands)), ("a.bin", as_bin(&strands)), ("a.ply", as_ply(&strands, "ascii"))]
    {
        let import = read(name, &bytes).expect("four strands are good");
        assert_eq!(import.strands.n_strands(), 4, "{name}");
        assert_eq!(import.strands.ids, [0, 1, 2, 5]);
        assert_eq!(import.strands.strand(3), [Vec3::ZERO, Vec3::Y]);
        let warnings = import.warnings.join("\n");
        assert!(warnings.contains("1 strands of fewer than two points"), "{warnings}");
        assert!(warnings.contains("1 strands with all points at one place"), "{warnings}");
    }
}

#[test]
fn files_without_a_strand_are_errors() {
    let mut single = Strands::default();
    single.push(&[Vec3::ONE]);
    let files = [
        ("none.hair", hair_file(0, 0, 3, 0, &[])),
        ("no_points.hair", hair_file(2, 4, 1, 0, &[1, 0, 1, 0])),
        ("single.hair", hair_bytes(&single)),
        ("none.data", vec![0; 4]),
        ("none.bin", vec![0; 4]),
        ("none.tfx", {
            let mut b = 4.0f32.to_le_bytes().to_vec();
            b.resize(160, 0);
            b
        }),
        ("none.ply", as_ply(&Strands::default(), "ascii")),
        ("single.ply", as_ply(&single, "binary_little_endian")),
    ];
    for (name, bytes) in files {
        let error = read(name, &bytes).expect_err("there is no strand");
        assert!(error.contains("holds no") || error.contains("none with a length"), "{error}");
    }
}

#[test]
fn strangers_are_called_by_their_name() {
    let strangers: [(&str, &[u8], &str); 7] = [
        ("picture.hair", b"\x89PNG\r\n\x1a\n0000000000000000", "a PNG picture, although it is named .hair"),
        ("photo.tfx", b"\xff\xd8\xff\xe0 0000000000", "a JPEG picture"),
        ("packed.data", b"PK\x03\x04 00000000000000000000", "a zip archive"),
        ("curves.abc", b"Ogawa\xff\0\x01 00000000000", "an Alembic file"),
        ("scene.usdc", b"PXR-USDC 00000000000000", "a USD file"),
        ("text.hair", b"Dear reader, this is no hair.", "begins with the letters HAIR"),
        ("text.txt", b"Dear reader, this is no hair.", "in no format that is known"),
    ];
    for (name, bytes, expected) in strangers {
        let error = read(name, bytes).expect_err("a stranger");
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_name_that_lies_does_not_matter_where_the_content_tells() {
    for (name, format, bytes) in samples() {
        for lie in ["groom.hair", "groom.tfx", "groom.ply", "groom.obj", "groom"] {
            let has_no_magic = name == "a.data" || name == "a.bin";
            if has_no_magic && lie != "groom" {
                continue;
            }
            let import = read(lie, &bytes).expect("the content tells");
            assert_eq!(import.format, format, "{name} as {lie}");
        }
    }
    let data = written(&sample_hair(5, |_| 6), "data");
    assert_eq!(read("misnamed.bin", &data).expect("its length tells").format, super::Format::Data);
}

#[test]
fn what_is_not_a_readable_file_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let empty = folder.path().join("empty.hair");
    std::fs::write(&empty, b"").expect("writable");
    let missing = folder.path().join("missing.hair");
    type Reader = fn(&std::path::Path) -> Option<ReadError>;
    let readers: [Reader; 2] =
        [|path| read_strands(path, Watch::default()).err(), |path| read_mesh(path, Watch::default()).err()];
    for read in readers {
        assert!(matches!(read(folder.path()), Some(ReadError::NotAFile { what: "a folder", .. })));
        assert!(matches!(read(&empty), Some(ReadError::Empty { .. })));
        assert!(matches!(read(&missing), Some(ReadError::Open { .. })));
    }
    #[cfg(unix)]
    assert!(matches!(
        read_strands(std::path::Path::new("/dev/zero"), Watch::default()),
        Err(ReadError::NotAFile { what: "a device or pipe", .. })
    ));
}

#[cfg(unix)]
#[test]
fn a_file_without_permission_says_so() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("locked.hair");
    std::fs::write(&path, written(&sample_hair(3, |_| 4), "hair")).expect("writable");
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o000)).expect("it is ours");
    match read_strands(&path, Watch::default()) {
        Err(error) => assert!(error.to_string().contains("lack the permission"), "{error}"),
        // The superuser may read anything.
        Ok(_) => println!("skipped: this user may read files without permission"),
    }
}

#[test]
fn a_cancelled_read_stops() {
    use std::sync::atomic::{AtomicBool, Ordering};
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("large.data");
    // Four MiB, so that there is something to cancel.
    std::fs::write(&path, as_data(&sample_hair(3500, |_| 100))).expect("writable");
    let cancel = AtomicBool::new(false);
    let shares = std::cell::RefCell::new(Vec::new());
    let on_progress = |share: f32| {
        shares.borrow_mut().push(share);
        cancel.store(true, Ordering::Relaxed);
    };
    let error = read_strands(&path, Watch::new(&on_progress, &cancel)).expect_err("it was cancelled");
    assert!(error.is_cancelled(), "{error}");
    assert_eq!(shares.borrow().len(), 1);
    assert!(shares.borrow()[0] > 0.0 && shares.borrow()[0] < 1.0);
}

fn as_data(strands: &Strands) -> Vec<u8> {
    let mut bytes = Vec::new();
    super::super::salon::write(&mut bytes, strands).expect("a vector takes everything");
    bytes
}
