//! Lorelei's own hair meshes as OBJ and glTF: plain polygons for other programs, with what it takes to read
//! them back bit for bit.
//!
//! In OBJ that is comments and the names of groups: `o layer_K`, `g bundle_J` before each face, `# bundles N` and
//! `# pinned V..` with a layer's own numbers. In glTF it is the `extras` of the file; its polygons are
//! triangles, and its root node scales centimetres to metres.

use std::fmt::Write as _;
use std::io::{self, Write};

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::polygons::Polygons;
use crate::hair_mesh::{HairMesh, HairMeshLayer};
use crate::io::to_glb;

/// The first line of an OBJ file that was written here.
pub(super) const OBJ_HEAD: &str = "# Lorelei hair mesh, centimetres, Y up";
/// Under this name the glTF's extras hold the hair mesh.
const KEY: &str = "lorelei_hair_mesh";

pub(super) fn write_obj(mesh: &HairMesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{OBJ_HEAD}")?;
    writeln!(out, "# bundles {}", mesh.n_bundles())?;
    let mut first = 1;
    for (k, layer) in mesh.layers.iter().enumerate() {
        writeln!(out, "o layer_{k}")?;
        for p in &layer.positions {
            // The shortest digits that are read as the same number.
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
        if !layer.pinned.is_empty() {
            let numbers: Vec<String> = layer.pinned.iter().map(u32::to_string).collect();
            writeln!(out, "# pinned {}", numbers.join(" "))?;
        }
        for (bundle, face) in layer.faces.iter().enumerate().filter_map(|(b, face)| Some((b, face.as_ref()?))) {
            let corners: Vec<String> = face.iter().map(|v| (v + first).to_string()).collect();
            writeln!(out, "g bundle_{bundle}\nf {}", corners.join(" "))?;
        }
        first += layer.positions.len() as u32;
    }
    Ok(())
}

/// What an OBJ file that was written here says beside its polygons.
#[derive(Default)]
pub(super) struct ObjNotes {
    is_own: bool,
    n_lines: usize,
    n_bundles: usize,
    /// First vertex of each layer.
    layers: Vec<usize>,
    pinned: Vec<(usize, Vec<u32>)>,
}

impl ObjNotes {
    /// Take note of a line; `n_vertices` came before it.
    pub fn see(&mut self, line: &str, n_vertices: usize) {
        self.is_own |= self.n_lines == 0 && line.trim_end() == OBJ_HEAD;
        self.n_lines += 1;
        if !self.is_own {
            return;
        }
        if let Some(n) = line.strip_prefix("# bundles ").and_then(|n| n.trim().parse().ok()) {
            self.n_bundles = n;
        } else if line.starts_with("o layer_") {
            self.layers.push(n_vertices);
        } else if let Some(numbers) = line.strip_prefix("# pinned ") {
            let numbers = numbers.split_whitespace().filter_map(|n| n.parse().ok()).collect();
            self.pinned.push((self.layers.len().saturating_sub(1), numbers));
        }
    }

    /// The hair mesh that was written; `None` where the file was not, or was changed so that it is none.
    pub fn hair_mesh(&self, polygons: &Polygons) -> Option<HairMesh> {
        // A file may announce any number; each bundle has at least one face.
        if !self.is_own || self.layers.first() != Some(&0) || self.n_bundles > 64 * (polygons.faces.len() + 64) {
            return None;
        }
        let ends = self.layers.iter().skip(1).copied().chain([polygons.positions.len()]);
        let mut mesh = HairMesh::default();
        for (k, (&start, end)) in self.layers.iter().zip(ends).enumerate() {
            mesh.layers.push(HairMeshLayer {
                positions: polygons.positions.get(start..end)?.to_vec(),
                faces: vec![None; self.n_bundles],
                pinned: self.pinned.iter().find(|(layer, _)| *layer == k).map(|(_, v)| v.clone()).unwrap_or_default(),
            });
        }
        for face in &polygons.faces {
            let layer: usize = polygons.name(face.object).strip_prefix("layer_")?.parse().ok()?;
            let bundle: usize = polygons.name(face.group).strip_prefix("bundle_")?.parse().ok()?;
            let start = *self.layers.get(layer)? as u32;
            let corners: Option<Vec<u32>> = face.corners.iter().map(|v| v.checked_sub(start)).collect();
            let place = mesh.layers.get_mut(layer)?.faces.get_mut(bundle)?;
            if place.replace(corners?).is_some() {
                return None;
            }
        }
        mesh.check().ok()?;
        Some(mesh)
    }
}

#[derive(Serialize, Deserialize)]
struct GltfNotes {
    n_bundles: usize,
    layers: Vec<GltfLayer>,
}

#[derive(Serialize, Deserialize)]
struct GltfLayer {
    /// Where in the binary chunk its positions begin, as three floats each, in centimetres.
    offset: usize,
    n_vertices: usize,
    /// The bundle, then the corners, of each face.
    faces: Vec<Vec<u32>>,
    pinned: Vec<u32>,
}

/// The parts of a glTF description that matter here.
#[derive(Deserialize)]
struct Extras {
    #[serde(default)]
    extras: Option<GltfExtras>,
}

#[derive(Serialize, Deserialize)]
struct GltfExtras {
    lorelei_hair_mesh: GltfNotes,
}

/// The hair mesh as binary glTF.
pub(super) fn glb(mesh: &HairMesh) -> Result<Vec<u8>, gltf::json::Error> {
    let mut blob: Vec<u8> = Vec::new();
    let (mut views, mut accessors, mut meshes, mut nodes) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut notes = GltfNotes { n_bundles: mesh.n_bundles(), layers: Vec::new() };
    for (k, layer) in mesh.layers.iter().enumerate() {
        let offset = blob.len();
        blob.extend_from_slice(bytemuck::cast_slice(&layer.positions));
        let mut triangles: Vec<u32> = Vec::new();
        for face in layer.faces.iter().flatten() {
            triangles.extend((1..face.len() - 1).flat_map(|i| [face[0], face[i], face[i + 1]]));
        }
        let at_indices = blob.len();
        blob.extend_from_slice(bytemuck::cast_slice(&triangles));
        let with_bundle = |(bundle, face): (usize, &Option<Vec<u32>>)| {
            Some(std::iter::once(bundle as u32).chain(face.as_ref()?.iter().copied()).collect())
        };
        notes.layers.push(GltfLayer {
            offset,
            n_vertices: layer.positions.len(),
            faces: layer.faces.iter().enumerate().filter_map(with_bundle).collect(),
            pinned: layer.pinned.clone(),
        });
        if triangles.is_empty() {
            // glTF knows no empty arrays; the notes keep the layer.
            continue;
        }
        let (lo, hi) =
            layer.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let view = views.len();
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{},\"target\":34962}}",
            at_indices - offset
        ));
        views.push(format!(
            "{{\"buffer\":0,\"byteOffset\":{at_indices},\"byteLength\":{},\"target\":34963}}",
            4 * triangles.len()
        ));
        accessors.push(format!(
            "{{\"bufferView\":{view},\"componentType\":5126,\"count\":{},\"type\":\"VEC3\",\"min\":[{},{},{}],\"max\":[{},{},{}]}}",
            layer.positions.len(), lo.x, lo.y, lo.z, hi.x, hi.y, hi.z
        ));
        accessors.push(format!(
            "{{\"bufferView\":{},\"componentType\":5125,\"count\":{},\"type\":\"SCALAR\"}}",
            view + 1,
            triangles.len()
        ));
        meshes.push(format!(
            "{{\"name\":\"layer_{k}\",\"primitives\":[{{\"attributes\":{{\"POSITION\":{view}}},\"indices\":{}}}]}}",
            view + 1
        ));
        nodes.push(format!("{{\"name\":\"layer_{k}\",\"mesh\":{}}}", meshes.len() - 1));
    }
    let children: Vec<String> = (0..nodes.len()).map(|node| node.to_string()).collect();
    nodes.push(format!("{{\"name\":\"hair mesh\",\"scale\":[0.01,0.01,0.01],\"children\":[{}]}}", children.join(",")));
    let extras = gltf::json::serialize::to_string(&GltfExtras { lorelei_hair_mesh: notes })?;
    let mut json = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        json,
        "{{\"asset\":{{\"version\":\"2.0\",\"generator\":\"Lorelei {}\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[{}]}}],\
         \"nodes\":[{}],\"meshes\":[{}],\"accessors\":[{}],\"bufferViews\":[{}],\"buffers\":[{{\"byteLength\":{}}}],\
         \"extras\":{extras}}}",
        env!("CARGO_PKG_VERSION"),
        nodes.len() - 1,
        nodes.join(","),
        meshes.join(","),
        accessors.join(","),
        views.join(","),
        blob.len(),
    );
    Ok(to_glb(json, &blob))
}

