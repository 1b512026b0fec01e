//! The manifest: the groom without its large arrays, and the list of those arrays.
//!
//! The groom's own types are written with their arrays emptied, so that a new plain field needs no
//! change here. A second set of structs for the file was rejected: it repeats every field, and nothing
//! would notice one that was forgotten.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::error::DocumentError;
use crate::groom::{Groom, Source};
use crate::hair_mesh::{HairMesh, HairMeshLayer};
use crate::maps::{MapKind, ScalpMap};
use crate::mesh::TriMesh;
use crate::panorama::Panorama;
use crate::sculpt::Sculpt;
use crate::strands::Strands;

/// The version that is written.
///
/// To change the file so that older programs would misread it: raise this, keep the old shape as a struct
/// of its own beside [`Manifest`], and give [`Manifest::parse`] an arm that turns it into today's. New
/// fields need no new version: what a file lacks gets its default, what is unknown is passed over.
pub const VERSION: u32 = 2;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Manifest {
    pub version: u32,
    /// Program and version that wrote it.
    #[serde(default)]
    pub made_by: String,
    pub groom: Groom,
    /// Every array beside the manifest, by its name in the archive.
    pub arrays: Vec<ArrayInfo>,
}

/// One array: `n` numbers of four bytes, or texels of a map.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ArrayInfo {
    pub name: String,
    pub n: u64,
}

/// Version 1, before there were other maps than a density: it had a field of its own.
mod version_1 {
    use std::sync::Arc;

    use serde::Deserialize;

    use super::{Manifest, MapKind, ScalpMap};
    use crate::groom::StrandCount;

    #[derive(Deserialize)]
    struct V1 {
        groom: Densities,
    }

    #[derive(Deserialize)]
    struct Densities {
        #[serde(default)]
        layers: Vec<Density>,
    }

    #[derive(Deserialize)]
    struct Density {
        #[serde(default)]
        density: Option<Size>,
    }

    #[derive(Deserialize)]
    struct Size {
        width: u32,
        height: u32,
    }

    pub(super) fn parse(text: &str) -> ron::error::SpannedResult<Manifest> {
        // Everything else is as it was; the map's array has kept its name.
        let mut manifest: Manifest = ron::from_str(text)?;
        let old: V1 = ron::from_str(text)?;
        for (layer, old) in manifest.groom.layers.iter_mut().zip(old.groom.layers) {
            if let Some(Size { width, height }) = old.density {
                layer.maps.insert(MapKind::Density, Arc::new(ScalpMap::without_texels(width, height)));
                layer.count = StrandCount::Total;
            }
        }
        Ok(manifest)
    }
}

/// What can be read of a manifest of any version.
#[derive(Deserialize)]
struct AnyVersion {
    version: u32,
    #[serde(default)]
    made_by: String,
}

impl Manifest {
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self, DocumentError> {
        let damaged = |error: ron::error::SpannedError| {
            DocumentError::entry(path, "manifest.ron", format!("not understood at {error}"))
        };
        let AnyVersion { version, made_by } = ron::from_str(text).map_err(damaged)?;
        match version {
            2 => ron::from_str(text).map_err(damaged),
            1 => version_1::parse(text).map_err(damaged),
            0 => Err(DocumentError::entry(path, "manifest.ron", "has version 0, which never existed")),
            3.. => Err(DocumentError::TooNew { path: path.to_owned(), version, made_by }),
        }
    }

    pub(super) fn to_text(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(7))
    }
}

/// An array of the groom under the name it has in the archive.
pub(super) struct Part<'g> {
    pub name: String,
    pub content: Content<'g>,
}

pub(super) enum Content<'g> {
    Floats(&'g [f32]),
    Whole(std::borrow::Cow<'g, [u32]>),
    Map(&'g ScalpMap),
}

impl Content<'_> {
    pub(super) fn n(&self) -> u64 {
        match self {
            Self::Floats(values) => values.len() as u64,
            Self::Whole(values) => values.len() as u64,
            Self::Map(map) => u64::from(map.width()) * u64::from(map.height()),
        }
    }
}

/// A groom taken apart for writing.
pub(super) struct Parts<'g> {
    pub manifest: Manifest,
    pub arrays: Vec<Part<'g>>,
}

