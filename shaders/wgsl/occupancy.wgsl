// Where a depth lies among the 128 slices and 4 slabs of an occupancy map, and how many fragments are in front of it.
// 001, sections 3.1 and 3.2.
#define_import_path lorelei::occupancy

const N_SLICES: f32 = 128.0;

// Slices from the nearest fragment, 0 to 128.
fn slice_place(depth: f32, nearest: f32, farthest: f32) -> f32 {
    return clamp((depth - nearest) / max(farthest - nearest, 1e-6) * N_SLICES, 0.0, N_SLICES - 1e-3);
}

// Compute the order of a fragment: those of the slabs before its own, and in its own slab those of the slices before,
// of which each that is occupied holds as many as the next; within its slice in proportion to its place there.
fn order_of(place: f32, slabs: vec4<u32>, occupied: vec4<u32>) -> f32 {
    let slice = u32(place);
    let slab = slice / 32u;
    let before = vec4<f32>(slabs) * vec4<f32>(vec4<u32>(0u, 1u, 2u, 3u) < vec4<u32>(slab));
    let bits = occupied[slab];
    let n_bits = countOneBits(bits);
    let mask = (1u << (slice % 32u)) - 1u;
    let own = f32((bits >> (slice % 32u)) & 1u);
    let n_before = f32(countOneBits(bits & mask)) + own * fract(place);
    return before.x + before.y + before.z + before.w + f32(slabs[slab]) * n_before / max(f32(n_bits), 1.0);
}
