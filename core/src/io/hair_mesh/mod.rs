//! Hair meshes in and out as polygon files: OBJ and glTF.
//!
//! A file that was written here comes back as it was. Of a mesh from elsewhere the layers are found by the
//! names of its parts (`layer_0`, `layer_1`, ..), by parts that are alike, or by following quads up from the
//! faces that lie on the scalp; the import says in words which it was and what it found.

mod follow;
mod layers;
mod own;
mod polygons;

#[cfg(test)]
mod tests;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::atomic::write_atomically;
use super::detect::{Format, detect_source, extension};
use super::error::{ReadError, WriteError};
use super::groom::ImportOptions;
use super::source::{Source, Watch};
use super::space::{Axis, Space, Unit, transform_points};
use super::{gltf_mesh, obj};
use crate::hair_mesh::HairMesh;
use crate::mesh::TriMesh;
use crate::mesh_query::MeshQuery;
use polygons::Polygons;

/// What hair meshes are written as.
pub const HAIR_MESH_EXTENSIONS: &[&str] = &["obj", "glb"];

/// A hair mesh from a file, in head space.
#[derive(Debug, Clone, PartialEq)]
pub struct HairMeshImport {
    pub path: PathBuf,
    pub mesh: HairMesh,
    pub space: Space,
    /// How the space was found, for people.
    pub space_reason: String,
    /// What the file was found to hold, for people: how layers were told apart, how many there are.
    pub found: Vec<String>,
}

/// Read a hair mesh from .obj, .gltf or .glb. `head` tells where the scalp is and which unit fits.
pub fn read_hair_mesh(
    path: &Path,
    head: Option<&TriMesh>,
    options: ImportOptions,
    watch: Watch<'_>,
) -> Result<HairMeshImport, ReadError> {
    let mut source = Source::open(path, watch)?;
    let format = detect_source(&mut source)?;
    let own = Space::default();
    let imported = |mesh: HairMesh, space: Space, space_reason: String, found: Vec<String>| {
        Ok(HairMeshImport { path: path.to_owned(), mesh, space, space_reason, found })
    };
    let as_written = |mesh: &HairMesh| {
        vec![format!(
            "a hair mesh as Lorelei writes it: {} layers, {} bundles, {} vertices",
            mesh.layers.len(),
            mesh.n_bundles(),
            mesh.n_vertices()
        )]
    };
    let (polygons, guess, reason) = match format {
        Format::Obj => {
            let mut notes = own::ObjNotes::default();
            let polygons = Polygons::of_obj(&mut source, |line, n_vertices| notes.see(line, n_vertices))?;
            if let Some(mesh) = notes.hair_mesh(&polygons) {
                let found = as_written(&mesh);
                return imported(mesh, own, "written by Lorelei".to_owned(), found);
            }
            let import = obj::read(&mut source)?;
            (polygons, import.space, import.space_reason)
        }
        Format::Gltf => {
            source.rewind()?;
            let bytes = source.rest()?;
            if bytes.starts_with(b"glTF")
                && let Ok((json, Some(blob))) = gltf_mesh::split_glb(&source, &bytes)
                && let Some(mesh) = own::from_gltf(json, blob)
            {
                let found = as_written(&mesh);
                return imported(mesh, own, "written by Lorelei".to_owned(), found);
            }
            let import = gltf_mesh::read(&mut source)?;
            (Polygons::of_triangles(&import.mesh), import.space, import.space_reason)
        }
        Format::PlyMesh
        | Format::Hair
        | Format::Tfx
        | Format::Data
        | Format::Bin
        | Format::PlyStrands
        | Format::Usda
        | Format::Lorelei => {
            return Err(source.wrong_kind(
                format!("is a {}, not polygons with layers", format.label()),
                "A hair mesh is read from .obj, .gltf or .glb",
            ));
        }
    };
    if polygons.faces.is_empty() {
        return Err(source.nothing("holds no polygons", "Check the export: was the hair's mesh selected?"));
    }
    let query = head.and_then(|head| MeshQuery::new(head).ok());
    let (space, space_reason) = space_on_head(&polygons, query.as_ref(), guess, reason, options);
    let mut placed = polygons;
    transform_points(space.world_from_file(), &mut placed.positions);
    let by_parts = layers::by_names(&placed).or_else(|| layers::by_groups(&placed, query.as_ref()));
    let found = match (by_parts, head, &query) {
        (Some(found), ..) => found,
        (None, Some(head), Some(query)) => follow::follow(&placed, head, query),
        (None, ..) => {
            Err("its parts are not layers, and there is no head to follow them up from: import onto a head, or \
             name the parts layer_0, layer_1, .."
                .to_owned())
        }
    };
    match found {
        Ok((mesh, found)) => imported(mesh, space, space_reason, found),
        Err(problem) => Err(ReadError::Nothing {
            path: path.to_owned(),
            what: format!("is no hair mesh: {problem}"),
            next: "docs/hair-mesh-files.md says how polygons become hair meshes".to_owned(),
        }),
    }
}

