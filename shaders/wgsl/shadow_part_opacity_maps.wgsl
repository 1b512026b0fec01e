// Slot `shadow_part`: the slices of opacity shadow maps.
// slot: shadow_part
#define_import_path lorelei::shadow_part_opacity_maps
#import lorelei::shadow_map::{shadow_params, shadow_lights, map_place, texel_index}
#import lorelei::shadow_opacity_maps::{down_to}
#import lorelei::shadow_past_head::{is_unmapped}
#import lorelei::shadow_slices::{slice_of}
#import lorelei::view_parts::{NO_PART}

fn n_parts() -> u32 {
    return shadow_params.n_parts;
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return NO_PART;
    }
    return min(u32(slice_of(light_idx, place.z)), n_parts() - 1u);
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    let at = texel_index(light_idx, vec2<i32>(place.xy));
    return down_to(at, part + 1u) - down_to(at, part);
}
