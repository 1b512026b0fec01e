// Slot `shadow_technique`: deep shadow maps (Lokovic and Veach 2000), a search among a texel's nodes.
// slot: shadow_technique
#define_import_path lorelei::shadow_deep_shadow
#import lorelei::shadow_map::{shadow_params, shadow_lights, NO_HAIR, OPAQUE, texel_index}
#import lorelei::shadow_fragments::{DEPTH_STEPS, step_of, packed_step, packed_value}

@group(0) @binding(auto) var<storage, read> shadow_offsets: array<u32>;
// Of nodes.
@group(0) @binding(auto) var<storage, read> shadow_counts: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_fragments: array<u32>;

const AVERAGES_LIGHT: bool = false;
const JITTERS: bool = false;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    let at = texel_index(light_idx, texel);
    if shadow_counts[at] == 0u {
        return NO_HAIR;
    }
    let share = f32(packed_step(shadow_fragments[shadow_offsets[at]])) / DEPTH_STEPS;
    return mix(shadow_lights[light_idx].near, shadow_lights[light_idx].far, share);
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let at = texel_index(light_idx, texel);
    let n = shadow_counts[at];
    if n == 0u {
        return 0.0;
    }
    let first = shadow_offsets[at];
    let step = step_of(light_idx, depth);
    if step < f32(packed_step(shadow_fragments[first])) {
        return 0.0;
    }
    // The last node that is not behind the place.
    var before = 0u;
    var behind = n;
    while behind - before > 1u {
        let middle = (before + behind) / 2u;
        if f32(packed_step(shadow_fragments[first + middle])) <= step {
            before = middle;
        } else {
            behind = middle;
        }
    }
    let node = shadow_fragments[first + before];
    var light = packed_value(node);
    if behind < n {
        let next = shadow_fragments[first + behind];
        let from_step = f32(packed_step(node));
        light = mix(light, packed_value(next), (step - from_step) / (f32(packed_step(next)) - from_step));
    }
    // The density is in the light already, and whoever asks multiplies by it.
    return min(-log(max(light, 1e-7)), OPAQUE) / max(shadow_params.density, 1e-3);
}
