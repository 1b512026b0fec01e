//! What an import gives: the file's own numbers, and what they mean.
//!
//! The numbers stay as they were in the file until [`StrandImport::place`]; so a person can correct a
//! wrong guess of unit or axis without reading the file again, and without rounding twice.

use std::path::PathBuf;

use glam::Vec3;

use super::detect::Format;
use super::error::{Place, ReadError};
use super::source::Source;
use super::space::Space;
use crate::mesh::TriMesh;
use crate::strands::Strands;

/// Strands from a file, in the file's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct StrandImport {
    pub path: PathBuf,
    pub format: Format,
    /// Points in the file's unit and axes; `radii_um` is empty. Every strand has two points or more.
    pub strands: Strands,
    /// Per point: diameter in the file's unit, or empty.
    pub thickness: Vec<f32>,
    /// The guessed space; change it before [`StrandImport::place`].
    pub space: Space,
    /// How the space was guessed, for people.
    pub space_reason: String,
    /// What the file holds beside positions: `thickness`, `transparency`, `colour`, `root_uv`, ..
    pub attributes: Vec<&'static str>,
    /// What was dropped or is odd.
    pub warnings: Vec<String>,
}

/// A mesh from a file, in the file's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshImport {
    pub path: PathBuf,
    pub format: Format,
    pub mesh: TriMesh,
    pub space: Space,
    pub space_reason: String,
    /// `normal`, `uv`, `groups`.
    pub attributes: Vec<&'static str>,
    pub warnings: Vec<String>,
}

/// Strands in world space (centimetres, Y up, +Z front).
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedStrands {
    pub strands: Strands,
    /// Median radius at the roots, where the file has widths that can be hair's.
    pub radius_um: Option<f32>,
    pub warnings: Vec<String>,
}

/// Diameters of hair and of the wider strands that stand for several, micrometres. Human hair is
/// 17-180 um (Robbins 2012); thinned grooms are drawn wider, up to a few millimetres.
const PLAUSIBLE_DIAMETER_UM: std::ops::RangeInclusive<f32> = 5.0..=4000.0;

/// Radius that stands for a relative width of 1.
const AVERAGE_RADIUS_UM: f32 = 40.0;

/// No fibre is wider: a damaged number must not become infinite.
const WIDEST_RADIUS_UM: f32 = 1e5;

/// Scale widths to radii in micrometres; says how many were cut to the widest that is kept.
fn radii_of(thickness: Vec<f32>, scale: f32, warnings: &mut Vec<String>) -> Vec<f32> {
    let n_cut = thickness.iter().filter(|&&value| value * scale > WIDEST_RADIUS_UM).count();
    if n_cut > 0 {
        warnings.push(format!("{n_cut} widths are above 10 cm: cut to that"));
    }
    let mut radii_um = thickness;
    for radius in &mut radii_um {
        *radius = (*radius * scale).clamp(0.0, WIDEST_RADIUS_UM);
    }
    radii_um
}

impl StrandImport {
    /// The strands in world space, by the import's `space`.
    pub fn place(self) -> PlacedStrands {
        let Self { mut strands, thickness, space, .. } = self;
        space.place_strands(&mut strands);
        let mut warnings = Vec::new();
        let mut radius_um = None;
        if !thickness.is_empty() {
            let um = space.unit.in_cm() * 1e4;
            let roots = |values: &[f32]| median(strands.offsets.iter().map(|&at| at as usize), values);
            let diameter = roots(&thickness);
            if PLAUSIBLE_DIAMETER_UM.contains(&(diameter * um)) {
                strands.radii_um = radii_of(thickness, 0.5 * um, &mut warnings);
                radius_um = Some(0.5 * um * diameter);
            } else if thickness.iter().all(|&value| value == thickness[0]) || diameter <= 0.0 {
                warnings.push(format!(
                    "the width {} {} is no hair's and the same everywhere: taken as not given",
                    thickness[0],
                    space.unit.name()
                ));
            } else {
                warnings.push(format!(
                    "widths around {} {} are no hair's: kept in proportion, {AVERAGE_RADIUS_UM} um radius in the middle",
                    diameter,
                    space.unit.name()
                ));
                strands.radii_um = radii_of(thickness, AVERAGE_RADIUS_UM / diameter, &mut warnings);
                radius_um = Some(AVERAGE_RADIUS_UM);
            }
        }
        PlacedStrands { strands, radius_um, warnings }
    }

    /// Bounds in the file's numbers.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.strands.bounds().unwrap_or_default()
    }
}