/// Take a groom apart.
pub(super) fn split(groom: &Groom) -> Parts<'_> {
    let mut arrays = Vec::new();
    if let Some(head) = groom.head.as_ref().filter(|head| head.embedded.is_none()) {
        put_mesh(&mut arrays, &head.mesh);
    }
    if let Some(panorama) = &groom.panorama {
        arrays.push(Part { name: PANORAMA.to_owned(), content: Content::Floats(&panorama.texels) });
    }
    for (layer_idx, layer) in groom.layers.iter().enumerate() {
        match &layer.source {
            Source::HairMesh(hair_mesh) => put_hair_mesh(&mut arrays, layer_idx, hair_mesh),
            Source::Guides(strands) | Source::Strands(strands) => put_strands(&mut arrays, layer_idx, strands),
        }
        put_sculpt(&mut arrays, layer_idx, &layer.sculpt);
        for (kind, map) in &layer.maps {
            arrays.push(Part { name: map_name(layer_idx, kind), content: Content::Map(map) });
        }
    }
    arrays.retain(|part| part.content.n() > 0);
    let infos = arrays.iter().map(|part| ArrayInfo { name: part.name.clone(), n: part.content.n() }).collect();
    let manifest = Manifest {
        version: VERSION,
        made_by: concat!("Lorelei ", env!("CARGO_PKG_VERSION")).to_owned(),
        groom: emptied(groom),
        arrays: infos,
    };
    Parts { manifest, arrays }
}

/// The groom with its arrays emptied; what is not an array stays.
fn emptied(groom: &Groom) -> Groom {
    let mut light = groom.clone();
    if let Some(head) = &mut light.head {
        let mut mesh = TriMesh::default();
        if head.embedded.is_none() {
            mesh.groups.clone_from(&head.mesh.groups);
        }
        mesh.groups.iter_mut().for_each(|group| group.triangles = Vec::new());
        head.mesh = Arc::new(mesh);
    }
    if let Some(panorama) = &mut light.panorama {
        *panorama = Arc::new(Panorama { texels: Vec::new(), ..Panorama::clone(panorama) });
    }
    for layer in &mut light.layers {
        layer.source = match &layer.source {
            Source::HairMesh(hair_mesh) => {
                let layers = vec![HairMeshLayer::default(); hair_mesh.layers.len()];
                Source::HairMesh(Arc::new(HairMesh { layers }))
            }
            Source::Guides(_) => Source::Guides(Arc::new(Strands::default())),
            Source::Strands(_) => Source::Strands(Arc::new(Strands::default())),
        };
        layer.sculpt.roots = Arc::default();
        for sculpt in &mut layer.sculpt.layers {
            sculpt.strokes = Arc::default();
        }
        for map in layer.maps.values_mut() {
            *map = Arc::new(ScalpMap::without_texels(map.width(), map.height()));
        }
    }
    light
}

fn put_mesh<'g>(arrays: &mut Vec<Part<'g>>, mesh: &'g TriMesh) {
    let mut floats = |name: &str, values: &'g [f32]| {
        arrays.push(Part { name: format!("head/{name}.f32"), content: Content::Floats(values) });
    };
    floats("positions", bytemuck::cast_slice(&mesh.positions));
    floats("normals", bytemuck::cast_slice(&mesh.normals));
    floats("uvs", bytemuck::cast_slice(&mesh.uvs));
    let mut whole = |name: String, values: &'g [u32]| {
        arrays.push(Part { name, content: Content::Whole(values.into()) });
    };
    whole("head/triangles.u32".to_owned(), bytemuck::cast_slice(&mesh.triangles));
    for (group_idx, group) in mesh.groups.iter().enumerate() {
        whole(group_name(group_idx), &group.triangles);
    }
}

fn put_strands<'g>(arrays: &mut Vec<Part<'g>>, layer_idx: usize, strands: &'g Strands) {
    let mut put = |name: &str, content: Content<'g>| {
        arrays.push(Part { name: strands_name(layer_idx, name), content });
    };
    put("points.f32", Content::Floats(bytemuck::cast_slice(&strands.points)));
    put("offsets.u32", Content::Whole((&strands.offsets).into()));
    put("ids.u32", Content::Whole((&strands.ids).into()));
    put("radii_um.f32", Content::Floats(&strands.radii_um));
    put("colours.f32", Content::Floats(bytemuck::cast_slice(&strands.colours)));
    put("opacities.f32", Content::Floats(&strands.opacities));
    put("root_uvs.f32", Content::Floats(bytemuck::cast_slice(&strands.root_uvs)));
}

