// Fragments and nodes of a deep shadow map, a word each: depth in the upper 18 bits, so that words sort by depth; in the
// lower 14 what a fragment covers of its texel, or the share of the light that is left at a node.
#define_import_path lorelei::shadow_fragments
#import lorelei::shadow_map::{shadow_lights}

// Steps of depth from the nearest to the farthest of the light's map: about 2 um.
const DEPTH_STEPS: f32 = 262143.0;
const VALUE_BITS: u32 = 14u;
const MOST_VALUE: f32 = 16383.0;
// What a fragment can cover of a texel at most: the casting strands are wider than they are.
const MOST_OPACITY: f32 = 4.0;

// Steps of depth, not rounded.
fn step_of(light_idx: u32, depth: f32) -> f32 {
    let near = shadow_lights[light_idx].near;
    let far = shadow_lights[light_idx].far;
    return saturate((depth - near) / (far - near)) * DEPTH_STEPS;
}

fn pack(step: u32, value: f32) -> u32 {
    return (step << VALUE_BITS) | u32(saturate(value) * MOST_VALUE + 0.5);
}

fn packed_step(word: u32) -> u32 {
    return word >> VALUE_BITS;
}

fn packed_value(word: u32) -> f32 {
    return f32(word & 0x3fffu) / MOST_VALUE;
}