impl MeshImport {
    /// The mesh in world space, by the import's `space`; with normals.
    pub fn place(self) -> TriMesh {
        let Self { mut mesh, space, .. } = self;
        space.place_mesh(&mut mesh);
        if mesh.normals.len() != mesh.positions.len() {
            mesh.compute_normals();
        }
        mesh
    }
}

/// Median of some of the values; 0 where there are none. Indices past the end are left out.
fn median(indices: impl Iterator<Item = usize>, values: &[f32]) -> f32 {
    let mut picked: Vec<f32> = indices.filter_map(|at| values.get(at).copied()).collect();
    if picked.is_empty() {
        return 0.0;
    }
    let middle = picked.len() / 2;
    *picked.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// What a strand reader hands over before it is checked.
#[derive(Default)]
pub(crate) struct RawStrands {
    pub strands: Strands,
    pub thickness: Vec<f32>,
    pub attributes: Vec<&'static str>,
    pub warnings: Vec<String>,
}

impl RawStrands {
    /// Check positions and attributes, drop what is no strand, guess the space.
    pub(crate) fn finish(mut self, source: &Source<'_>, format: Format) -> Result<StrandImport, ReadError> {
        self.check_positions(source)?;
        self.check_attributes();
        let n_in_file = self.strands.n_strands();
        self.drop_what_is_no_strand();
        if self.strands.n_strands() == 0 {
            let what = if n_in_file == 0 {
                "holds no strands".to_owned()
            } else {
                format!("holds {n_in_file} strands, none with a length (fewer than two points, or all at one place)")
            };
            return Err(source.nothing(what, "Check the export: were any curves selected, and were they curves?"));
        }
        let guess = Space::guess(Some(&self.strands), None, Some(format));
        self.warnings.extend(guess.warning);
        Ok(StrandImport {
            path: source.path().to_owned(),
            format,
            strands: self.strands,
            thickness: self.thickness,
            space: guess.space,
            space_reason: guess.reason,
            attributes: self.attributes,
            warnings: self.warnings,
        })
    }

    fn check_positions(&self, source: &Source<'_>) -> Result<(), ReadError> {
        // Beyond this squares overflow f32, and no groom is that large in any unit.
        const LARGEST: f32 = 1e9;
        let is_bad = |p: &Vec3| !p.is_finite() || p.abs().max_element() > LARGEST;
        let Some(bad) = self.strands.points.iter().position(is_bad) else { return Ok(()) };
        let strand = self.strands.offsets.partition_point(|&start| start as usize <= bad) - 1;
        let point = bad - self.strands.offsets[strand] as usize;
        Err(source.corrupt(
            Place::Strand(strand as u64, Some(point as u64)),
            format!("has a position that is no place: {}", self.strands.points[bad]),
            "Remove this strand where the groom was made, or export it again",
        ))
    }

    /// Attributes that are no numbers are left out with a warning: shape matters more than width.
    fn check_attributes(&mut self) {
        let mut drop = |name: &'static str, is_bad: bool| {
            if is_bad {
                self.warnings.push(format!("{name} holds values that are no numbers: left out"));
                self.attributes.retain(|&attribute| attribute != name);
            }
            is_bad
        };
        if drop("thickness", !self.thickness.iter().all(|value| value.is_finite() && *value >= 0.0)) {
            self.thickness = Vec::new();
        }
        if drop("transparency", !self.strands.opacities.iter().all(|value| value.is_finite())) {
            self.strands.opacities = Vec::new();
        }
        if drop("colour", !self.strands.colours.iter().flatten().all(|value| value.is_finite())) {
            self.strands.colours = Vec::new();
        }
        if drop("root_uv", !self.strands.root_uvs.iter().flatten().all(|value| value.is_finite())) {
            self.strands.root_uvs = Vec::new();
        }
        self.strands.opacities.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
    }

    /// Drop strands of fewer than two points or without length. Those that stay keep their index in the
    /// file as their id.
    fn drop_what_is_no_strand(&mut self) {
        let strands = &mut self.strands;
        let n_strands = strands.n_strands();
        let (mut n_short, mut n_without_length) = (0usize, 0usize);
        let keep: Vec<bool> = (0..n_strands)
            .map(|strand_idx| {
                let points = strands.strand(strand_idx);
                let has_length = points.iter().any(|p| *p != points[0]);
                n_short += usize::from(points.len() < 2);
                n_without_length += usize::from(points.len() >= 2 && !has_length);
                has_length
            })
            .collect();
        if n_short + n_without_length == 0 {
            return;
        }
        strands.ids = (0..n_strands as u32).filter(|&strand_idx| keep[strand_idx as usize]).collect();
        keep_strands(&mut strands.root_uvs, &keep);
        let offsets = std::mem::take(&mut strands.offsets);
        keep_points(&mut strands.points, &offsets, &keep);
        keep_points(&mut strands.colours, &offsets, &keep);
        keep_points(&mut strands.opacities, &offsets, &keep);
        keep_points(&mut self.thickness, &offsets, &keep);
        strands.offsets = vec![0];
        let mut end = 0;
        for (strand_idx, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            end += offsets[strand_idx + 1] - offsets[strand_idx];
            strands.offsets.push(end);
        }
        if n_short > 0 {
            self.warnings.push(format!("{n_short} strands of fewer than two points were left out"));
        }
        if n_without_length > 0 {
            self.warnings.push(format!("{n_without_length} strands with all points at one place were left out"));
        }
    }
}

