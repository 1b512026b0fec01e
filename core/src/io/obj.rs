//! Heads as Wavefront OBJ, parsed by tobj line by line, so that an error knows its line.

use std::cell::{Cell, RefCell};
use std::io::{self, BufRead, Read};

use glam::Vec3;

use super::detect::Format;
use super::error::{Place, ReadError};
use super::import::{MeshImport, RawMesh};
use super::source::Source;
use crate::mesh::FaceGroup;

/// Longest line; a face of many thousand corners still fits.
const MAX_LINE: usize = 1 << 22;

pub(crate) fn read(source: &mut Source<'_>) -> Result<MeshImport, ReadError> {
    source.rewind()?;
    let line_idx = Cell::new(0);
    let read_error = RefCell::new(None);
    let mut lines =
        Lines { source, line: Vec::new(), at: 0, line_idx: &line_idx, error: &read_error, seen: Seen::default() };
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..tobj::LoadOptions::default() };
    // Materials say nothing about shape: an empty library stands for every `mtllib`.
    let loaded = tobj::load_obj_buf(&mut lines, &options, |_| Ok(Default::default()));
    if let Some(error) = read_error.take() {
        return Err(error);
    }
    let (models, _) = loaded.map_err(|error| {
        source.corrupt(
            Place::Line(line_idx.get()),
            explain(error),
            "Correct the line in a text editor, or export the mesh again",
        )
    })?;
    let mut raw = RawMesh::default();
    let has_uvs = models.iter().all(|model| model.mesh.texcoords.len() / 2 == model.mesh.positions.len() / 3);
    for model in models {
        let mesh = model.mesh;
        let first = raw.mesh.positions.len() as u32;
        let first_triangle = raw.mesh.triangles.len() as u32;
        raw.mesh.positions.extend(mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        if has_uvs {
            raw.mesh.uvs.extend(mesh.texcoords.chunks_exact(2).map(|uv| [uv[0], uv[1]]));
        }
        // Lines and points among the faces keep their arity; triangulation left only triangles else.
        raw.mesh.triangles.extend(triangles(&mesh.indices, &mesh.face_arities).map(|t| t.map(|v| v + first)));
        let end = raw.mesh.triangles.len() as u32;
        if end > first_triangle {
            push_group(&mut raw.mesh.groups, &model.name, first_triangle..end);
        }
    }
    raw.finish(source, Format::Obj)
}

fn triangles<'i>(indices: &'i [u32], arities: &'i [u32]) -> Box<dyn Iterator<Item = [u32; 3]> + 'i> {
    let corners = |chunk: &[u32]| [chunk[0], chunk[1], chunk[2]];
    if arities.is_empty() {
        return Box::new(indices.chunks_exact(3).map(corners));
    }
    let mut at = 0usize;
    Box::new(arities.iter().filter_map(move |&arity| {
        let face = indices.get(at..at + arity as usize);
        at += arity as usize;
        face.filter(|face| face.len() == 3).map(corners)
    }))
}

/// Append triangles to the group of a name; OBJ files come back to a group as often as they like.
pub(crate) fn push_group(groups: &mut Vec<FaceGroup>, name: &str, triangles: std::ops::Range<u32>) {
    match groups.iter_mut().find(|group| group.name == name) {
        Some(group) => group.triangles.extend(triangles),
        None => groups.push(FaceGroup { name: name.to_owned(), triangles: triangles.collect() }),
    }
}

fn explain(error: tobj::LoadError) -> String {
    match error {
        tobj::LoadError::PositionParseError => "has a vertex that is not three numbers".to_owned(),
        tobj::LoadError::TexcoordParseError => "has a texture coordinate that is not two numbers".to_owned(),
        tobj::LoadError::NormalParseError => "has a normal that is not three numbers".to_owned(),
        tobj::LoadError::FaceParseError => "has a face whose corners are not understood".to_owned(),
        tobj::LoadError::ScalingByZeroError => "has a vertex of weight zero".to_owned(),
        tobj::LoadError::ColorParseError => "has a vertex with a colour that is not understood".to_owned(),
        tobj::LoadError::FaceVertexOutOfBounds => {
            "has, in the faces up to there, a vertex that does not exist".to_owned()
        }
        tobj::LoadError::FaceTexCoordOutOfBounds => {
            "has, in the faces up to there, a texture coordinate that does not exist".to_owned()
        }
        tobj::LoadError::FaceNormalOutOfBounds => {
            "has, in the faces up to there, a normal that does not exist".to_owned()
        }
        other => format!("is not understood: {other}"),
    }
}

/// The source as tobj wants it: line by line, counted, with text that is not UTF-8 replaced.
struct Lines<'s, 'a> {
    source: &'s mut Source<'a>,
    line: Vec<u8>,
    at: usize,
    line_idx: &'s Cell<u64>,
    error: &'s RefCell<Option<ReadError>>,
    seen: Seen,
}

/// How many positions, texture coordinates and normals there are so far.
#[derive(Default)]
struct Seen([i64; 3]);

impl Seen {
    /// Count what a line defines; false where it is a face that refers to before the first of them, or to more than
    /// any file holds. tobj 4.0.5 computes with such an index before it looks whether it is one.
    fn take(&mut self, line: &str) -> bool {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => self.0[0] += 1,
            Some("vt") => self.0[1] += 1,
            Some("vn") => self.0[2] += 1,
            Some("f" | "l" | "p") => {
                let is_there = |(index, n): (&str, &i64)| {
                    // What is no number is refused by tobj.
                    index.parse::<i64>().map_or(true, |index| index >= -n && index <= i64::from(u32::MAX))
                };
                return words.all(|corner| corner.split('/').zip(&self.0).all(is_there));
            }
            Some(_) | None => {}
        }
        true
    }
}

impl BufRead for Lines<'_, '_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.line.len() {
            let mut text = String::from_utf8(std::mem::take(&mut self.line)).unwrap_or_default();
            match self.source.line(&mut text, MAX_LINE) {
                Ok(true) => {
                    text.push('\n');
                    self.line_idx.set(self.line_idx.get() + 1);
                    if !self.seen.take(&text) {
                        self.error.replace(Some(self.source.corrupt(
                            Place::Line(self.line_idx.get()),
                            "has a face with a corner that does not exist",
                            "Correct the line in a text editor, or export the mesh again",
                        )));
                        return Err(io::Error::other("stopped"));
                    }
                }
                Ok(false) => {}
                Err(error) => {
                    self.error.replace(Some(error));
                    return Err(io::Error::other("stopped"));
                }
            }
            self.line = text.into_bytes();
            self.at = 0;
        }
        Ok(&self.line[self.at..])
    }

    fn consume(&mut self, n: usize) {
        self.at += n;
    }
}

impl Read for Lines<'_, '_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(bytes)?;
        self.consume(n);
        Ok(n)
    }
}
