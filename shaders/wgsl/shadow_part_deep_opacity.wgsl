// Slot `shadow_part`: the layers of a deep opacity map. Hair behind the last one belongs to it, where it is not ignored.
// slot: shadow_part
#define_import_path lorelei::shadow_part_deep_opacity
#import lorelei::shadow_map::{shadow_params, shadow_lights, map_place, texel_index, layer_of, NO_HAIR, BEYOND_IGNORE}
#import lorelei::shadow_deep_opacity::{filtered, hair_front}
#import lorelei::shadow_layers::{n_filtered}
#import lorelei::shadow_past_head::{is_unmapped}
#import lorelei::view_parts::{NO_PART}

fn n_parts() -> u32 {
    return shadow_params.n_parts;
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return NO_PART;
    }
    let front = hair_front(light_idx, vec2<i32>(place.xy));
    let layer = u32(layer_of(place.z - front));
    if front == NO_HAIR || (layer >= n_parts() && shadow_params.beyond_last == BEYOND_IGNORE) {
        return NO_PART;
    }
    return min(layer, n_parts() - 1u);
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    let at = texel_index(light_idx, vec2<i32>(place.xy)) * n_filtered();
    // The first layer begins at 0, which has no number of its own.
    return filtered(at, part + 1u) - select(filtered(at, part), 0.0, part == 0u);
}
