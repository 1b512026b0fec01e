//! Writes a triangle mesh as binary glTF 2.0: one mesh, one primitive and material a face group.
//!
//! glTF puts v downwards from the top of the image; the studio's v points up, so v is turned here and
//! again on reading.

use std::fmt::Write as _;

use lorelei_core::mesh::TriMesh;

/// The file's bytes. Positions in metres, as glTF demands.
pub fn to_glb(mesh: &TriMesh, name: &str) -> Vec<u8> {
    let mut bin: Vec<u8> = Vec::new();
    let mut views = String::new();
    let mut accessors = String::new();
    let mut add = |bytes: &[u8], target: u32, n: usize, component: u32, kind: &str, extra: &str| {
        let separator = if views.is_empty() { "" } else { "," };
        let _ = write!(
            views,
            r#"{separator}{{"buffer":0,"byteOffset":{},"byteLength":{},"target":{target}}}"#,
            bin.len(),
            bytes.len()
        );
        let _ = write!(
            accessors,
            r#"{separator}{{"bufferView":{},"componentType":{component},"count":{n},"type":"{kind}"{extra}}}"#,
            accessors.matches("bufferView").count()
        );
        bin.extend_from_slice(bytes);
        bin.resize(bin.len().next_multiple_of(4), 0);
    };
    let floats = |values: &mut dyn Iterator<Item = f32>| values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| (*p * 0.01).to_array()).collect();
    let (lo, hi) = positions.iter().fold(([f32::MAX; 3], [f32::MIN; 3]), |(lo, hi), p| {
        (std::array::from_fn(|i| lo[i].min(p[i])), std::array::from_fn(|i| hi[i].max(p[i])))
    });
    let n = positions.len();
    add(
        &floats(&mut positions.iter().flatten().copied()),
        34962,
        n,
        5126,
        "VEC3",
        &format!(r#","min":{lo:?},"max":{hi:?}"#),
    );
    add(&floats(&mut mesh.normals.iter().flat_map(glam::Vec3::to_array)), 34962, n, 5126, "VEC3", "");
    add(&floats(&mut mesh.uvs.iter().flat_map(|&[u, v]| [u, 1.0 - v])), 34962, n, 5126, "VEC2", "");
    let mut primitives = String::new();
    let mut materials = String::new();
    for (i, group) in mesh.groups.iter().enumerate() {
        let indices: Vec<u8> = group
            .triangles
            .iter()
            .flat_map(|&t| mesh.triangles[t as usize])
            .flat_map(|v| (v as u16).to_le_bytes())
            .collect();
        add(&indices, 34963, group.triangles.len() * 3, 5123, "SCALAR", "");
        let separator = if i == 0 { "" } else { "," };
        let _ = write!(
            primitives,
            r#"{separator}{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":{},"material":{i}}}"#,
            i + 3
        );
        let _ = write!(materials, r#"{separator}{{"name":"{}"}}"#, group.name);
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0","generator":"cargo xtask bake"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"{name}","mesh":0}}],"meshes":[{{"name":"{name}","primitives":[{primitives}]}}],"materials":[{materials}],"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{}}}]}}"#,
        bin.len()
    );
    lorelei_core::io::to_glb(json, &bin)
}
