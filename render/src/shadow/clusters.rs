//! Density clustering (Mertens, Kautz, Bekaert and Van Reeth 2004): the range of depths, some rounds of k-means, and the
//! moments of the four clusters of each texel.

use super::front;
use super::params::MapSize;
use super::plan::{Plan, Step, Words};

/// Twins of `N_CLUSTERS` and `N_MOMENTS` in `shadow_clusters.wgsl`.
const N_CLUSTERS: u64 = 4;
const N_MOMENTS: u64 = 3;

pub(super) fn plan(size: MapSize, n_rounds: u32) -> Plan {
    let n = N_CLUSTERS * size.n_texels();
    let update = |entry| Step::Items { file: "shadow_clusters_update", entry, n };
    let gather = Step::Walk { sink: "shadow_sink_clusters" };
    let (mut buffers, range) = front::range(size);
    buffers.extend([
        Words::written("shadow_centres", "shadow.clusters.centres", n),
        Words::cleared("shadow_moments", "shadow.clusters.moments", N_MOMENTS * n),
    ]);
    let mut steps = vec![range, update("begin")];
    for _ in 0..n_rounds {
        steps.extend([gather.clone(), update("recentre")]);
    }
    steps.extend([gather, update("finish")]);
    Plan { buffers, steps }
}
