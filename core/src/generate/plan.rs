//! A style stack made ready for the generators: what acts, in order, each with its numbers, its clumps and
//! its drawn curve. Both generators read this one list, so they cannot disagree about what takes part.

use crate::binding::LayerBinding;
use crate::maps::MapKind;
use crate::style::{Blend, Envelope, N_TABLE, StyleKind, StyleOp, direction, taking_part};

/// One operator of the plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    pub kind: StyleKind,
    pub seed: u32,
    pub blend: Blend,
    /// Index of the operator's clumps in [`crate::clumps::Clumps::sizes`]; `None` where every strand is on its own.
    pub size_idx: Option<usize>,
    /// It stands before a wisp: the whole wisp has the numbers of its middle strand.
    pub per_wisp: bool,
    /// Where no map is painted.
    pub strength: f32,
    /// Indices into [`LayerBinding::maps`] of those that scale it from strand to strand.
    pub maps: [Option<usize>; 2],
    pub from: f32,
    pub ramp: f32,
    /// The drawn curve, even samples from `from` to the tip.
    pub table: Option<[f32; N_TABLE]>,
}

/// The operators of a layer that act on its strands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    pub steps: Vec<Step>,
    /// Place in `steps` of the operator that irons the path.
    pub smooth: Option<usize>,
    /// Place in `steps` of the last wisp.
    pub wisp: Option<usize>,
    /// Indices into [`LayerBinding::maps`] of painted length and width.
    pub length_map: Option<usize>,
    pub width_map: Option<usize>,
}

impl Plan {
    pub fn new(style: &[StyleOp], binding: &LayerBinding) -> Self {
        let taking_part = taking_part(style);
        let wisp = taking_part.iter().rposition(|(_, op)| matches!(op.kind, StyleKind::Wisp { .. }));
        let smooth = taking_part.iter().position(|(_, op)| matches!(op.kind, StyleKind::Smooth { .. }));
        let steps = taking_part.iter().enumerate().map(|(step_idx, (_, op))| {
            let asked = [op.map.clone(), map_of_kind(op.kind)].map(|kind| {
                let map_idx = kind.as_ref().and_then(|kind| binding.map_idx(kind));
                // A map that was not painted says the same everywhere.
                let everywhere = if map_idx.is_none() { kind.map_or(1.0, |kind| kind.default_value()) } else { 1.0 };
                (map_idx, everywhere)
            });
            Step {
                kind: op.kind,
                seed: op.seed,
                blend: op.blend(),
                size_idx: binding.clumps.size_idx(op.kind),
                per_wisp: wisp.is_some_and(|wisp| step_idx < wisp),
                strength: op.strength * asked[0].1 * asked[1].1,
                maps: asked.map(|(map_idx, _)| map_idx),
                from: op.from,
                ramp: op.ramp,
                table: op.curve.table(),
            }
        });
        Self {
            steps: steps.collect(),
            smooth,
            wisp,
            length_map: binding.map_idx(&MapKind::Length),
            width_map: binding.map_idx(&MapKind::Width),
        }
    }

    /// Whether only lengths, clumps, waves, curls, frizz and deviations act, each by its ramp, added up and alike on
    /// the whole scalp: the GPU has a quicker kernel for these.
    pub fn is_plain(&self) -> bool {
        let is_plain = |step: &Step| {
            let of_kind = match step.kind {
                StyleKind::Length { .. }
                | StyleKind::Clump { .. }
                | StyleKind::Wave { .. }
                | StyleKind::Curl { .. }
                | StyleKind::Frizz { .. }
                | StyleKind::Deviate { .. } => true,
                StyleKind::Bend { .. } | StyleKind::Smooth { .. } | StyleKind::Part { .. } | StyleKind::Wisp { .. } => {
                    false
                }
            };
            of_kind && step.table.is_none() && step.maps == [None, None] && step.blend == Blend::Add
        };
        self.steps.iter().all(is_plain) && self.length_map.is_none() && self.width_map.is_none()
    }

    /// The clumps of the last wisp; `None` where strands are on their own.
    pub fn wisp_size_idx(&self) -> Option<usize> {
        self.steps[self.wisp?].size_idx
    }
}

/// The map that every operator of a kind heeds.
fn map_of_kind(kind: StyleKind) -> Option<MapKind> {
    match kind {
        StyleKind::Clump { .. } => Some(MapKind::Clump),
        StyleKind::Wave { .. } | StyleKind::Curl { .. } => Some(MapKind::Curl),
        StyleKind::Length { .. }
        | StyleKind::Frizz { .. }
        | StyleKind::Deviate { .. }
        | StyleKind::Bend { .. }
        | StyleKind::Smooth { .. }
        | StyleKind::Part { .. }
        | StyleKind::Wisp { .. } => None,
    }
}

impl Step {
    /// The operator's effect along a strand on which it is as strong as given.
    pub fn envelope(&self, strength: f32) -> Envelope<'_> {
        Envelope { strength, from: self.from, ramp: self.ramp, table: self.table.as_ref() }
    }

    /// The numbers of the kind as the GPU has them: twin of `Op` in generate.wgsl.
    pub fn numbers(&self) -> (u32, [f32; 6]) {
        match self.kind {
            StyleKind::Length { variation, .. } => (0, [variation, 0.0, 0.0, 0.0, 0.0, 0.0]),
            StyleKind::Clump { flare, stray, .. } => (1, [flare, stray, 0.0, 0.0, 0.0, 0.0]),
            StyleKind::Wisp { radius, gather, fuzz, twist, length_variation, .. } => {
                (2, [radius, gather, fuzz, twist, length_variation, 0.0])
            }
            StyleKind::Wave { amplitude, wavelength, .. } => (3, [amplitude, wavelength, 0.0, 0.0, 0.0, 0.0]),
            StyleKind::Curl { radius, pitch, loosen, .. } => (4, [radius, pitch, loosen, 0.0, 0.0, 0.0]),
            StyleKind::Frizz { amplitude, wavelength, .. } => (5, [amplitude, wavelength, 0.0, 0.0, 0.0, 0.0]),
            StyleKind::Deviate { share, amplitude, lift, whole } => (6, [share, amplitude, lift, whole, 0.0, 0.0]),
            StyleKind::Smooth { reach } => (7, [reach, 0.0, 0.0, 0.0, 0.0, 0.0]),
            StyleKind::Bend { heading_deg, elevation_deg, gravity, variation, .. } => {
                let towards = direction(heading_deg, elevation_deg);
                (8, [towards.x, towards.y, towards.z, gravity, variation, 0.0])
            }
            StyleKind::Part { offset, turn_deg, width } => {
                // The normal of the line's plane, on the model's left of a line that runs to the back.
                let normal = direction(90.0 - turn_deg, 0.0);
                (9, [normal.x, normal.y, normal.z, offset, width, 0.0])
            }
        }
    }
}
