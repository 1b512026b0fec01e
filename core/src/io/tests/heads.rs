//! Heads in OBJ, PLY and glTF that the tests make: the same mesh from all, and no bad one.

use super::super::{MeshImport, read_mesh_from_bytes};
use crate::io::{Unit, Watch, read_mesh};

const OBJ: &str = "# a square in two groups\nmtllib none.mtl\no Kopf-K\u{f6}rper\nv -10 0 0\nv 10 0 0\nv 10 25 0\nv -10 25 0\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\ng scalp\nf -4/-4 -2/-2 -1/-1\n";

fn ply(encoding: &str) -> Vec<u8> {
    let positions = [[-10.0f32, 0.0, 0.0], [10.0, 0.0, 0.0], [10.0, 25.0, 0.0], [-10.0, 25.0, 0.0]];
    let uvs = [[0.0f64, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty double s\n\
         property double t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for (p, uv) in positions.iter().zip(uvs) {
        if encoding == "ascii" {
            bytes.extend(format!("{} {} {} {} {}\n", p[0], p[1], p[2], uv[0], uv[1]).bytes());
        } else {
            bytes.extend(p.iter().flat_map(|v| v.to_le_bytes()));
            bytes.extend(uv.iter().flat_map(|v| v.to_le_bytes()));
        }
    }
    if encoding == "ascii" {
        bytes.extend(b"4 0 1 2 3\n");
    } else {
        bytes.push(4);
        bytes.extend([0i32, 1, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

/// Positions, texture coordinates and indices of the square, in metres and moved by (0, -1, 0).
fn gltf_buffer() -> Vec<u8> {
    let positions = [[-0.1f32, -1.0, 0.0], [0.1, -1.0, 0.0], [0.1, -0.75, 0.0], [-0.1, -0.75, 0.0]];
    let uvs = [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend(uvs.iter().flatten().flat_map(|v| v.to_le_bytes()));
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn gltf_json(buffer: &str, nodes: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":{nodes},
        "meshes":[{{"name":"Head","primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2}}]}}],
        "buffers":[{{"byteLength":92{buffer}}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},{{"buffer":0,"byteOffset":80,"byteLength":12}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-0.1,-1,0],"max":[0.1,-0.75,0]}},
        {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},{{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}]}}"#
    )
}

const NODES: &str = r#"[{"children":[1],"translation":[0,0.5,0]},{"mesh":0,"translation":[0,0.5,0]}]"#;

fn glb(json: &str, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF".to_vec();
    let total = 12 + 8 + json.len() + 8 + buffer.len();
    for value in [2, total as u32, json.len() as u32] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((buffer.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(buffer);
    bytes
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().enumerate().fold(0u32, |bits, (i, &byte)| bits | u32::from(byte) << (16 - 8 * i));
        for i in 0..=chunk.len() {
            text.push(char::from(DIGITS[(bits >> (18 - 6 * i)) as usize & 63]));
        }
    }
    while !text.len().is_multiple_of(4) {
        text.push('=');
    }
    text
}

fn read(name: &str, bytes: &[u8]) -> Result<MeshImport, String> {
    read_mesh_from_bytes(name, bytes).map_err(|error| error.to_string())
}

pub(super) fn good() -> Vec<(&'static str, Vec<u8>)> {
    let data = format!(r#","uri":"data:application/octet-stream;base64,{}""#, base64(&gltf_buffer()));
    vec![
        ("head.obj", OBJ.as_bytes().to_vec()),
        ("ascii.ply", ply("ascii")),
        ("binary.ply", ply("binary_little_endian")),
        ("head.glb", glb(&gltf_json("", NODES), &gltf_buffer())),
        ("head.gltf", gltf_json(&data, NODES).into_bytes()),
    ]
}

#[test]
fn one_head_in_five_files_is_the_same_head() {
    for (name, bytes) in good() {
        let import = read(name, &bytes).expect("a good file");
        let expected_unit =
            if name.ends_with("glb") || name.ends_with("gltf") { Unit::Metre } else { Unit::Centimetre };
        assert_eq!(import.space.unit, expected_unit, "{name}: {}", import.space_reason);
        let mesh = import.place();
        assert_eq!(mesh.triangles.len(), 2, "{name}");
        let (min, max) = mesh.bounds().expect("four vertices");
        assert!((min - glam::Vec3::new(-10.0, 0.0, 0.0)).length() < 1e-4, "{name}: {min}");
        assert!((max - glam::Vec3::new(10.0, 25.0, 0.0)).length() < 1e-4, "{name}: {max}");
        assert!(mesh.normals.iter().all(|n| n.z > 0.99), "{name}");
        // Texture coordinates go up with y in all of them.
        for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            assert!((uv[1] - p.y / 25.0).abs() < 1e-5, "{name}: {p} {uv:?}");
        }
        assert_eq!(mesh.uvs.len(), mesh.positions.len(), "{name}");
    }
}

#[test]
fn groups_keep_their_names() {
    let mesh = read("head.obj", OBJ.as_bytes()).expect("good").mesh;
    let names: Vec<&str> = mesh.groups.iter().map(|group| group.name.as_str()).collect();
    assert_eq!(names, ["Kopf-K\u{f6}rper", "scalp"]);
    assert_eq!(mesh.group("scalp").expect("named").triangles, [1]);
}

#[test]
fn a_head_cut_off_anywhere_does_not_panic() {
    for (name, bytes) in good() {
        for n in 0..bytes.len() {
            if let Ok(import) = read(name, &bytes[..n]) {
                // Text formats have no end mark: OBJ loses faces silently, so only whole lines may be lost.
                assert!(name == "head.obj" || n + 1 >= bytes.len(), "{name} cut at {n} was read");
                assert!(!import.mesh.triangles.is_empty());
            }
        }
    }
}

#[test]
fn errors_in_an_obj_name_the_line() {
    for (text, line) in [
        ("v 0 0 0\nv 1 0 zero\n", 2),
        ("# x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", 5),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", 4),
        ("v 0 0 0\nvt 1\n", 2),
        // Found by the fuzzer: tobj multiplies such an index before it looks whether it is one.
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/-8 3/1\n", 5),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//9223372036854775807 3//1\n", 5),
    ] {
        let error = read("head.obj", text.as_bytes()).expect_err("a bad line");
        assert!(error.contains(&format!("in line {line}")), "{error}");
    }
    let error = read("head.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n").expect_err("no place");
    assert!(error.contains("no place"), "{error}");
    let error = read("head.obj", b"v 0 0 0\nv 1 0 0\n").expect_err("no faces");
    assert!(error.contains("holds no faces"), "{error}");
}

#[test]
fn polygons_become_triangles_and_lines_are_left_out() {
    let text = "v 0 0 0\nv 20 0 0\nv 20 20 0\nv 10 30 0\nv 0 20 0\nf 1 2 3 4 5\nl 1 2\nf 1 2 2\n";
    let import = read("head.obj", text.as_bytes()).expect("good");
    assert_eq!(import.mesh.triangles.len(), 3);
    let without_uv = "v 0 0 0\nv 20 0 0\nv 0 30 0\nvt 0 0\nf 1/1 2/1 3/1\ng b\nf 1 3 2\n";
    assert!(read("head.obj", without_uv.as_bytes()).expect("good").mesh.uvs.is_empty());
}

#[test]
fn gltf_that_lies_is_refused() {
    let buffer = gltf_buffer();
    let lies = [
        ("count", gltf_json("", NODES).replace("\"count\":4", "\"count\":4000000000")),
        ("offset", gltf_json("", NODES).replace("\"byteOffset\":48", "\"byteOffset\":4294967290")),
        ("length", gltf_json("", NODES).replace("\"byteLength\":92", "\"byteLength\":4294967290")),
        ("index", gltf_json("", NODES).replace("\"componentType\":5123", "\"componentType\":5121")),
        ("loop", gltf_json("", r#"[{"children":[1]},{"mesh":0,"children":[0]}]"#)),
        ("twice", gltf_json("", r#"[{"children":[1,1]},{"mesh":0}]"#)),
        ("missing file", gltf_json(r#","uri":"missing.bin""#, NODES)),
        ("file elsewhere", gltf_json(r#","uri":"../../../etc/passwd""#, NODES)),
        ("net", gltf_json(r#","uri":"https://example.com/a.bin""#, NODES)),
        (
            "stride",
            gltf_json("", NODES)
                .replace("\"byteLength\":48", "\"byteLength\":48,\"byteStride\":4")
                .replace("\"count\":4,\"type\":\"VEC3\"", "\"count\":10,\"type\":\"VEC3\""),
        ),
    ];
    for (lie, json) in lies {
        let result = read("head.glb", &glb(&json, &buffer));
        assert!(lie == "index" || result.is_err(), "{lie} was believed");
    }
}

#[test]
fn what_made_the_gltf_crate_panic_is_refused() {
    // Found by changing bytes at random: a GLB shorter than its header by its own word, a position without accessors.
    for length in [0u8, 5, 11] {
        let mut bytes = glb(&gltf_json("", NODES), &gltf_buffer());
        bytes[8..12].copy_from_slice(&[length, 0, 0, 0]);
        assert!(read("head.glb", &bytes).is_err());
    }
    let json = gltf_json("", NODES).replace("\"accessors\"", "\"accessors_\"");
    assert!(read("head.glb", &glb(&json, &gltf_buffer())).is_err());
}

#[test]
fn extensions_that_change_no_shape_do_not_stop_a_head() {
    let with = |extension: &str| {
        let json = gltf_json("", NODES).replacen('{', &format!("{{\"extensionsRequired\":[\"{extension}\"],"), 1);
        read("head.glb", &glb(&json, &gltf_buffer()))
    };
    assert_eq!(with("KHR_texture_transform").expect("only the picture moves").mesh.triangles.len(), 2);
    assert!(with("KHR_draco_mesh_compression").expect_err("the shape is packed").contains("without compression"));
}

#[test]
fn a_gltf_finds_its_buffer_beside_it() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("head.gltf");
    std::fs::write(&path, gltf_json(r#","uri":"the%20head.bin""#, NODES)).expect("writable");
    let error = read_mesh(&path, Watch::default()).expect_err("the buffer is missing").to_string();
    assert!(error.contains("the head.bin"), "{error}");
    std::fs::write(folder.path().join("the head.bin"), gltf_buffer()).expect("writable");
    assert_eq!(read_mesh(&path, Watch::default()).expect("good").mesh.triangles.len(), 2);
}
