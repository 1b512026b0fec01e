// The slices and slabs of an occupancy map (Sintorn and Assarsson 2009, 3.1) over a texel's own range of depths.
#define_import_path lorelei::shadow_bits
#import lorelei::shadow_map::{front_depth}

const N_SLICES: u32 = 128u;
// A slab is as long as a word has bits.
const N_SLABS: u32 = 4u;

// 0 at the nearest fragment, N_SLICES at the farthest; beyond them beyond.
fn slice_of(front: u32, back: u32, depth: f32) -> f32 {
    let near = front_depth(front);
    let range = max(bitcast<f32>(back) - near, 1e-4);
    return (depth - near) / range * f32(N_SLICES);
}
