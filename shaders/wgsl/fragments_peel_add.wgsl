// Slot `sink`: the fragments of the layer that is being peeled: mostly one, more where depths are equal.
// slot: sink
#define_import_path lorelei::fragments_peel_add
#import lorelei::fragment::{Fragment, nearness_of, is_same, fixed, fixed_colour}

@group(0) @binding(auto) var<storage, read> nearest: array<u32>;
// Of each pixel: alpha x radiance, and alpha.
@group(0) @binding(auto) var<storage, read_write> sums: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    if is_same(nearest[fragment.place], nearness_of(fragment.depth)) {
        let colour = fixed_colour(fragment.alpha, fragment.colour);
        let at = 4u * fragment.place;
        atomicAdd(&sums[at], colour.x);
        atomicAdd(&sums[at + 1u], colour.y);
        atomicAdd(&sums[at + 2u], colour.z);
        atomicAdd(&sums[at + 3u], fixed(fragment.alpha));
    }
}
