//! Opacity shadow maps (Kim and Neumann 2001): opacity summed in 4-256 even slices, then summed from the light on.
//!
//! The paper draws the hair once a slice, GPU Gems 2 (the Nalu demo) 16 slices in one pass by what render targets hold.
//! Here any number takes one pass: a fragment is added to its own slice, half a word. Whole words were rejected: 128
//! slices of 512 x 512 texels are then the 128 MiB that one binding can show on some devices, for one light.

use super::params::MapSize;
use super::plan::{Plan, Step, Words};

pub(super) fn plan(size: MapSize, n_slices: u32) -> Plan {
    let n_words = size.n_texels() * u64::from(n_slices) / 2;
    Plan {
        buffers: vec![Words::cleared("shadow_slices", "shadow.opacity_maps.slices", n_words)],
        steps: vec![
            Step::Walk { sink: "shadow_sink_slices" },
            Step::Items { file: "shadow_slices_sum", entry: "sum_slices", n: size.n_texels() },
        ],
    }
}
