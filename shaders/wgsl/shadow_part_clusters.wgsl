// Slot `shadow_part`: the clusters of density clustering: the one whose mean is nearest.
// slot: shadow_part
#define_import_path lorelei::shadow_part_clusters
#import lorelei::shadow_map::{shadow_lights, map_place, texel_index}
#import lorelei::shadow_clusters::{N_CLUSTERS, N_MOMENTS}
#import lorelei::shadow_past_head::{is_unmapped}
#import lorelei::view_parts::{NO_PART}

@group(0) @binding(auto) var<storage, read> shadow_moments: array<u32>;

fn n_parts() -> u32 {
    return N_CLUSTERS;
}

// Optical depth and mean depth.
fn cluster(light_idx: u32, texel: vec2<i32>, k: u32) -> vec2<f32> {
    let moments = (texel_index(light_idx, texel) * N_CLUSTERS + k) * N_MOMENTS;
    return vec2<f32>(bitcast<f32>(shadow_moments[moments]), bitcast<f32>(shadow_moments[moments + 1u]));
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return NO_PART;
    }
    var nearest = NO_PART;
    var off = 1e30;
    for (var k = 0u; k < N_CLUSTERS; k++) {
        let found = cluster(light_idx, vec2<i32>(place.xy), k);
        if found.x > 0.0 && abs(place.z - found.y) < off {
            nearest = k;
            off = abs(place.z - found.y);
        }
    }
    return nearest;
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    return cluster(light_idx, vec2<i32>(place.xy), part).x;
}
