// Slot `shadow_technique`: a shadow map (Williams 1978). Hair behind the front is dark; what is averaged is the outcome
// (percentage-closer filtering, Reeves, Salesin and Cook 1987), so that the borders of shadows are soft.
// slot: shadow_technique
#define_import_path lorelei::shadow_pcf
#import lorelei::shadow_map::{shadow_params, OPAQUE, front_depth, texel_index}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;

const AVERAGES_LIGHT: bool = true;
const JITTERS: bool = false;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return front_depth(shadow_front[texel_index(light_idx, texel)]);
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    return select(0.0, OPAQUE, depth > hair_front(light_idx, texel) + shadow_params.bias);
}
