// Slot `sink`: fragments of the tail, weighted by what the slabs in front of them let through.
// slot: sink
#define_import_path lorelei::fragments_k_tail
#import lorelei::fragment::{Fragment, band, nearness_of, depth_of, SAME, fixed, fixed_colour, unfixed}
#import lorelei::slabs::{N_SLABS, slab_place}

@group(0) @binding(auto) var<storage, read> nearest: array<u32>;
@group(0) @binding(auto) var<storage, read> slabs: array<u32>;
// Of each pixel: weight x radiance, and weight.
@group(0) @binding(auto) var<storage, read_write> sums: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let last = nearest[fragment.place * band.n_nearest + band.n_nearest - 1u];
    if nearness_of(fragment.depth) + SAME >= last {
        return;
    }
    let place = slab_place(fragment.depth - depth_of(last));
    let own = u32(place);
    var before = 0.0;
    for (var k = 0u; k < own; k++) {
        before += unfixed(slabs[fragment.place * N_SLABS + k]);
    }
    before += fract(place) * unfixed(slabs[fragment.place * N_SLABS + own]);
    // Weights are compared with each other alone: sixteen times as many units, and never none where a slab is so dense
    // that its own front hides all of it.
    let weight = 16.0 * fragment.alpha * max(exp(-before), 1e-5);
    let colour = fixed_colour(weight, fragment.colour);
    let at = 4u * fragment.place;
    atomicAdd(&sums[at], colour.x);
    atomicAdd(&sums[at + 1u], colour.y);
    atomicAdd(&sums[at + 2u], colour.z);
    atomicAdd(&sums[at + 3u], fixed(weight));
}
