// Slot `sink`: depths of the nearest and of the farthest fragment. 001, section 3.1.
// slot: sink
#define_import_path lorelei::fragments_range
#import lorelei::fragment::{Fragment, nearness_of}

// Of each pixel: nearness of the nearest, bits of the farthest depth; 0: none.
@group(0) @binding(auto) var<storage, read_write> range: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    atomicMax(&range[2u * fragment.place], nearness_of(fragment.depth));
    atomicMax(&range[2u * fragment.place + 1u], bitcast<u32>(fragment.depth));
}
