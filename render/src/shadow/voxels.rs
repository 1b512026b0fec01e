//! Voxel transmittance: the area and direction of the hair in each cell of one grid, which serves all lights.
//!
//! A density alone was rejected: hair lit along its strands holds back much less light than hair lit across them.

use super::plan::{Plan, Step, Words};

/// Twins of `N_NUMBERS` and `N_WORDS` in `shadow_voxel_grid.wgsl`.
const N_NUMBERS: u64 = 6;
const N_WORDS: u64 = 3;

pub(super) fn plan(n_voxels: u32) -> Plan {
    let n = u64::from(n_voxels).pow(3);
    Plan {
        buffers: vec![
            Words::cleared("shadow_tensors", "shadow.voxels.tensors", N_NUMBERS * n),
            Words::written("shadow_voxels", "shadow.voxels.densities", N_WORDS * n),
        ],
        steps: vec![
            Step::Segments { file: "shadow_voxel_walk", entry: "build" },
            Step::Items { file: "shadow_voxel_pack", entry: "pack_voxels", n },
        ],
    }
}

/// Most cells along a side that one binding holds.
pub(super) fn most(binding_bytes: u64) -> u32 {
    ((binding_bytes / (4 * N_NUMBERS)) as f64).cbrt() as u32
}
