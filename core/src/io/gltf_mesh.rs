//! Heads as glTF 2.0: `.glb`, and `.gltf` with its buffers inside or beside it; every node's transform applied.
//!
//! The gltf crate parses and validates the JSON; buffers and accessors are read here, because its own
//! accessors trust the offsets in the file, and its importer would also decode every texture.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

use glam::{Mat4, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;

use super::detect::Format;
use super::error::{Place, ReadError};
use super::import::{MeshImport, RawMesh};
use super::obj::push_group;
use super::source::{Source, Watch};

/// Nodes above each other, so that the way down fits the stack.
const MAX_DEPTH: usize = 128;

pub(crate) fn read(source: &mut Source<'_>) -> Result<MeshImport, ReadError> {
    source.rewind()?;
    let bytes = source.rest()?;
    let (document, buffers) = parse(source, &bytes)?;
    let mut raw = RawMesh::default();
    let is_visited = vec![false; document.nodes().len()];
    let mut reader = SceneReader { source, buffers: &buffers, raw: &mut raw, has_uvs: true, is_visited };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    match scene {
        Some(scene) => scene.nodes().try_for_each(|node| reader.node(&node, Mat4::IDENTITY, 0))?,
        // A library of meshes without a scene.
        None => document.meshes().try_for_each(|mesh| reader.mesh(&mesh, mesh.name(), Mat4::IDENTITY))?,
    }
    if !reader.has_uvs {
        raw.mesh.uvs = Vec::new();
    }
    if document.skins().len() > 0 {
        raw.warnings.push("the skeleton was left out: the mesh is in its rest pose".to_owned());
    }
    raw.finish(source, Format::Gltf)
}

/// The description of a file, and the bytes that it refers to.
pub(super) fn parse<'b>(source: &mut Source<'_>, bytes: &'b [u8]) -> Result<(gltf::Document, Buffers<'b>), ReadError> {
    let bad = |source: &Source<'_>, problem: String| {
        source.corrupt(Place::Part("its glTF description".to_owned()), problem, "Export it again as GLB")
    };
    let (json, blob) = if bytes.starts_with(b"glTF") { split_glb(source, bytes)? } else { (bytes, None) };
    let mut root: gltf::json::Root =
        gltf::json::deserialize::from_slice(json).map_err(|error| bad(source, format!("is not glTF: {error};")))?;
    // Only the shape is read: what materials, lights and animations require does not matter.
    for extension in std::mem::take(&mut root.extensions_required) {
        if matches!(&*extension, "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression") {
            return Err(source.wrong_kind(
                format!("is compressed with {extension}, which is not read"),
                "Export it again without compression",
            ));
        }
    }
    // The crate's own validation looks these up before it has checked them.
    let n_accessors = root.accessors.len();
    let mut used = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|p| p.attributes.values());
    if let Some(index) = used.find(|index| index.value() >= n_accessors) {
        return Err(bad(source, format!("names accessor {} of {n_accessors};", index.value())));
    }
    let document =
        gltf::Document::from_json(root).map_err(|error| bad(source, format!("is not valid glTF: {error};")))?;
    let buffers = Buffers::load(source, &document, blob)?;
    Ok((document, buffers))
}

