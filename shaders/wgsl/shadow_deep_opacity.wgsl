// Slot `shadow_technique`: deep opacity maps (Yuksel and Keyser 2008), filtered once a texel.
// slot: shadow_technique
#define_import_path lorelei::shadow_deep_opacity
#import lorelei::shadow_map::{shadow_params, texel_index, layer_of}
#import lorelei::shadow_layers::{n_filtered, grows, grown_share}

// What shadow_filter.wgsl writes.
@group(0) @binding(auto) var<storage, read> shadow_filtered: array<u32>;

const AVERAGES_LIGHT: bool = false;
const JITTERS: bool = false;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return bitcast<f32>(shadow_filtered[texel_index(light_idx, texel) * n_filtered()]);
}

// The k-th number behind the front's, k from 1, of a texel whose words begin at `at`.
fn filtered(at: u32, k: u32) -> f32 {
    return unpack2x16float(shadow_filtered[at + (k + 1u) / 2u])[(k + 1u) % 2u];
}

// Optical depth of one filtered texel at a depth from the light.
fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let at = texel_index(light_idx, texel) * n_filtered();
    let behind = depth - bitcast<f32>(shadow_filtered[at]);
    if behind <= 0.0 {
        return 0.0;
    }
    let layer = layer_of(behind);
    let below = min(u32(layer), shadow_params.n_parts - 1u);
    // At the front the optical depth is 0; it has no number of its own.
    let upper = select(filtered(at, below), 0.0, below == 0u);
    var share = layer - f32(below);
    if below + 1u == shadow_params.n_parts && grows() {
        share = grown_share(behind, filtered(at, shadow_params.n_parts + 1u));
    }
    return mix(upper, filtered(at, below + 1u), share);
}
