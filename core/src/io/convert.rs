//! What `lorelei convert` does: a strand file or a document in, another format out.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::detect::{Contents, Format, detect};
use super::error::{ReadError, WriteError};
use super::groom::{ImportOptions, import_groom};
use super::read_strands;
use super::source::Watch;
use super::write::{WriteOptions, write_strands};
use crate::binding::{LayerBinding, bind_layer, bind_layer_watched};
use crate::distance_field::DistanceField;
use crate::document::{self, DocumentError};
use crate::generate::{Pose, deleted, generate, taper};
use crate::groom::{Groom, Head, Layer, Source};
use crate::maps::MapKind;
use crate::strands::Strands;

/// Which curves of a document are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum What {
    /// The curves that strands are made from: imported guides, or the chains of a hair mesh.
    Guides,
    /// Every strand, as it is drawn.
    #[default]
    Strands,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ConvertOptions {
    /// Unit and axis of the output.
    pub output: WriteOptions,
    /// Unit and axes of the input, where the guess is wrong.
    pub input: ImportOptions,
    pub what: What,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Converted {
    pub n_strands: usize,
    pub n_points: usize,
    /// How the input's unit and axes were found; empty for documents.
    pub space_reason: String,
    pub warnings: Vec<String>,
}

#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Document(#[from] DocumentError),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Convert a file. The output's name decides its format.
pub fn convert(
    input: &Path,
    output: &Path,
    options: ConvertOptions,
    watch: Watch<'_>,
) -> Result<Converted, ConvertError> {
    let contents = detect(input)?.contents();
    if Format::of_output(output).is_none() {
        return Err(ConvertError::Write(WriteError::Refused {
            path: output.to_owned(),
            problem: "no format is written under a name like this".to_owned(),
            next: "Let it end in .hair, .tfx, .data, .usda or .lorelei".to_owned(),
        }));
    }
    if Format::of_output(output) == Some(Format::Lorelei) {
        return to_document(input, contents, output, options, watch);
    }
    let (strands, space_reason, mut warnings) = match contents {
        Contents::Document => {
            let groom = document::open(input)?;
            (strands_of(&groom, options.what), String::new(), groom.warnings())
        }
        // A mesh is refused here, by the reader that knows what to say.
        Contents::Strands | Contents::Mesh => {
            let mut import = read_strands(input, watch)?;
            let space_reason = options.input.reason(import.space, std::mem::take(&mut import.space_reason));
            import.space = options.input.decide(import.space);
            let mut warnings = std::mem::take(&mut import.warnings);
            let placed = import.place();
            warnings.extend(placed.warnings);
            (placed.strands, space_reason, warnings)
        }
    };
    warnings.extend(write_strands(output, &strands, options.output, watch)?);
    Ok(Converted { n_strands: strands.n_strands(), n_points: strands.n_points(), space_reason, warnings })
}

fn to_document(
    input: &Path,
    contents: Contents,
    output: &Path,
    options: ConvertOptions,
    watch: Watch<'_>,
) -> Result<Converted, ConvertError> {
    let (groom, space_reason, warnings) = match contents {
        Contents::Document => (document::open(input)?, String::new(), Vec::new()),
        Contents::Strands | Contents::Mesh => {
            let import = import_groom(input, None, options.input, watch)?;
            (import.groom, import.space_reason, import.warnings)
        }
    };
    document::save(&groom, output)?;
    let n_points = groom.layers.iter().map(|layer| layer.n_strands as usize * layer.vertices_per_strand as usize).sum();
    Ok(Converted { n_strands: groom.n_strands(), n_points, space_reason, warnings })
}

/// The curves of all visible layers, in the world, with their widths.
pub fn strands_of(groom: &Groom, what: What) -> Strands {
    strands_of_watched(groom, what, Watch::default()).unwrap_or_default()
}

/// As [`strands_of`], with progress; `None` where it was cancelled.
pub fn strands_of_watched(groom: &Groom, what: What, watch: Watch<'_>) -> Option<Strands> {
    // A head without a volume keeps nothing out.
    let field = groom.head.as_ref().and_then(|head| DistanceField::from_mesh(&head.mesh, FIELD_NODES).ok());
    let mut all = Strands::default();
    let visible: Vec<&Layer> = groom.layers.iter().filter(|layer| layer.visible).collect();
    for (layer_idx, layer) in visible.iter().enumerate() {
        let n_layers = visible.len() as f32;
        let on_progress = |share: f32| watch.progress((layer_idx as f32 + 0.6 * share) / n_layers);
        let of_layer = Watch { on_progress: Some(&on_progress), cancel: watch.cancel };
        let is_sculpted = layer.sculpt.is_active();
        let strands = match (&layer.source, what) {
            // As they came, with all their points: nothing is made of them.
            (Source::Strands(strands), What::Guides) if !is_sculpted => with_widths((**strands).clone(), layer),
            (Source::Strands(strands), What::Strands) if !is_sculpted && layer.style.iter().all(|op| !op.on) => {
                with_widths((**strands).clone(), layer)
            }
            (Source::Guides(guides), What::Guides) if !is_sculpted => with_widths((**guides).clone(), layer),
            (Source::HairMesh(_), What::Guides) if !is_sculpted => {
                with_widths(guides_of(&bind_layer(layer, groom.head.as_ref())), layer)
            }
            (_, What::Guides) => {
                let guides = guides_as_strands(layer, groom.head.as_ref());
                made(&guides, &bind_layer_watched(&guides, groom.head.as_ref(), of_layer)?, field.as_ref())
            }
            (_, What::Strands) => {
                made(layer, &bind_layer_watched(layer, groom.head.as_ref(), of_layer)?, field.as_ref())
            }
        };
        append(&mut all, strands);
        if watch.cancelled() {
            return None;
        }
    }
    Some(all)
}

/// Nodes on the longest side of the distance field, as where strands are drawn.
const FIELD_NODES: u32 = 64;

/// A layer's strands as they are drawn, without those that brushes took away.
fn made(layer: &Layer, binding: &LayerBinding, field: Option<&DistanceField>) -> Strands {
    let pose = Pose { field, ..Pose::default() };
    let mut strands = generate(binding, layer, &binding.guides.positions, &pose);
    let deleted = deleted(binding, layer);
    strands.retain(|strand_idx| !deleted[strand_idx]);
    strands
}

/// A layer whose strands are the guides of another, to be brushed as that one was and not styled.
fn guides_as_strands(layer: &Layer, head: Option<&Head>) -> Layer {
    let guides = match &layer.source {
        Source::Guides(guides) | Source::Strands(guides) => Arc::clone(guides),
        Source::HairMesh(_) => Arc::new(guides_of(&bind_layer(layer, head))),
    };
    let n_points = guides.iter().map(<[Vec3]>::len).max().unwrap_or(2);
    let mut maps = layer.maps.clone();
    // Painted lengths and widths are the strands'.
    maps.retain(|kind, _| !matches!(kind, MapKind::Length | MapKind::Width));
    Layer {
        n_strands: guides.n_strands() as u32,
        vertices_per_strand: n_points as u32,
        source: Source::Strands(guides),
        style: Vec::new(),
        maps,
        ..layer.clone()
    }
}

fn guides_of(binding: &LayerBinding) -> Strands {
    let mut strands = Strands::default();
    for guide_idx in 0..binding.guides.n_guides() {
        strands.push(binding.guides.guide(guide_idx));
    }
    strands
}

/// Strands with the layer's width where they have none of their own.
fn with_widths(mut strands: Strands, layer: &Layer) -> Strands {
    if strands.radii_um.is_empty() {
        for strand_idx in 0..strands.n_strands() {
            let last = (strands.range(strand_idx).len() - 1).max(1) as f32;
            let radius = |k: usize| layer.radius_um * taper(k as f32 / last, layer.tip_radius);
            strands.radii_um.extend((0..strands.range(strand_idx).len()).map(radius));
        }
    }
    strands
}

/// Append strands; an attribute that only one of the two has gets its neutral value for the other.
fn append(all: &mut Strands, more: Strands) {
    fn join<T: Clone>(all: &mut Vec<T>, n_before: usize, more: Vec<T>, n_more: usize, neutral: T) {
        if all.is_empty() && more.is_empty() {
            return;
        }
        all.resize(n_before, neutral.clone());
        all.extend(more);
        all.resize(n_before + n_more, neutral);
    }
    let (n_points, n_strands) = (all.n_points(), all.n_strands());
    let (m_points, m_strands) = (more.n_points(), more.n_strands());
    join(&mut all.radii_um, n_points, more.radii_um, m_points, 40.0);
    join(&mut all.opacities, n_points, more.opacities, m_points, 1.0);
    join(&mut all.colours, n_points, more.colours, m_points, [0.5; 3]);
    join(&mut all.root_uvs, n_strands, more.root_uvs, m_strands, [0.0; 2]);
    // Ids are unique within a layer only.
    all.ids = Vec::new();
    all.points.extend(more.points);
    all.offsets.extend(more.offsets[1..].iter().map(|end| end + n_points as u32));
}
