// Slot `shadow_sink`: a fragment into the moments of the cluster whose centre is nearest.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_clusters
#import lorelei::shadow_map::{front_depth}
#import lorelei::shadow_clusters::{N_CLUSTERS, N_MOMENTS, MOMENT_FIXED_POINT, extent}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_centres: array<f32>;
@group(0) @binding(auto) var<storage, read_write> shadow_moments: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let front = shadow_front[at];
    let x = saturate((depth - front_depth(front)) / extent(front, shadow_back[at]));
    var nearest = 0u;
    var off = abs(x - shadow_centres[at * N_CLUSTERS]);
    for (var k = 1u; k < N_CLUSTERS; k++) {
        let distance = abs(x - shadow_centres[at * N_CLUSTERS + k]);
        if distance < off {
            nearest = k;
            off = distance;
        }
    }
    let to = (at * N_CLUSTERS + nearest) * N_MOMENTS;
    let weight = opacity * MOMENT_FIXED_POINT;
    atomicAdd(&shadow_moments[to], u32(weight + 0.5));
    atomicAdd(&shadow_moments[to + 1u], u32(weight * x + 0.5));
    atomicAdd(&shadow_moments[to + 2u], u32(weight * off * off + 0.5));
}
