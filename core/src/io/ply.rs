//! PLY, ascii and binary, as strands (vertices, then an element `strand` of run lengths) or as a mesh.
//!
//! Elements may come in any order and with any properties; what is not known is skipped. An existing
//! crate was rejected: none checks counts against the file's length before it allocates.

use glam::Vec3;

use super::detect::Format;
use super::error::{Place, ReadError};
use super::import::{MeshImport, RawMesh, RawStrands, StrandImport};
use super::ply_body::{Body, Row};
use super::ply_header::{Element, Header};
use super::source::Source;

/// Whether a PLY file holds strands or a mesh.
pub(crate) fn kind(source: &mut Source<'_>) -> Result<Format, ReadError> {
    source.rewind()?;
    let header = Header::read(source)?;
    source.rewind()?;
    if header.elements.iter().any(|element| element.name == "strand") {
        return Ok(Format::PlyStrands);
    }
    if header.elements.iter().any(|element| element.name == "face" || element.name == "tristrips") {
        return Ok(Format::PlyMesh);
    }
    Err(source.nothing(
        "is a PLY file with neither an element `strand` nor `face`: points alone are no hair",
        "Export strands with their run lengths, or a mesh with faces",
    ))
}

pub(crate) fn read_strands(source: &mut Source<'_>) -> Result<StrandImport, ReadError> {
    source.rewind()?;
    let header = Header::read(source)?;
    let mut raw = RawStrands::default();
    // Numbers as they come: points or segments a strand.
    let mut runs: Vec<u32> = Vec::new();
    let mut body = Body::new(source, &header)?;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                let columns = VertexColumns::find(element, body.source)?;
                raw.strands.points = body.source.reserve(element.n)?;
                if columns.colour.is_some() {
                    raw.strands.colours = body.source.reserve(element.n)?;
                    raw.attributes.push("colour");
                }
                if columns.width.is_some() {
                    raw.thickness = body.source.reserve(element.n)?;
                    raw.attributes.push("thickness");
                }
                body.rows(element, |row| {
                    raw.strands.points.push(columns.position(row));
                    if let Some(colour) = columns.colour(row) {
                        raw.strands.colours.push(colour);
                    }
                    if let Some((column, scale)) = columns.width {
                        raw.thickness.push((row.values[column] * scale) as f32);
                    }
                    Ok(())
                })?;
            }
            "strand" => {
                runs = body.source.reserve(element.n)?;
                let Some(column) = run_column(element) else {
                    return Err(body.source.wrong_kind(
                        "has strands without a property that counts their points or segments",
                        "Write one whole number a strand, such as `property ushort nsegs`",
                    ));
                };
                let mut strand_idx = 0;
                body.rows(element, |row| {
                    // A list property gives its length: the strand's vertices.
                    let value = row.values[column];
                    strand_idx += 1;
                    if value < 0.0 || value > f64::from(u32::MAX) || value.fract() != 0.0 {
                        return Err((
                            Place::Strand(strand_idx - 1, None),
                            format!("has the impossible length {value}"),
                        ));
                    }
                    runs.push(value as u32);
                    Ok(())
                })?;
            }
            // `edge` repeats what the runs say.
            _ => body.skip(element)?,
        }
    }
    raw.strands.offsets = offsets_of_runs(source, &runs, raw.strands.points.len() as u64)?;
    raw.finish(source, Format::PlyStrands)
}

/// Offsets from run lengths that count points or segments: whichever adds up to the vertices.
fn offsets_of_runs(source: &mut Source<'_>, runs: &[u32], n_points: u64) -> Result<Vec<u32>, ReadError> {
    let sum: u64 = runs.iter().map(|&run| u64::from(run)).sum();
    let extra = if sum == n_points {
        0
    } else if sum + runs.len() as u64 == n_points {
        1
    } else {
        return Err(source.corrupt(
            Place::Part("element strand".to_owned()),
            format!(
                "has run lengths that add up to {sum} over {} strands, which fits its {n_points} vertices neither as \
                 points nor as segments,",
                runs.len()
            ),
            "The file is damaged: export it again",
        ));
    };
    let mut offsets = source.reserve(runs.len() as u64 + 1)?;
    offsets.push(0);
    let mut end = 0;
    offsets.extend(runs.iter().map(|&run| {
        end += run + extra;
        end
    }));
    Ok(offsets)
}