fn put_sculpt<'g>(arrays: &mut Vec<Part<'g>>, layer_idx: usize, sculpt: &'g Sculpt) {
    let mut put = |name: &str, content: Content<'g>| {
        arrays.push(Part { name: sculpt_name(layer_idx, name), content });
    };
    put("roots.f32", Content::Floats(bytemuck::cast_slice(&sculpt.roots.positions)));
    put("uvs.f32", Content::Floats(bytemuck::cast_slice(&sculpt.roots.uvs)));
    for (sculpt_idx, layer) in sculpt.layers.iter().enumerate() {
        put(&format!("{sculpt_idx}/ids.u32"), Content::Whole((&layer.strokes.ids).into()));
        let guides = Content::Floats(bytemuck::cast_slice(&layer.strokes.guides));
        put(&format!("{sculpt_idx}/guides.f32"), guides);
    }
}

fn put_hair_mesh<'g>(arrays: &mut Vec<Part<'g>>, layer_idx: usize, hair_mesh: &'g HairMesh) {
    for (k, layer) in hair_mesh.layers.iter().enumerate() {
        let positions = Content::Floats(bytemuck::cast_slice(&layer.positions));
        arrays.push(Part { name: hair_mesh_name(layer_idx, k, "positions.f32"), content: positions });
        let faces = Content::Whole(flat_faces(&layer.faces).into());
        arrays.push(Part { name: hair_mesh_name(layer_idx, k, "faces.u32"), content: faces });
        let pinned = Content::Whole((&layer.pinned).into());
        arrays.push(Part { name: hair_mesh_name(layer_idx, k, "pinned.u32"), content: pinned });
    }
}

/// Stands for a bundle that has no face in a layer.
const NO_FACE: u32 = u32::MAX;

/// Each face as its corner count and its corners.
fn flat_faces(faces: &[Option<Vec<u32>>]) -> Vec<u32> {
    let mut flat = Vec::new();
    for face in faces {
        match face {
            Some(corners) => {
                flat.push(corners.len() as u32);
                flat.extend_from_slice(corners);
            }
            None => flat.push(NO_FACE),
        }
    }
    flat
}

/// The faces again; `None` where the counts do not add up.
pub(super) fn faces_of(flat: &[u32]) -> Option<Vec<Option<Vec<u32>>>> {
    let mut faces = Vec::new();
    let mut at = 0;
    while at < flat.len() {
        if flat[at] == NO_FACE {
            faces.push(None);
            at += 1;
            continue;
        }
        let end = (at + 1).checked_add(flat[at] as usize)?;
        faces.push(Some(flat.get(at + 1..end)?.to_vec()));
        at = end;
    }
    Some(faces)
}

/// The texels of the picture of what is all around.
pub(super) const PANORAMA: &str = "panorama.f32";

pub(super) fn group_name(group_idx: usize) -> String {
    format!("head/groups/{group_idx}.u32")
}

pub(super) fn strands_name(layer_idx: usize, name: &str) -> String {
    format!("layers/{layer_idx}/strands/{name}")
}

pub(super) fn sculpt_name(layer_idx: usize, name: &str) -> String {
    format!("layers/{layer_idx}/sculpt/{name}")
}

pub(super) fn hair_mesh_name(layer_idx: usize, k: usize, name: &str) -> String {
    format!("layers/{layer_idx}/hair_mesh/{k}/{name}")
}

/// A mask's own name may hold anything: what is no letter or digit is written as its number.
pub(super) fn map_name(layer_idx: usize, kind: &MapKind) -> String {
    let escaped = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '-' => c.to_string(),
        _ => format!("%{:x}.", u32::from(c)),
    };
    let word = kind.to_string();
    let name = match word.split_once(':') {
        Some((kind, of)) => format!("{kind}_{}", of.chars().map(escaped).collect::<String>()),
        None => word,
    };
    format!("layers/{layer_idx}/{name}.png")
}
