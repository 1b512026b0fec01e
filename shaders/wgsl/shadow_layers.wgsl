// The layers of a deep opacity map after the filter, and the last one where it grows.
#define_import_path lorelei::shadow_layers
#import lorelei::shadow_map::{shadow_params, BEYOND_GROW, layer_start}

// Words a texel: bits of the front's depth in cm (NO_HAIR: none); then, two half floats a word, the optical depth down to each
// layer's end, and where the last layer grows, how far behind the front it ends. Half floats, so that the maps of three
// lights stay in a GPU's cache.
fn n_filtered() -> u32 {
    return 1u + (shadow_params.n_parts + u32(grows()) + 1u) / 2u;
}

fn grows() -> bool {
    return shadow_params.beyond_last == BEYOND_GROW;
}

// Share of the last layer that is before a depth behind the front, where the layer ends at `end`.
fn grown_share(behind: f32, end: f32) -> f32 {
    let start = layer_start(shadow_params.n_parts - 1u);
    return saturate((behind - start) / max(end - start, 1e-4));
}