/// The hair mesh in a glTF's description and binary chunk that were written here; `None` where there is none.
pub(super) fn from_gltf(json: &[u8], blob: &[u8]) -> Option<HairMesh> {
    // Quick to tell for other files, which are not read twice.
    if !json.windows(KEY.len()).any(|window| window == KEY.as_bytes()) {
        return None;
    }
    let Extras { extras } = gltf::json::deserialize::from_slice(json).ok()?;
    let notes = extras?.lorelei_hair_mesh;
    let n_faces: usize = notes.layers.iter().map(|layer| layer.faces.len()).sum();
    if notes.n_bundles > 64 * (n_faces + 64) {
        return None;
    }
    let mut mesh = HairMesh::default();
    for layer in notes.layers {
        let end = layer.offset.checked_add(layer.n_vertices.checked_mul(12)?)?;
        let bytes = blob.get(layer.offset..end)?;
        let float = |at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let positions = (0..layer.n_vertices).map(|v| Vec3::from_array([0, 4, 8].map(|k| float(12 * v + k))));
        let mut faces = vec![None; notes.n_bundles];
        for face in layer.faces {
            let (&bundle, corners) = face.split_first()?;
            *faces.get_mut(bundle as usize)? = Some(corners.to_vec());
        }
        mesh.layers.push(HairMeshLayer { positions: positions.collect(), faces, pinned: layer.pinned });
    }
    mesh.check().ok()?;
    Some(mesh)
}
