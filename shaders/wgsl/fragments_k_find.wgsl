// Slot `sink`: depths of the nearest few fragments, sorted. Each slot keeps the nearer of two depths and hands the other on
// to the next: the order in which threads come does not matter ("loop32" of Kubisch 2014).
// slot: sink
#define_import_path lorelei::fragments_k_find
#import lorelei::fragment::{Fragment, band, nearness_of}

@group(0) @binding(auto) var<storage, read_write> nearest: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let first = fragment.place * band.n_nearest;
    var mine = nearness_of(fragment.depth);
    // Most fragments are behind all that are kept.
    if atomicLoad(&nearest[first + band.n_nearest - 1u]) >= mine {
        return;
    }
    for (var k = 0u; k < band.n_nearest; k++) {
        let before = atomicMax(&nearest[first + k], mine);
        mine = min(mine, before);
        if mine == 0u {
            break;
        }
    }
}
