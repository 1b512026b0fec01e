//! Polygons with the names of their parts, from an OBJ or glTF file: what hair meshes are made of.
//!
//! The readers of heads make triangles; a hair mesh needs the polygons as they were drawn, so OBJ is read
//! anew here. glTF has only triangles: there they are.

use std::collections::HashMap;

use glam::Vec3;

use super::super::error::{Place, ReadError};
use super::super::source::Source;
use crate::mesh::TriMesh;

/// Longest line of an OBJ file.
const MAX_LINE: usize = 1 << 22;

/// Polygons in the numbers of their file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Polygons {
    pub positions: Vec<Vec3>,
    pub faces: Vec<Polygon>,
    /// Names of objects and groups in the order in which they come first.
    pub names: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polygon {
    pub corners: Vec<u32>,
    /// The object and the group that the face is in, as indices into the names.
    pub object: Option<usize>,
    pub group: Option<usize>,
}

impl Polygons {
    pub fn name(&self, idx: Option<usize>) -> &str {
        idx.and_then(|idx| self.names.get(idx)).map_or("", String::as_str)
    }

    fn name_idx(&mut self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        })
    }

    /// Faces as they are in an OBJ file; `each_line` is told of every line first.
    pub fn of_obj(source: &mut Source<'_>, mut each_line: impl FnMut(&str, usize)) -> Result<Self, ReadError> {
        source.rewind()?;
        let mut polygons = Self::default();
        let (mut object, mut group) = (None, None);
        let mut line = String::new();
        let mut line_idx = 0;
        while source.line(&mut line, MAX_LINE)? {
            line_idx += 1;
            each_line(&line, polygons.positions.len());
            let bad = |source: &Source<'_>, problem: &str| {
                source.corrupt(Place::Line(line_idx), problem, "Correct the line in a text editor, or export it again")
            };
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let numbers: Vec<f32> = words.take(3).filter_map(|word| word.parse().ok()).collect();
                    let &[x, y, z] = numbers.as_slice() else {
                        return Err(bad(source, "has a vertex that is not three numbers"));
                    };
                    let p = Vec3::new(x, y, z);
                    if !p.is_finite() || p.abs().max_element() > 1e9 {
                        return Err(bad(source, "has a vertex that is at no place"));
                    }
                    polygons.positions.push(p);
                }
                Some("f") => {
                    let n = polygons.positions.len() as i64;
                    let corner = |word: &str| -> Option<u32> {
                        let index: i64 = word.split('/').next()?.parse().ok()?;
                        let index = if index < 0 { n.checked_add(index)? } else { index - 1 };
                        (0..n).contains(&index).then_some(index as u32)
                    };
                    let corners: Option<Vec<u32>> = words.map(corner).collect();
                    let Some(mut corners) = corners else {
                        return Err(bad(source, "has a face with a corner that does not exist"));
                    };
                    corners.dedup();
                    if corners.len() > 1 && corners.first() == corners.last() {
                        corners.pop();
                    }
                    if corners.len() >= 3 {
                        polygons.faces.push(Polygon { corners, object, group });
                    }
                }
                Some("o") => object = Some(polygons.name_idx(line.trim_start()[1..].trim())),
                Some("g") => group = Some(polygons.name_idx(line.trim_start()[1..].trim())),
                Some(_) | None => {}
            }
        }
        Ok(polygons)
    }

    /// The triangles of a mesh by its groups; vertices of a group at one place become one.
    pub fn of_triangles(mesh: &TriMesh) -> Self {
        let mut polygons = Self::default();
        let mut vertex_at: HashMap<(usize, [u32; 3]), u32> = HashMap::new();
        for group in &mesh.groups {
            let idx = polygons.name_idx(&group.name);
            for &triangle_idx in &group.triangles {
                let mut corners = Vec::with_capacity(3);
                for p in mesh.corners(triangle_idx as usize) {
                    let vertex = *vertex_at.entry((idx, p.to_array().map(f32::to_bits))).or_insert_with(|| {
                        polygons.positions.push(p);
                        polygons.positions.len() as u32 - 1
                    });
                    if !corners.contains(&vertex) {
                        corners.push(vertex);
                    }
                }
                if corners.len() == 3 {
                    polygons.faces.push(Polygon { corners, object: Some(idx), group: None });
                }
            }
        }
        polygons
    }
}