fn keep_strands<T: Copy>(values: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    values.retain(|_| *kept.next().unwrap_or(&false));
}

fn keep_points<T: Copy>(values: &mut Vec<T>, offsets: &[u32], keep: &[bool]) {
    if values.is_empty() {
        return;
    }
    let mut end = 0;
    for (strand_idx, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
        let range = offsets[strand_idx] as usize..offsets[strand_idx + 1] as usize;
        let n = range.len();
        values.copy_within(range, end);
        end += n;
    }
    values.truncate(end);
}

/// What a mesh reader hands over before it is checked.
#[derive(Default)]
pub(crate) struct RawMesh {
    pub mesh: TriMesh,
    pub warnings: Vec<String>,
}

impl RawMesh {
    /// Check indices and positions, leave out triangles without area, guess the space.
    pub(crate) fn finish(mut self, source: &Source<'_>, format: Format) -> Result<MeshImport, ReadError> {
        let n_positions = self.mesh.positions.len();
        if let Some(bad) = self.mesh.positions.iter().position(|p| !p.is_finite() || p.abs().max_element() > 1e9) {
            return Err(source.corrupt(
                Place::Vertex(bad as u64),
                format!("has a position that is no place: {}", self.mesh.positions[bad]),
                "Remove this vertex where the mesh was made, or export it again",
            ));
        }
        let triangles = &self.mesh.triangles;
        if let Some(bad) = triangles.iter().position(|t| t.iter().any(|&v| v as usize >= n_positions)) {
            return Err(source.corrupt(
                Place::Part(format!("face {bad}")),
                format!("refers to vertex {}, but there are {n_positions}", triangles[bad].iter().max().unwrap_or(&0)),
                "Export the mesh again",
            ));
        }
        self.drop_degenerate();
        if self.mesh.triangles.is_empty() {
            return Err(source.nothing(
                "holds no faces",
                "Choose a file with a surface; strands are opened as strands, not as a head",
            ));
        }
        if !self.mesh.uvs.iter().flatten().all(|value| value.is_finite()) {
            self.warnings.push("texture coordinates hold values that are no numbers: left out".to_owned());
            self.mesh.uvs = Vec::new();
        }
        // Normals are made again: files have them wrong or per face more often than right.
        self.mesh.normals = Vec::new();
        let mut attributes = Vec::new();
        if !self.mesh.uvs.is_empty() {
            attributes.push("uv");
        }
        if !self.mesh.groups.is_empty() {
            attributes.push("groups");
        }
        let guess = Space::guess(None, Some(&self.mesh), Some(format));
        self.warnings.extend(guess.warning);
        Ok(MeshImport {
            path: source.path().to_owned(),
            format,
            mesh: self.mesh,
            space: guess.space,
            space_reason: guess.reason,
            attributes,
            warnings: self.warnings,
        })
    }

    fn drop_degenerate(&mut self) {
        let mesh = &mut self.mesh;
        let is_good = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        if mesh.triangles.iter().all(is_good) {
            return;
        }
        let mut new_idx = Vec::with_capacity(mesh.triangles.len());
        let mut n_kept = 0u32;
        for triangle in &mesh.triangles {
            new_idx.push(is_good(triangle).then_some(n_kept));
            n_kept += u32::from(is_good(triangle));
        }
        let n_dropped = mesh.triangles.len() - n_kept as usize;
        mesh.triangles.retain(is_good);
        for group in &mut mesh.groups {
            group.triangles =
                group.triangles.iter().filter_map(|&t| new_idx.get(t as usize).copied().flatten()).collect();
        }
        mesh.groups.retain(|group| !group.triangles.is_empty());
        self.warnings.push(format!("{n_dropped} triangles that use a vertex twice were left out"));
    }
}
