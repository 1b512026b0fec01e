// Slot `sink`: which slices of a pixel's depth range are occupied, and how many fragments its slabs hold. 001, section
// 3.1: the paper's two passes in one.
// slot: sink
#define_import_path lorelei::fragments_occupy
#import lorelei::fragment::{Fragment, depth_of, fixed}
#import lorelei::occupancy::{slice_place}

@group(0) @binding(auto) var<storage, read> range: array<u32>;
// Of each pixel: 128 bits, then fragments of four slabs, then the sum of their optical depths.
@group(0) @binding(auto) var<storage, read_write> occupied: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let nearest = depth_of(range[2u * fragment.place]);
    let farthest = bitcast<f32>(range[2u * fragment.place + 1u]);
    let slice = u32(slice_place(fragment.depth, nearest, farthest));
    let at = 9u * fragment.place;
    atomicOr(&occupied[at + slice / 32u], 1u << (slice % 32u));
    atomicAdd(&occupied[at + 4u + slice / 32u], 1u);
    atomicAdd(&occupied[at + 8u], fixed(min(-log(max(1.0 - fragment.alpha, 1e-4)), 16.0)));
}
