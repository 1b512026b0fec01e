// Slot `view_colour`: which layer, slice or cluster of a lamp's shadow a place lies in, or what one of them takes of the
// light. Grey where the technique has none, or hair lies in none.
// slot: view_colour
#define_import_path lorelei::view_colour_shadow_layer
#import lorelei::shadow_part::{n_parts, part_at, part_depth}
#import lorelei::shade_lights::{scene}
#import lorelei::view_ramp::{ramp}
#import lorelei::view_parts::{NO_PART, part_colour}

struct ViewPart {
    // The lamp's number from 1; 0: the first.
    light: u32,
    // 0: every layer in its colour; else the number, from 1, of the only one.
    only: u32,
    pad_a: u32,
    pad_b: u32,
}

@group(0) @binding(auto) var<uniform> view_light: ViewPart;

fn colour(strand: u32, position: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    let grey = vec3<f32>(0.5);
    if n_parts() == 0u || scene.n_lights == 0u {
        return grey;
    }
    let light_idx = min(max(view_light.light, 1u), scene.n_lights) - 1u;
    let part = part_at(light_idx, position);
    if part == NO_PART || (view_light.only > 0u && part + 1u != view_light.only) {
        return grey;
    }
    if view_light.only == 0u {
        return part_colour(part, n_parts());
    }
    return ramp(1.0 - exp(-part_depth(light_idx, position, part)));
}
