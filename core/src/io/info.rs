//! What `lorelei info` says about a file.

use std::path::Path;

use glam::Vec3;
use serde::Serialize;

use super::detect::{Contents, Format, detect};
use super::error::ReadError;
use super::source::Watch;
use super::space::{Axis, Unit};
use super::{read_mesh, read_strands};
use crate::document::{self, DocumentError};
use crate::groom::{Groom, Source};
use crate::maps::MapKind;

/// A summary of a file. Bounds are in the file's own numbers, `unit` and `up` say what they mean.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    pub format: &'static str,
    pub strands: usize,
    pub points: usize,
    /// Triangles, of a head's mesh.
    pub triangles: usize,
    pub bounds: Bounds,
    /// The same in centimetres, Y up, +Z front.
    pub bounds_cm: Bounds,
    pub unit: Unit,
    pub up: Axis,
    pub front: Axis,
    /// How unit and axes were found.
    pub space_reason: String,
    pub attributes: Vec<&'static str>,
    pub warnings: Vec<String>,
}

#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Bounds {
    pub min: Vec3,
    pub max: Vec3,
}

impl From<(Vec3, Vec3)> for Bounds {
    fn from((min, max): (Vec3, Vec3)) -> Self {
        Self { min, max }
    }
}

/// A file that `info` cannot say anything about.
#[derive(Debug, thiserror::Error)]
pub enum InfoError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Document(#[from] DocumentError),
}

/// Summarise a strand file, a head or a document.
pub fn info(path: &Path, watch: Watch<'_>) -> Result<Info, InfoError> {
    let format = detect(path)?;
    Ok(match format.contents() {
        Contents::Strands => {
            let import = read_strands(path, watch)?;
            let mut strands = Info {
                strands: import.strands.n_strands(),
                points: import.strands.n_points(),
                bounds: import.bounds().into(),
                unit: import.space.unit,
                up: import.space.up,
                front: import.space.front,
                space_reason: import.space_reason.clone(),
                attributes: import.attributes.clone(),
                warnings: import.warnings.clone(),
                ..Info::empty(format)
            };
            let placed = import.place();
            strands.bounds_cm = placed.strands.bounds().unwrap_or_default().into();
            strands.warnings.extend(placed.warnings);
            strands
        }
        Contents::Mesh => {
            let import = read_mesh(path, watch)?;
            let mut mesh = Info {
                points: import.mesh.positions.len(),
                triangles: import.mesh.triangles.len(),
                bounds: import.mesh.bounds().unwrap_or_default().into(),
                unit: import.space.unit,
                up: import.space.up,
                front: import.space.front,
                space_reason: import.space_reason.clone(),
                attributes: import.attributes.clone(),
                warnings: import.warnings.clone(),
                ..Info::empty(format)
            };
            mesh.bounds_cm = import.place().bounds().unwrap_or_default().into();
            mesh
        }
        Contents::Document => of_document(&document::open(path)?),
    })
}

/// Strands are counted as they are drawn; points and bounds are those of what they are made from.
fn of_document(groom: &Groom) -> Info {
    let mut points = Vec::new();
    let mut attributes = Vec::new();
    let mut note = |name: &'static str, is_there: bool| {
        if is_there && !attributes.contains(&name) {
            attributes.push(name);
        }
    };
    for layer in &groom.layers {
        match &layer.source {
            Source::HairMesh(hair_mesh) => {
                points.extend(hair_mesh.layers.iter().flat_map(|layer| layer.positions.iter().copied()));
                note("hair_mesh", true);
            }
            Source::Guides(strands) | Source::Strands(strands) => {
                points.extend_from_slice(&strands.points);
                note("thickness", !strands.radii_um.is_empty());
                note("transparency", !strands.opacities.is_empty());
                note("colour", !strands.colours.is_empty());
                note("root_uv", !strands.root_uvs.is_empty());
            }
        }
        note("density_map", layer.density().is_some());
        note("maps", layer.maps.keys().any(|kind| *kind != MapKind::Density));
    }
    note("head", groom.head.is_some());
    let first = points.first().copied().unwrap_or_default();
    let bounds: Bounds = points.iter().fold((first, first), |(lo, hi), &p| (lo.min(p), hi.max(p))).into();
    Info {
        strands: groom.n_strands(),
        points: points.len(),
        triangles: groom.head.as_ref().map_or(0, |head| head.mesh.triangles.len()),
        bounds,
        bounds_cm: bounds,
        space_reason: "a document is always in centimetres, Y up, +Z front".to_owned(),
        warnings: groom.warnings(),
        attributes,
        ..Info::empty(Format::Lorelei)
    }
}

impl Info {
    fn empty(format: Format) -> Self {
        Self {
            format: format.label(),
            strands: 0,
            points: 0,
            triangles: 0,
            bounds: Bounds::default(),
            bounds_cm: Bounds::default(),
            unit: Unit::Centimetre,
            up: Axis::Y,
            front: Axis::Z,
            space_reason: String::new(),
            attributes: Vec::new(),
            warnings: Vec::new(),
        }
    }
}
