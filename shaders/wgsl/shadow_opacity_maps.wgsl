// Slot `shadow_technique`: opacity shadow maps (Kim and Neumann 2001). Between two slices' ends the optical depth grows
// with depth, which is right only where hair fills the whole slice: few slices darken hair before its front.
// slot: shadow_technique
#define_import_path lorelei::shadow_opacity_maps
#import lorelei::shadow_map::{shadow_params, shadow_lights, NO_HAIR, texel_index}
#import lorelei::shadow_slices::{SLICE_FIXED_POINT, slice_of}

@group(0) @binding(auto) var<storage, read> shadow_slices: array<u32>;

const AVERAGES_LIGHT: bool = false;
const JITTERS: bool = false;

// Optical depth down to the end of the n-th slice.
fn down_to(at: u32, n: u32) -> f32 {
    if n == 0u {
        return 0.0;
    }
    let slice = n - 1u;
    let two = shadow_slices[at * (shadow_params.n_parts / 2u) + slice / 2u];
    return f32((two >> (16u * (slice % 2u))) & 0xffffu) / SLICE_FIXED_POINT;
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let at = texel_index(light_idx, texel);
    let x = slice_of(light_idx, depth);
    let slice = min(u32(x), shadow_params.n_parts - 1u);
    return mix(down_to(at, slice), down_to(at, slice + 1u), x - f32(slice));
}

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    let at = texel_index(light_idx, texel);
    // The first slice with hair in it, by halves: sums only grow.
    var before = 0u;
    var behind = shadow_params.n_parts;
    if down_to(at, behind) == 0.0 {
        return NO_HAIR;
    }
    while behind - before > 1u {
        let middle = (before + behind) / 2u;
        if down_to(at, middle) > 0.0 {
            behind = middle;
        } else {
            before = middle;
        }
    }
    return mix(shadow_lights[light_idx].near, shadow_lights[light_idx].far, f32(before) / f32(shadow_params.n_parts));
}
