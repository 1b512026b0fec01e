//! Shadow map and exponential falloff: the front of the hair in each texel, one word.

use super::params::MapSize;
use super::plan::{Plan, Step, Words};

pub(super) fn plan(size: MapSize) -> Plan {
    Plan {
        buffers: vec![Words::cleared("shadow_front", "shadow.front", size.n_texels())],
        steps: vec![Step::Walk { sink: "shadow_sink_front" }],
    }
}

/// The nearest and the farthest fragment of each texel: what clusters and occupancy maps begin with.
pub(super) fn range(size: MapSize) -> (Vec<Words>, Step) {
    let buffers = vec![
        Words::cleared("shadow_front", "shadow.front", size.n_texels()),
        Words::cleared("shadow_back", "shadow.back", size.n_texels()),
    ];
    (buffers, Step::Walk { sink: "shadow_sink_range" })
}
