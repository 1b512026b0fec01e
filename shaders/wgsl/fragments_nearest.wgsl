// Slot `sink`: depth of the nearest opaque fragment of each sample.
// slot: sink
#define_import_path lorelei::fragments_nearest
#import lorelei::fragment::{Fragment, band, nearness_of}
#import lorelei::keep::{keep}

@group(0) @binding(auto) var<storage, read_write> nearest: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let mask = keep(fragment);
    for (var k = 0u; k < band.n_samples; k++) {
        if (mask & (1u << k)) != 0u {
            atomicMax(&nearest[fragment.place * band.n_samples + k], nearness_of(fragment.depth));
        }
    }
}
