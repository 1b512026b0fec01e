//! Where sculpt guides stand and how the hair grows there before any brush.
//!
//! What a brush touches must be what is seen, so its guides have the part of the style that gives hair its large
//! shape ([`shaping`]): bends, partings and ironing, which can move a strand by its whole length. Curls, waves,
//! frizz and clumps lie around that shape by at most a centimetre or two and differently from strand to strand, so
//! guides go without: a guide with a curl of its own would hand the opposite of it to every neighbour when smoothed.

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::{K, MOST_GUIDES, N_GUIDES, SculptRoots};
use crate::binding::{bind_layer, bind_places};
use crate::generate::{Pose, generate, root_frame};
use crate::groom::{Head, Layer};
use crate::maps::{MapKind, Maps};
use crate::point_grid::PointGrid;
use crate::style::{StyleKind, StyleOp, taking_part};

/// The sculpt guides of a layer, as its hair mesh or guides make them.
#[derive(Debug, Clone, Default)]
pub struct GuidePaths {
    /// Points from root to tip, head space, centimetres: the path, before brushes.
    pub paths: Vec<[Vec3; K]>,
    /// Share of the path that painted length leaves; one a guide.
    pub left: Vec<f32>,
    /// Columns: two directions along the scalp and the way out of it; offsets are stored in it.
    pub frames: Vec<Mat3>,
    /// Whether hair grows at the guide: not where its bundle was removed.
    pub is_there: Vec<bool>,
}

/// Hair that painted length takes away keeps this share of its path for brushes to divide by.
const LEAST_LEFT: f32 = 0.02;

/// The operators of a stack that give hair its large shape, alike on neighbours.
pub fn shaping(style: &[StyleOp]) -> Vec<StyleOp> {
    let shaped = taking_part(style).into_iter().filter_map(|(_, op)| {
        let kind = match op.kind {
            StyleKind::Bend { heading_deg, elevation_deg, gravity, .. } => {
                StyleKind::Bend { heading_deg, elevation_deg, gravity, variation: 0.0, strands_per_clump: 1.0 }
            }
            StyleKind::Smooth { .. } | StyleKind::Part { .. } => op.kind,
            StyleKind::Length { .. }
            | StyleKind::Clump { .. }
            | StyleKind::Wave { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Frizz { .. }
            | StyleKind::Deviate { .. }
            | StyleKind::Wisp { .. } => return None,
        };
        Some(StyleOp { kind, solo: false, ..op.clone() })
    });
    shaped.collect()
}

/// A place nearer to a known guide than this share of the guides' spacing needs no guide of its own.
const COVERED: f32 = 0.9;

impl SculptRoots {
    /// Guides for a layer: the first places of its root sequence, whatever its density and count are.
    pub fn of_layer(layer: &Layer, head: Option<&Head>) -> Self {
        sequence(layer, head)
    }

    /// The guides and further ones where the layer has hair and no guide is near; `None` where nothing is
    /// missing. The guides that there are keep their numbers.
    pub fn covering(&self, layer: &Layer, head: Option<&Head>) -> Option<Self> {
        let wanted = sequence(layer, head);
        if self.positions.is_empty() {
            return (!wanted.positions.is_empty()).then_some(wanted);
        }
        let grid = PointGrid::new(&wanted.positions, 0.5);
        let distances = wanted.positions.iter().map(|&p| grid.nearest::<2>(p).0[1].1.sqrt()).filter(|d| d.is_finite());
        let (sum, n) = distances.fold((0.0, 0), |(sum, n), d| (sum + d, n + 1));
        // A sequence's nearest neighbours are nearer than the spacing that it leaves open elsewhere.
        let reach = 2.0 * COVERED * sum / n.max(1) as f32;
        let known = PointGrid::new(&self.positions, 0.5);
        let is_new = |p: Vec3| known.nearest::<1>(p).0[0].1 > reach * reach;
        let room = MOST_GUIDES.saturating_sub(self.positions.len());
        let more = (0..wanted.positions.len()).filter(|&i| is_new(wanted.positions[i])).take(room);
        let mut all = self.clone();
        for i in more {
            all.positions.push(wanted.positions[i]);
            all.uvs.extend(wanted.uvs.get(i));
        }
        if all.uvs.len() != all.positions.len() {
            all.uvs.clear();
        }
        (all.positions.len() > self.positions.len()).then_some(all)
    }
}

/// The first places of a layer's root sequence.
fn sequence(layer: &Layer, head: Option<&Head>) -> SculptRoots {
    let bare = Layer { n_strands: N_GUIDES as u32, seed: layer.seed, ..Layer::new("guides", layer.source.clone()) };
    let binding = bind_layer(&bare, head);
    let (mut positions, mut uvs) = (binding.roots, binding.root_uvs);
    positions.truncate(N_GUIDES);
    uvs.truncate(N_GUIDES);
    SculptRoots { positions, uvs }
}

impl GuidePaths {
    /// The guides as hair mesh or guides of the layer make them, without its style.
    pub fn new(layer: &Layer, head: Option<&Head>, roots: &SculptRoots) -> Self {
        Self::styled(layer, head, roots, Vec::new())
    }

    /// The guides with the layer's large shape, as brushes touch them.
    pub fn shaped(layer: &Layer, head: Option<&Head>, roots: &SculptRoots) -> Self {
        let mut shaped = Self::styled(layer, head, roots, shaping(&layer.style));
        if let Some(map) = layer.maps.get(&MapKind::Length) {
            let left = |uv: &[f32; 2]| (map.sample(*uv) * MapKind::Length.max_value()).clamp(LEAST_LEFT, 1.0);
            shaped.left = roots.uvs.iter().map(left).collect();
            shaped.left.resize(shaped.paths.len(), 1.0);
        }
        shaped
    }

    fn styled(layer: &Layer, head: Option<&Head>, roots: &SculptRoots, style: Vec<StyleOp>) -> Self {
        let maps = if style.is_empty() { Maps::new() } else { layer.maps.clone() };
        let bare = Layer { vertices_per_strand: K as u32, style, maps, ..Layer::new("guides", layer.source.clone()) };
        let (mut binding, is_there) = bind_places(&bare, head, &roots.positions);
        binding.resample_maps(&bare);
        binding.restyle(&bare.style);
        let strands = generate(&binding, &bare, &binding.guides.positions, &Pose::default());
        let paths = (0..binding.n_strands())
            .into_par_iter()
            .map(|i| std::array::from_fn(|k| strands.points[i * K + k]))
            .collect();
        let frames = binding.root_normals.iter().map(|&normal| root_frame(normal)).collect();
        let left = vec![1.0; binding.n_strands()];
        Self { paths, left, frames, is_there }
    }

    pub fn n_guides(&self) -> usize {
        self.paths.len()
    }

    /// Unit direction of a guide's hair, by which partings are known.
    pub fn towards(&self, guide: usize) -> Vec3 {
        (self.paths[guide][K / 2] - self.paths[guide][0]).normalize_or(Vec3::Y)
    }
}
