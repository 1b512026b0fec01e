// Slot `shadow_technique`: density clustering (Mertens et al. 2004), what each texel's clusters add up to.
// slot: shadow_technique
#define_import_path lorelei::shadow_density_clusters
#import lorelei::shadow_map::{front_depth, texel_index}
#import lorelei::shadow_clusters::{N_CLUSTERS, N_MOMENTS}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_moments: array<u32>;

const AVERAGES_LIGHT: bool = false;
const JITTERS: bool = false;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return front_depth(shadow_front[texel_index(light_idx, texel)]);
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let at = texel_index(light_idx, texel);
    if shadow_front[at] == 0u {
        return 0.0;
    }
    var tau = 0.0;
    for (var k = 0u; k < N_CLUSTERS; k++) {
        let moments = (at * N_CLUSTERS + k) * N_MOMENTS;
        let mean = bitcast<f32>(shadow_moments[moments + 1u]);
        // A single fragment has no width: it is as thick as hair.
        let half_width = max(bitcast<f32>(shadow_moments[moments + 2u]), 0.005);
        tau += bitcast<f32>(shadow_moments[moments]) * saturate(0.5 + 0.5 * (depth - mean) / half_width);
    }
    return tau;
}
