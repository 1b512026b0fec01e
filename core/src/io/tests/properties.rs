//! Whatever the bytes are, readers return: an import whose arrays fit each other, or an error.

use proptest::prelude::*;

use super::super::{MeshImport, StrandImport, read_mesh_from_bytes, read_strands_from_bytes};
use super::samples;

/// What everything behind the readers relies on.
fn check_strands(import: StrandImport) {
    let strands = &import.strands;
    assert_eq!(strands.offsets.first(), Some(&0));
    assert_eq!(strands.offsets.last().copied(), Some(strands.n_points() as u32));
    assert!(strands.n_strands() > 0 && strands.iter().all(|points| points.len() >= 2));
    assert!(strands.points.iter().all(|p| p.is_finite()));
    for len in [strands.colours.len(), strands.opacities.len(), import.thickness.len()] {
        assert!(len == 0 || len == strands.n_points());
    }
    for len in [strands.ids.len(), strands.root_uvs.len()] {
        assert!(len == 0 || len == strands.n_strands());
    }
    let placed = import.place();
    assert!(placed.strands.points.iter().all(|p| p.is_finite()));
    assert!(placed.strands.radii_um.iter().all(|radius| radius.is_finite()));
}

fn check_mesh(import: MeshImport) {
    let mesh = import.place();
    let n = mesh.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < n));
    assert!(mesh.groups.iter().flat_map(|group| &group.triangles).all(|&t| (t as usize) < mesh.triangles.len()));
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == n);
}

fn read_everything(name: &str, bytes: &[u8]) {
    if let Ok(import) = read_strands_from_bytes(name, bytes) {
        check_strands(import);
    }
    if let Ok(import) = read_mesh_from_bytes(name, bytes) {
        check_mesh(import);
    }
}

const NAMES: [&str; 8] = ["a.hair", "a.tfx", "a.data", "a.bin", "a.ply", "a.obj", "a.gltf", "a.glb"];
const STARTS: [&[u8]; 7] =
    [b"", b"HAIR", b"\0\0\x80\x40", b"ply\nformat ascii 1.0\n", b"ply\n", b"v 0 0 0\n", b"glTF\x02\0\0\0"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_never_panic(
        name in prop::sample::select(&NAMES[..]),
        start in prop::sample::select(&STARTS[..]),
        rest in prop::collection::vec(any::<u8>(), 0..600),
    ) {
        read_everything(name, &[start, &rest].concat());
    }

    #[test]
    fn good_files_with_bytes_changed_never_panic(
        sample_idx in 0..7usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        is_in_header in any::<bool>(),
    ) {
        let (name, _, mut bytes) = samples().swap_remove(sample_idx);
        let n = if is_in_header { bytes.len().min(200) } else { bytes.len() };
        for (at, value) in changes {
            let at = at.index(n);
            bytes[at] = value;
        }
        read_everything(name, &bytes);
    }

    #[test]
    fn good_heads_with_bytes_changed_never_panic(
        head_idx in 0..5usize,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (name, mut bytes) = super::heads::good().swap_remove(head_idx);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        read_everything(name, &bytes);
    }

    #[test]
    fn words_of_text_formats_in_any_order_never_panic(
        words in prop::collection::vec(prop::sample::select(vec![
            "ply\n", "format ascii 1.0\n", "format binary_little_endian 1.0\n", "element vertex 2\n", "element strand 1\n",
            "element face 1\n", "property float x\n", "property float y\n", "property float z\n", "property uchar red\n",
            "property list uchar int vertex_indices\n", "property ushort nsegs\n", "end_header\n", "3 0 1 2\n", "0 0 0\n", "1 2 3\n",
            "v 1 2 3\n", "vt 0 1\n", "vn 0 0 1\n", "f 1 2 3\n", "f 1/1/1 2/2/2 -1/-1/-1\n", "f 1//1 2 3\n", "l 1 2\n", "g a\n", "o\n", "usemtl x\n",
            "v 1 2 3 0\n", "v 1 2 3 1 1 1 1\n", "f\n", "f 1\n", "f 9999999999999 1 1\n", "1e999 nan -inf\n", "-1\n",
        ]), 0..40),
        starts_as_ply in any::<bool>(),
    ) {
        let text = if starts_as_ply { format!("ply\n{}", words.concat()) } else { words.concat() };
        read_everything("a.obj", text.as_bytes());
        read_everything("a.ply", text.as_bytes());
    }
}
