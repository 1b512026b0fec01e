// Slot `shadow_sink`: opacity into the slice of an opacity shadow map that a fragment falls in.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_slices
#import lorelei::shadow_map::{shadow_params, shadow_lights}
#import lorelei::shadow_slices::{SLICE_FIXED_POINT, slice_of}

// Two slices a word, the nearer one in the low half.
@group(0) @binding(auto) var<storage, read_write> shadow_slices: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let slice = min(u32(slice_of(light_idx, depth)), shadow_params.n_parts - 1u);
    let word = at * (shadow_params.n_parts / 2u) + slice / 2u;
    atomicAdd(&shadow_slices[word], u32(opacity * SLICE_FIXED_POINT + 0.5) << (16u * (slice % 2u)));
}
