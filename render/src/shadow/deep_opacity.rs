//! Deep opacity maps (Yuksel and Keyser 2008): the front of the hair (atomic max of inverted depth), opacity behind it
//! into layers (atomic add), and a filter. Layers start at each texel's own front.
//!
//! Rejected: filtering in the look-up alone (every vertex and light pays for what every texel can pay once).

use lorelei_core::look::BeyondLast;

use super::front;
use super::params::MapSize;
use super::plan::{Plan, Step, Words};

pub(super) fn plan(size: MapSize, n_layers: u32, beyond_last: BeyondLast) -> Plan {
    let (n_texels, grows) = (size.n_texels(), beyond_last == BeyondLast::Grow);
    // A word for the front, and half a word for each number behind it: twin of shadow_layers.wgsl.
    let n_filtered = 1 + (u64::from(n_layers) + u64::from(grows)).div_ceil(2);
    let (mut buffers, range) = front::range(size);
    let first = if grows {
        range
    } else {
        buffers.truncate(1);
        Step::Walk { sink: "shadow_sink_front" }
    };
    buffers.extend([
        Words::cleared("shadow_opacity", "shadow.deep_opacity.layers", n_texels * u64::from(n_layers)),
        Words::written("shadow_filtered", "shadow.deep_opacity.filtered", n_texels * n_filtered),
    ]);
    let overrides = vec![("N_LAYERS", f64::from(n_layers))];
    let filter = Step::Texels { file: "shadow_filter", entry: "filter_map", overrides, def: grows.then_some("GROWS") };
    Plan { buffers, steps: vec![first, Step::Walk { sink: "shadow_sink_layers" }, filter] }
}