/// The JSON and the binary chunk of a GLB. The gltf crate's own function trusts the lengths.
pub(super) fn split_glb<'b>(source: &Source<'_>, bytes: &'b [u8]) -> Result<(&'b [u8], Option<&'b [u8]>), ReadError> {
    const NEXT: &str = "Export it again as GLB of version 2";
    let word = |at: usize| bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let bad = |at: usize, problem: String| source.corrupt(Place::Byte(at as u64), problem, NEXT);
    let (Some(version), Some(length), Some(_)) = (word(4), word(8), word(16)) else {
        return Err(bad(bytes.len(), "ends before its header does".to_owned()));
    };
    if version != 2 {
        return Err(bad(4, format!("is glTF of version {version}, and only version 2 is read;")));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(ReadError::Truncated {
            path: source.path().to_owned(),
            place: Place::Byte(bytes.len() as u64),
            part: "the binary glTF".to_owned(),
            needed: (length - bytes.len()) as u64,
            has: 0,
        });
    }
    let (mut json, mut blob) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let n = word(at).unwrap_or(0) as usize;
        let end = (at + 8).saturating_add(n);
        let Some(chunk) = bytes[..length].get(at + 8..end) else {
            return Err(bad(at, format!("has a chunk of {n} bytes that reaches past its end")));
        };
        match &bytes[at + 4..at + 8] {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if blob.is_none() => blob = Some(chunk),
            _ => {}
        }
        at = end.next_multiple_of(4);
    }
    match json {
        Some(json) => Ok((json, blob)),
        None => Err(bad(12, "has no JSON chunk".to_owned())),
    }
}

/// The bytes of every buffer.
pub(super) struct Buffers<'b>(Vec<Cow<'b, [u8]>>);

impl<'b> Buffers<'b> {
    fn load(source: &mut Source<'_>, document: &gltf::Document, mut blob: Option<&'b [u8]>) -> Result<Self, ReadError> {
        let mut buffers = Vec::new();
        for buffer in document.buffers() {
            let part = || Place::Part(format!("buffer {}", buffer.index()));
            let bytes = match buffer.source() {
                gltf::buffer::Source::Bin => blob.take().map(Cow::Borrowed).ok_or_else(|| {
                    source.corrupt(part(), "has no binary chunk for its buffer", "Export it again as GLB")
                })?,
                gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
                    Some(data) => decode_data_uri(data).map(Cow::Owned).ok_or_else(|| {
                        source.corrupt(part(), "has embedded data that is not base64", "Export it again as GLB")
                    })?,
                    None => Cow::Owned(read_beside(source, uri)?),
                },
            };
            if bytes.len() < buffer.length() {
                return Err(ReadError::Truncated {
                    path: source.path().to_owned(),
                    place: part(),
                    part: "a buffer".to_owned(),
                    needed: buffer.length() as u64,
                    has: bytes.len() as u64,
                });
            }
            buffers.push(bytes);
        }
        Ok(Self(buffers))
    }

    /// The bytes of element `idx` of an accessor; `None` where they are not all there.
    pub(super) fn element(
        &self,
        view: &gltf::buffer::View<'_>,
        offset: usize,
        size: usize,
        idx: usize,
    ) -> Option<&[u8]> {
        // A smaller stride would let few bytes pose as many elements.
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return None;
        }
        let in_view = offset.checked_add(idx.checked_mul(stride)?)?;
        if in_view.checked_add(size)? > view.length() {
            return None;
        }
        let start = view.offset().checked_add(in_view)?;
        self.0.get(view.buffer().index())?.get(start..start.checked_add(size)?)
    }
}

/// Read a buffer file that lies beside the `.gltf`.
fn read_beside(source: &Source<'_>, uri: &str) -> Result<Vec<u8>, ReadError> {
    let name = percent_decoded(uri);
    let relative = Path::new(&name);
    let stays_inside = relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if uri.contains("://") || !stays_inside {
        return Err(source.wrong_kind(
            format!("refers to `{name}`, which is not beside it"),
            "Put all its files into one folder, or export it as GLB",
        ));
    }
    let path: PathBuf = source.path().parent().unwrap_or(Path::new("")).join(relative);
    Source::open(&path, Watch { on_progress: None, ..source.watch() })?.rest()
}

