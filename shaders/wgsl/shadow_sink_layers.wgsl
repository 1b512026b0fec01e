// Slot `shadow_sink`: opacity into the layers of a deep opacity map, behind each texel's own front.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_layers
#import lorelei::shadow_map::{shadow_params, FIXED_POINT, BEYOND_IGNORE, front_depth, layer_of}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
// Opacity of each layer alone, fixed point; the layers of a texel side by side.
@group(0) @binding(auto) var<storage, read_write> shadow_opacity: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let layer = layer_of(depth - front_depth(shadow_front[at]));
    if layer >= f32(shadow_params.n_parts) && shadow_params.beyond_last == BEYOND_IGNORE {
        return;
    }
    let k = min(u32(layer), shadow_params.n_parts - 1u);
    atomicAdd(&shadow_opacity[at * shadow_params.n_parts + k], u32(opacity * FIXED_POINT + 0.5));
}
