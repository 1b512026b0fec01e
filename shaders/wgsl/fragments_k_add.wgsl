// Slot `sink`: alpha and colour of the nearest few fragments; optical depths of the others in the slabs of the tail.
// slot: sink
#define_import_path lorelei::fragments_k_add
#import lorelei::fragment::{Fragment, band, nearness_of, depth_of, is_same, SAME, fixed, pack_colour}
#import lorelei::slabs::{N_SLABS, slab_place}

@group(0) @binding(auto) var<storage, read> nearest: array<u32>;
// Of each of them: alpha, packed radiance.
@group(0) @binding(auto) var<storage, read_write> kept: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> slabs: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let first = fragment.place * band.n_nearest;
    let mine = nearness_of(fragment.depth);
    let last = nearest[first + band.n_nearest - 1u];
    if mine + SAME < last {
        let slab = u32(slab_place(fragment.depth - depth_of(last)));
        let optical = min(-log(max(1.0 - fragment.alpha, 1e-4)), 16.0);
        atomicAdd(&slabs[fragment.place * N_SLABS + slab], fixed(optical));
        return;
    }
    for (var k = 0u; k < band.n_nearest; k++) {
        if is_same(nearest[first + k], mine) {
            let at = 2u * (first + k);
            atomicAdd(&kept[at], fixed(fragment.alpha));
            atomicMax(&kept[at + 1u], pack_colour(fragment.colour));
            break;
        }
    }
}
