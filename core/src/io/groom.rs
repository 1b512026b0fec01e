//! A document from a strand file and the head that belongs to it.
//!
//! Hair and head that were exported together share a space, so it is guessed from both at once and the
//! same transform is applied to both. Only where they would lie apart is each taken for itself.

use std::path::Path;

use glam::Vec3;

use super::error::ReadError;
use super::import::{MeshImport, StrandImport};
use super::source::Watch;
use super::space::{Axis, Space, Unit};
use super::{read_mesh, read_strands};
use crate::groom::{Groom, Head, Layer};

/// What a person decided about an import; what is `None` is guessed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ImportOptions {
    pub unit: Option<Unit>,
    pub up: Option<Axis>,
    pub front: Option<Axis>,
}

impl ImportOptions {
    /// Exactly this space, nothing guessed.
    pub fn exactly(space: Space) -> Self {
        Self { unit: Some(space.unit), up: Some(space.up), front: Some(space.front) }
    }

    /// A guess, corrected by what was decided.
    pub fn decide(self, guess: Space) -> Space {
        let space = guess.with_up(self.up.unwrap_or(guess.up));
        // A face cannot look up.
        let front = self.front.filter(|front| front.vector().dot(space.up.vector()) == 0.0);
        Space { unit: self.unit.unwrap_or(space.unit), front: front.unwrap_or(space.front), ..space }
    }

    /// How the space was found: the guess's own words, unless a person decided otherwise.
    pub(crate) fn reason(self, guess: Space, words: String) -> String {
        let space = self.decide(guess);
        if space == guess { words } else { format!("{}: as was asked for", space.describe()) }
    }
}

/// A document made of imported files, and what is to be said about it.
#[derive(Debug, Clone)]
pub struct GroomImport {
    pub groom: Groom,
    /// What the strand file's numbers were taken for; import again with other options to change it.
    pub space: Space,
    /// How that was found.
    pub space_reason: String,
    /// The head's own space, where it is another.
    pub head_space: Option<Space>,
    /// What was dropped, assumed or is odd.
    pub warnings: Vec<String>,
}

/// Hairs on an average head (Robbins 2012).
const N_HAIRS: f32 = 100_000.0;
const HAIR_RADIUS_UM: f32 = 40.0;
/// Wider strands look like ribbons.
const WIDEST_RADIUS_UM: f32 = 250.0;

/// Make a document of a strand file, and of a head where one is given.
pub fn import_groom(
    strand_path: &Path,
    head_path: Option<&Path>,
    options: ImportOptions,
    watch: Watch<'_>,
) -> Result<GroomImport, ReadError> {
    // The small file first: an error in it shows at once.
    let head = head_path.map(|path| read_mesh(path, Watch { on_progress: None, ..watch })).transpose()?;
    let strands = read_strands(strand_path, watch)?;
    Ok(groom_of(strands, head, options))
}

/// Make a document of strands and a head that were read already.
pub fn groom_of(mut hair: StrandImport, mut head: Option<MeshImport>, options: ImportOptions) -> GroomImport {
    let mut warnings = std::mem::take(&mut hair.warnings);
    let mut head_space = None;
    if let Some(head) = &mut head {
        // One of the two formats may prescribe its space.
        let format = if head.format == super::Format::Gltf { head.format } else { hair.format };
        let both = Space::guess(Some(&hair.strands), Some(&head.mesh), Some(format));
        let (hair_alone, head_alone) = (hair.space, head.space);
        warnings.append(&mut head.warnings);
        let together = options.decide(both.space);
        let apart = (options.decide(hair_alone), head_alone);
        if are_around(&hair, head, together, together) {
            (hair.space, head.space) = (together, together);
            hair.space_reason = options.reason(both.space, both.reason);
        } else if are_around(&hair, head, apart.0, apart.1) {
            (hair.space, head.space) = apart;
            hair.space_reason = options.reason(hair_alone, std::mem::take(&mut hair.space_reason));
            head_space = Some(head.space);
            warnings.push(format!(
                "hair and head are in different spaces: hair in {} with {} up, head in {} with {} up",
                apart.0.unit.name(),
                apart.0.up.name(),
                apart.1.unit.name(),
                apart.1.up.name()
            ));
        } else {
            (hair.space, head.space) = (together, together);
            hair.space_reason = options.reason(both.space, both.reason);
            warnings.push(
                "the hair does not lie around the head: the two files may not belong together, or differ in unit or axis"
                    .to_owned(),
            );
        }
    } else {
        hair.space_reason = options.reason(hair.space, std::mem::take(&mut hair.space_reason));
        hair.space = options.decide(hair.space);
    }

    let name = stem(&hair.path, "Hair");
    let (space, space_reason) = (hair.space, std::mem::take(&mut hair.space_reason));
    let placed = hair.place();
    warnings.extend(placed.warnings);
    let n_strands = placed.strands.n_strands();
    let most_points = placed.strands.iter().map(<[Vec3]>::len).max().unwrap_or(2);
    let has_own_widths = !placed.strands.radii_um.is_empty();
    let mut layer = Layer::from_strands(&name, placed.strands);
    layer.read_as = Some(space);
    layer.vertices_per_strand = (most_points as u32).clamp(4, 128);
    layer.radius_um = placed.radius_um.unwrap_or_else(|| default_radius_um(n_strands));
    if !has_own_widths && layer.radius_um > HAIR_RADIUS_UM {
        warnings.push(format!(
            "no widths in the file: {n_strands} strands were given {:.0} um radius, to cover what 100,000 hairs of \
             {HAIR_RADIUS_UM} um would; change it under the layer's width",
            layer.radius_um
        ));
    }
    let head = head.map(|head| Head { read_as: Some(head.space), ..Head::new(stem(&head.path, "Head"), head.place()) });
    let groom = Groom { name, head, layers: vec![layer], ..Groom::default() };
    GroomImport { groom, space, space_reason, head_space, warnings }
}

/// Radius for strands that come without: fewer strands than hairs stand for several each, so that the same
/// area is covered.
pub(crate) fn default_radius_um(n_strands: usize) -> f32 {
    (HAIR_RADIUS_UM * N_HAIRS / n_strands.max(1) as f32).clamp(HAIR_RADIUS_UM, WIDEST_RADIUS_UM)
}

/// Whether the hair's roots lie at the head: in its box, grown by a fifth.
fn are_around(hair: &StrandImport, head: &MeshImport, hair_space: Space, head_space: Space) -> bool {
    let Some((min, max)) = head.mesh.bounds() else { return false };
    let (a, b) =
        (head_space.world_from_file().transform_point3(min), head_space.world_from_file().transform_point3(max));
    let (min, max) = (a.min(b), a.max(b));
    let margin = 0.2 * (max - min);
    let world_from_file = hair_space.world_from_file();
    let n_strands = hair.strands.n_strands();
    let step = n_strands.div_ceil(1000).max(1);
    let is_near = |strand_idx: usize| {
        let root = world_from_file.transform_point3(hair.strands.strand(strand_idx)[0]);
        root.cmpge(min - margin).all() && root.cmple(max + margin).all()
    };
    let sampled = (0..n_strands).step_by(step);
    let n_sampled = sampled.len();
    sampled.filter(|&strand_idx| is_near(strand_idx)).count() * 2 > n_sampled
}

fn stem(path: &Path, otherwise: &str) -> String {
    path.file_stem().map_or_else(|| otherwise.to_owned(), |stem| stem.to_string_lossy().into_owned())
}
