//! Occupancy maps (Sintorn and Assarsson 2009): the range of depths of each texel, and in one more pass 128 bits and four
//! sums over it: ten words a texel.

use super::front;
use super::params::MapSize;
use super::plan::{Plan, Step, Words};

/// Words of bits, and slabs. Twin of `N_SLABS` in `shadow_bits.wgsl`.
const N_SLABS: u64 = 4;

pub(super) fn plan(size: MapSize) -> Plan {
    let (mut buffers, range) = front::range(size);
    buffers.extend([
        Words::cleared("shadow_occupied", "shadow.occupancy.bits", N_SLABS * size.n_texels()),
        Words::cleared("shadow_slabs", "shadow.occupancy.slabs", N_SLABS * size.n_texels()),
    ]);
    Plan { buffers, steps: vec![range, Step::Walk { sink: "shadow_sink_occupancy" }] }
}
