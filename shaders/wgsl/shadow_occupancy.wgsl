// Slot `shadow_technique`: occupancy maps (Sintorn and Assarsson 2009, 3.2-3.3). The opacity before a fragment is that of
// the slabs before its own, and of its own slab as much as the bits before its slice are of all the slab's bits; inside
// the slice it grows with depth.
// slot: shadow_technique
#define_import_path lorelei::shadow_occupancy
#import lorelei::shadow_map::{FIXED_POINT, front_depth, texel_index}
#import lorelei::shadow_bits::{N_SLICES, N_SLABS, slice_of}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_occupied: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_slabs: array<u32>;

const AVERAGES_LIGHT: bool = false;
const JITTERS: bool = true;

fn hair_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return front_depth(shadow_front[texel_index(light_idx, texel)]);
}

fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let at = texel_index(light_idx, texel);
    let front = shadow_front[at];
    if front == 0u {
        return 0.0;
    }
    let x = slice_of(front, shadow_back[at], depth);
    if x <= 0.0 {
        return 0.0;
    }
    let slice = min(u32(x), N_SLICES - 1u);
    let slab = slice / 32u;
    var before = 0u;
    for (var k = 0u; k < slab; k++) {
        before += shadow_slabs[at * N_SLABS + k];
    }
    let bits = shadow_occupied[at * N_SLABS + slab];
    let bit = slice % 32u;
    let n_before = f32(countOneBits(bits & ((1u << bit) - 1u)));
    // Of a slice that is occupied, the part before the depth.
    let inside = f32((bits >> bit) & 1u) * min(x - f32(slice), 1.0);
    let average = f32(shadow_slabs[at * N_SLABS + slab]) / max(f32(countOneBits(bits)), 1.0);
    return (f32(before) + average * (n_before + inside)) / FIXED_POINT;
}