fn percent_decoded(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let hex = text.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        if let Some(byte) = hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            out.push(byte);
            at += 3;
        } else {
            out.push(bytes[at]);
            at += 1;
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

/// The bytes of what follows `data:`; base64 as in RFC 4648, section 4.
fn decode_data_uri(data: &str) -> Option<Vec<u8>> {
    let (_, text) = data.split_once(";base64,")?;
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let (mut bits, mut n_bits) = (0u32, 0);
    for byte in text.trim_end_matches('=').bytes() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => return None,
        };
        bits = bits << 6 | u32::from(value);
        n_bits += 6;
        if n_bits >= 8 {
            n_bits -= 8;
            out.push((bits >> n_bits) as u8);
            bits &= (1 << n_bits) - 1;
        }
    }
    Some(out)
}

struct SceneReader<'r, 'a> {
    source: &'r mut Source<'a>,
    buffers: &'r Buffers<'r>,
    raw: &'r mut RawMesh,
    /// Whether every primitive so far had texture coordinates.
    has_uvs: bool,
    /// Nodes seen; the format forbids a second parent, which could also repeat a mesh without end.
    is_visited: Vec<bool>,
}

impl SceneReader<'_, '_> {
    fn node(&mut self, node: &gltf::Node<'_>, world_from_parent: Mat4, depth: usize) -> Result<(), ReadError> {
        let seen_before = self.is_visited.get_mut(node.index()).is_none_or(|seen| std::mem::replace(seen, true));
        if depth > MAX_DEPTH || seen_before {
            return Err(self.source.corrupt(
                Place::Part(format!("node {}", node.index())),
                format!("has nodes in a loop, under two parents, or nested deeper than {MAX_DEPTH},"),
                "Flatten the scene, or export only the head",
            ));
        }
        let world_from_node = world_from_parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        if let Some(mesh) = node.mesh() {
            self.mesh(&mesh, node.name().or_else(|| mesh.name()), world_from_node)?;
        }
        node.children().try_for_each(|child| self.node(&child, world_from_node, depth + 1))
    }

    fn mesh(&mut self, mesh: &gltf::Mesh<'_>, name: Option<&str>, world_from_node: Mat4) -> Result<(), ReadError> {
        for primitive in mesh.primitives() {
            if primitive.mode() != Mode::Triangles {
                self.raw.warnings.push(format!(
                    "primitive {} of mesh {} is not triangles: left out",
                    primitive.index(),
                    mesh.index()
                ));
                continue;
            }
            let Some(positions) = primitive.get(&gltf::Semantic::Positions) else { continue };
            let part = |what: &str| format!("{what} of mesh {}, primitive {},", mesh.index(), primitive.index());
            let first = self.raw.mesh.positions.len() as u32;
            let n_vertices = positions.count();
            for value in self.floats::<3>(&positions, &part("the positions"))? {
                self.raw.mesh.positions.push(world_from_node.project_point3(Vec3::from_array(value)));
            }
            match primitive.get(&gltf::Semantic::TexCoords(0)).filter(|uvs| uvs.count() == n_vertices) {
                Some(uvs) => {
                    // glTF puts v = 0 at the picture's top; the inside has it at the bottom, as OBJ and PLY do.
                    let uvs = self.floats::<2>(&uvs, &part("the texture coordinates"))?;
                    self.raw.mesh.uvs.extend(uvs.into_iter().map(|[u, v]| [u, 1.0 - v]));
                }
                None => self.has_uvs = false,
            }
            let indices = match primitive.indices() {
                Some(accessor) => self.indices(&accessor, &part("the indices"))?,
                None => (0..n_vertices as u32).collect(),
            };
            let first_triangle = self.raw.mesh.triangles.len() as u32;
            let mirrors = world_from_node.determinant() < 0.0;
            for corners in indices.chunks_exact(3) {
                if let Some(&bad) = corners.iter().find(|&&corner| corner as usize >= n_vertices) {
                    return Err(self.source.corrupt(
                        Place::Part(part("the indices").trim_end_matches(',').to_owned()),
                        format!("refers to vertex {bad} of {n_vertices}"),
                        "Export it again",
                    ));
                }
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(|corner| first + corner);
                self.raw.mesh.triangles.push(if mirrors { [a, c, b] } else { [a, b, c] });
            }
            // A material's name says what a part is; where there is none, the node's name does.
            let name = primitive.material().name().map(str::to_owned).or_else(|| name.map(str::to_owned));
            let name = name.unwrap_or_else(|| format!("mesh {}", mesh.index()));
            let end = self.raw.mesh.triangles.len() as u32;
            push_group(&mut self.raw.mesh.groups, &name, first_triangle..end);
        }
        Ok(())
    }