/// How far the nearest quarter of the vertices may be from the head on average, in centimetres.
const ON_HEAD: f32 = 1.0;
/// Hair is between stubble and a cape, in centimetres.
const HAIR_SIZE: std::ops::RangeInclusive<f32> = 1.5..=250.0;

/// The space that puts the polygons' nearest vertices onto the head; else the guess.
fn space_on_head(
    polygons: &Polygons,
    head: Option<&MeshQuery>,
    guess: Space,
    reason: String,
    options: ImportOptions,
) -> (Space, String) {
    let decided = options.decide(guess);
    let is_open = |unit: Unit, up: Axis| {
        options.unit.is_none_or(|asked| asked == unit) && options.up.is_none_or(|asked| asked == up)
    };
    let ups = [guess.up, Axis::Y, Axis::Z];
    let others = ups.into_iter().flat_map(|up| Unit::ALL.into_iter().map(move |unit| (unit, up)));
    let all = std::iter::once((decided.unit, decided.up)).chain(others).filter(|&(unit, up)| is_open(unit, up));
    let distance = |space: Space| -> Option<(f32, Space)> {
        let head = head?;
        let mut points = polygons.positions.clone();
        transform_points(space.world_from_file(), &mut points);
        let (lo, hi) = points.iter().fold((points[0], points[0]), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        if !HAIR_SIZE.contains(&(hi - lo).max_element()) {
            return None;
        }
        let step = points.len().div_ceil(2000);
        let mut far: Vec<f32> = points.iter().step_by(step).map(|&p| head.closest(p).distance).collect();
        far.sort_unstable_by(f32::total_cmp);
        let nearest = &far[..far.len().div_ceil(4)];
        let distance = nearest.iter().sum::<f32>() / nearest.len() as f32;
        (distance <= ON_HEAD).then_some((distance, space))
    };
    let spaces = all.map(|(unit, up)| options.decide(Space { unit, ..guess }.with_up(up)));
    let fitting: Vec<(f32, Space)> = spaces.filter_map(distance).collect();
    // The first unit that fits, since a smaller one may lie on the neck; with the axis that fits best.
    let of_unit = fitting.iter().filter(|(_, space)| space.unit == fitting[0].1.unit);
    match of_unit.min_by(|a, b| a.0.total_cmp(&b.0)) {
        Some(&(_, space)) if space != decided => (space, format!("{}: so it lies on the head", space.describe())),
        Some(_) | None => (decided, options.reason(guess, reason)),
    }
}

/// Write a hair mesh as .obj or .glb, in centimetres and metres, Y up. It is read back as it is.
pub fn write_hair_mesh(path: &Path, mesh: &HairMesh) -> Result<(), WriteError> {
    let refused =
        |problem: String, next: &str| WriteError::Refused { path: path.to_owned(), problem, next: next.to_owned() };
    if mesh.layers.is_empty() {
        return Err(refused("the hair mesh has no layers".to_owned(), "Begin one on the scalp first"));
    }
    mesh.check().map_err(|error| refused(error.to_string(), "This is a bug: save the document and report it"))?;
    match extension(path).as_str() {
        "obj" => write_atomically(path, |out| own::write_obj(mesh, out)),
        "glb" => {
            let bytes = own::glb(mesh).map_err(|error| refused(error.to_string(), "Write .obj instead"))?;
            write_atomically(path, |out| out.write_all(&bytes))
        }
        _ => Err(refused(
            "hair meshes are not written in a format of this name".to_owned(),
            "Let the name end in .obj or .glb",
        )),
    }
}
