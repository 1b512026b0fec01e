// Slot `shadow_part`: the four slabs of an occupancy map over the texel's own range of depths.
// slot: shadow_part
#define_import_path lorelei::shadow_part_occupancy
#import lorelei::shadow_map::{FIXED_POINT, shadow_lights, map_place, texel_index}
#import lorelei::shadow_bits::{N_SLICES, N_SLABS, slice_of}
#import lorelei::shadow_past_head::{is_unmapped}
#import lorelei::view_parts::{NO_PART}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_slabs: array<u32>;

fn n_parts() -> u32 {
    return N_SLABS;
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    let place = map_place(shadow_lights[light_idx], position);
    let at = texel_index(light_idx, vec2<i32>(place.xy));
    if is_unmapped(light_idx, place) || shadow_front[at] == 0u {
        return NO_PART;
    }
    let x = max(slice_of(shadow_front[at], shadow_back[at], place.z), 0.0);
    return min(u32(x), N_SLICES - 1u) / (N_SLICES / N_SLABS);
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    let at = texel_index(light_idx, vec2<i32>(place.xy));
    return f32(shadow_slabs[at * N_SLABS + part]) / FIXED_POINT;
}
