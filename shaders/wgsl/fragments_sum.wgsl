// Slot `sink`: sums over all fragments of a pixel, whatever their order (Bavoil and Myers 2008).
// slot: sink
#define_import_path lorelei::fragments_sum
#import lorelei::fragment::{Fragment, fixed, fixed_colour}

// Of each pixel: alpha x radiance, alpha, and how many fragments.
@group(0) @binding(auto) var<storage, read_write> sums: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let colour = fixed_colour(fragment.alpha, fragment.colour);
    let at = 5u * fragment.place;
    atomicAdd(&sums[at], colour.x);
    atomicAdd(&sums[at + 1u], colour.y);
    atomicAdd(&sums[at + 2u], colour.z);
    atomicAdd(&sums[at + 3u], fixed(fragment.alpha));
    atomicAdd(&sums[at + 4u], 1u);
}
