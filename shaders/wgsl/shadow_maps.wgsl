// Slot `shadow`: what of a light arrives, from a map of the hair for each light and a depth map of the head. How a texel
// tells optical depth is the slot `shadow_technique`.
// slot: shadow
// slot: shadow_others
#define_import_path lorelei::shadow_maps
#import lorelei::shadow_map::{shadow_params, shadow_lights, map_place}
#import lorelei::shadow_past_head::{is_unmapped, head_front, past_head_at, past_head_of, N_TAPS, disc_tap, blur_of}
#import lorelei::shadow_technique::{AVERAGES_LIGHT, JITTERS, texel_depth, hair_front}
#import lorelei::shadow_jitter::{aside}

// What is averaged: an optical depth, or where it is all or nothing, the light that it lets through.
fn carried(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let tau = shadow_params.density * texel_depth(light_idx, texel, depth);
    if AVERAGES_LIGHT {
        return exp(-tau);
    }
    return tau;
}

// The optical depth of what was averaged.
fn restored(average: f32) -> f32 {
    if AVERAGES_LIGHT {
        return -log(max(average, 1e-7));
    }
    return average;
}

// Between four texels.
fn carried_at(light_idx: u32, at: vec2<f32>, depth: f32) -> f32 {
    let corner = floor(at - 0.5);
    let f = at - 0.5 - corner;
    let texel = vec2<i32>(corner);
    let near_row = mix(
        carried(light_idx, texel, depth),
        carried(light_idx, texel + vec2<i32>(1, 0), depth),
        f.x,
    );
    let far_row = mix(
        carried(light_idx, texel + vec2<i32>(0, 1), depth),
        carried(light_idx, texel + vec2<i32>(1, 1), depth),
        f.x,
    );
    return mix(near_row, far_row, f.y);
}

// Optical depth at a place of the map, over a window of taps.
fn window_depth(light_idx: u32, at: vec2<f32>, depth: f32) -> f32 {
    let n = shadow_params.n_taps;
    let first = at - 0.5 * f32(n - 1u) * shadow_params.tap_spacing;
    var sum = 0.0;
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            let tap = first + shadow_params.tap_spacing * vec2<f32>(f32(x), f32(y));
            sum += carried_at(light_idx, tap, depth);
        }
    }
    return restored(sum / f32(n * n));
}

// Optical depth of the hair between a light and a position: exp(-hair_depth) of the light comes through black fibres.
fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return 0.0;
    }
    var at = place.xy;
    if JITTERS {
        at += shadow_params.jitter * aside(position);
    }
    // A fibre is as wide as its share of a texel: what lies within half a texel before it is mostly itself.
    let own = 0.5 * place.w / shadow_lights[light_idx].texels_per_cm;
    return window_depth(light_idx, at, place.z - own);
}

// For hair: 1 where the head does not stand between a light and a position.
fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return past_head_of(light_idx, position);
}

// For surfaces: the share of a light that reaches a position through hair and past the head, with edges that soften with
// the distance to what casts the shadow, as the size of the light has it.
fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return 1.0;
    }
    let texel = vec2<i32>(place.xy);
    let hair_blur = blur_of(light_idx, place, hair_front(light_idx, texel));
    let head_blur = blur_of(light_idx, place, head_front(light_idx, texel));
    var through_hair = 0.0;
    var past = 0.0;
    for (var tap = 0u; tap < N_TAPS; tap++) {
        let offset = disc_tap(tap);
        through_hair += exp(-restored(carried_at(light_idx, place.xy + hair_blur * offset, place.z)));
        past += past_head_at(light_idx, place.xy + head_blur * offset, place.z);
    }
    return through_hair * past / f32(N_TAPS * N_TAPS);
}