    fn floats<const N: usize>(
        &mut self,
        accessor: &gltf::Accessor<'_>,
        part: &str,
    ) -> Result<Vec<[f32; N]>, ReadError> {
        let components = match accessor.dimensions() {
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 => 4,
            Dimensions::Scalar | Dimensions::Mat2 | Dimensions::Mat3 | Dimensions::Mat4 => 1,
        };
        if components != N {
            return Err(self.unusable(part, "have the wrong number of components"));
        }
        // Whole numbers, as KHR_mesh_quantization allows; glTF 2.0, 3.6.2.2 says what normalised ones mean.
        let (size, full_scale) = match accessor.data_type() {
            DataType::F32 => (4, 1.0),
            DataType::U8 => (1, 255.0),
            DataType::I8 => (1, 127.0),
            DataType::U16 => (2, 65535.0),
            DataType::I16 => (2, 32767.0),
            DataType::U32 => return Err(self.unusable(part, "are stored in a type that is not read")),
        };
        let data_type = accessor.data_type();
        let scale: f32 = if accessor.normalized() { 1.0 / full_scale } else { 1.0 };
        self.elements(accessor, size * N, part, |bytes| {
            std::array::from_fn(|i| {
                let b = &bytes[i * size..];
                match data_type {
                    DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
                    DataType::U8 | DataType::U32 => f32::from(b[0]) * scale,
                    DataType::I8 => f32::from(b[0] as i8) * scale,
                    DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])) * scale,
                    DataType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])) * scale,
                }
            })
        })
    }

    fn indices(&mut self, accessor: &gltf::Accessor<'_>, part: &str) -> Result<Vec<u32>, ReadError> {
        let size = match accessor.data_type() {
            DataType::U8 => 1,
            DataType::U16 => 2,
            DataType::U32 => 4,
            DataType::I8 | DataType::I16 | DataType::F32 => {
                return Err(self.unusable(part, "are not whole positive numbers"));
            }
        };
        self.elements(accessor, size, part, |bytes| {
            bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
        })
    }

    fn elements<T>(
        &mut self,
        accessor: &gltf::Accessor<'_>,
        size: usize,
        part: &str,
        value: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, ReadError> {
        if accessor.sparse().is_some() {
            return Err(self.unusable(part, "are stored sparsely, which is not read"));
        }
        let Some(view) = accessor.view() else {
            return Err(self.unusable(part, "have no data"));
        };
        let n = accessor.count();
        // The last element decides whether all are there; so the count is checked before anything is reserved.
        let last = n.checked_sub(1).map(|last| self.buffers.element(&view, accessor.offset(), size, last));
        if let Some(None) = last {
            return Err(self.unusable(part, "reach past the end of their buffer"));
        }
        let mut values = self.source.reserve(n as u64)?;
        for idx in 0..n {
            match self.buffers.element(&view, accessor.offset(), size, idx) {
                Some(bytes) => values.push(value(bytes)),
                None => return Err(self.unusable(part, "reach past the end of their buffer")),
            }
        }
        Ok(values)
    }

    fn unusable(&self, part: &str, problem: &str) -> ReadError {
        self.source.corrupt(
            Place::Part(part.trim_end_matches(',').to_owned()),
            format!("has data that cannot be used: they {problem},"),
            "Export it again as GLB, without compression",
        )
    }
}
