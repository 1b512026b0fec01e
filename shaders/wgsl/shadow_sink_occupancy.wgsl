// Slot `shadow_sink`: the bit of the slice that a fragment falls in, and its opacity into the slab's sum.
//
// The paper counts fragments and multiplies the count by a weight. Here a slab sums what each fragment covers of the
// texel: fragments are pieces of strands of any width and length.
// slot: shadow_sink
#define_import_path lorelei::shadow_sink_occupancy
#import lorelei::shadow_map::{FIXED_POINT}
#import lorelei::shadow_bits::{N_SLICES, N_SLABS, slice_of}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
@group(0) @binding(auto) var<storage, read_write> shadow_occupied: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> shadow_slabs: array<atomic<u32>>;

fn sink(light_idx: u32, at: u32, depth: f32, opacity: f32) {
    let slice = min(u32(max(slice_of(shadow_front[at], shadow_back[at], depth), 0.0)), N_SLICES - 1u);
    let word = at * N_SLABS + slice / 32u;
    atomicOr(&shadow_occupied[word], 1u << (slice % 32u));
    atomicAdd(&shadow_slabs[word], u32(opacity * FIXED_POINT + 0.5));
}
