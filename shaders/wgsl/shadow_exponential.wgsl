// Slot `shadow_technique`: light that dies by the distance behind the front of the hair (Karis 2016; Gonzalez Jimenez
// 2022, 4.5): exp(-k d), averaged over the taps. It knows how far the front is and not how much hair is in between.
// slot: shadow_technique
#define_import_path lorelei::shadow_exponential
#import lorelei::shadow_map::{shadow_params, front_depth, texel_index}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;

const AVERAGES_LIGHT: bool = true;
const JITTERS: bool = false;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return front_depth(shadow_front[texel_index(light_idx, texel)]);
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    return shadow_params.falloff * max(depth - hair_front(light_idx, texel) - shadow_params.bias, 0.0);
}