fn run_column(element: &Element) -> Option<usize> {
    const NAMES: [&str; 8] =
        ["nsegs", "n_segments", "segments", "nverts", "n_vertices", "npoints", "count", "vertex_indices"];
    let named = NAMES.iter().find_map(|name| element.column(name));
    named.or_else(|| (element.properties.len() == 1).then_some(0))
}

pub(crate) fn read_mesh(source: &mut Source<'_>) -> Result<MeshImport, ReadError> {
    source.rewind()?;
    let header = Header::read(source)?;
    let mut raw = RawMesh::default();
    let mut body = Body::new(source, &header)?;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                let columns = VertexColumns::find(element, body.source)?;
                raw.mesh.positions = body.source.reserve(element.n)?;
                if columns.uv.is_some() {
                    raw.mesh.uvs = body.source.reserve(element.n)?;
                }
                body.rows(element, |row| {
                    raw.mesh.positions.push(columns.position(row));
                    if let Some([u, v]) = columns.uv {
                        raw.mesh.uvs.push([row.values[u] as f32, row.values[v] as f32]);
                    }
                    Ok(())
                })?;
            }
            "face" => {
                let corners = element.column("vertex_indices").or_else(|| element.column("vertex_index"));
                let Some(column) = corners.filter(|&column| element.properties[column].list.is_some()) else {
                    return Err(body.source.wrong_kind(
                        "has faces without a list `vertex_indices`",
                        "Export the mesh again, as PLY, OBJ or GLB",
                    ));
                };
                let mut face_idx = 0u64;
                body.rows(element, |row| {
                    let corners = &row.lists[column];
                    face_idx += 1;
                    if let Some(bad) = corners.iter().find(|&&v| !(0.0..=f64::from(u32::MAX)).contains(&v)) {
                        return Err((
                            Place::Part(format!("face {}", face_idx - 1)),
                            format!("has the impossible corner {bad}"),
                        ));
                    }
                    for pair in corners.get(1..).unwrap_or_default().windows(2) {
                        raw.mesh.triangles.push([corners[0] as u32, pair[0] as u32, pair[1] as u32]);
                    }
                    Ok(())
                })?;
            }
            _ => body.skip(element)?,
        }
    }
    raw.finish(source, Format::PlyMesh)
}

/// Which columns of the vertex element mean what.
struct VertexColumns {
    position: [usize; 3],
    /// Columns, and whether they are bytes in sRGB.
    colour: Option<([usize; 3], f64)>,
    uv: Option<[usize; 2]>,
    /// Column and factor to a diameter.
    width: Option<(usize, f64)>,
}

impl VertexColumns {
    fn find(element: &Element, source: &Source<'_>) -> Result<Self, ReadError> {
        let scalar = |name: &str| element.column(name).filter(|&column| element.properties[column].list.is_none());
        let all3 = |names: [&str; 3]| Some([scalar(names[0])?, scalar(names[1])?, scalar(names[2])?]);
        let all2 = |names: [&str; 2]| Some([scalar(names[0])?, scalar(names[1])?]);
        let Some(position) = all3(["x", "y", "z"]) else {
            return Err(source.wrong_kind("has vertices without x, y and z", "Export it again with positions"));
        };
        let colour = all3(["red", "green", "blue"]).or_else(|| all3(["r", "g", "b"]));
        let uv = [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texcoord_u", "texcoord_v"]];
        let width = [("radius", 2.0), ("width", 1.0), ("thickness", 1.0), ("diameter", 1.0)];
        Ok(Self {
            position,
            colour: colour.map(|columns| (columns, element.properties[columns[0]].scalar.full_scale())),
            uv: uv.into_iter().find_map(all2),
            width: width.into_iter().find_map(|(name, scale)| scalar(name).map(|column| (column, scale))),
        })
    }

    fn position(&self, row: &Row) -> Vec3 {
        let [x, y, z] = self.position.map(|column| row.values[column] as f32);
        Vec3::new(x, y, z)
    }

    /// Linear RGB. Whole numbers are sRGB as in pictures; floats are linear already.
    fn colour(&self, row: &Row) -> Option<[f32; 3]> {
        let (columns, full_scale) = self.colour?;
        let value = columns.map(|column| (row.values[column] / full_scale) as f32);
        Some(if full_scale > 1.0 { value.map(linear_from_srgb) } else { value })
    }
}

/// IEC 61966-2-1.
fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
