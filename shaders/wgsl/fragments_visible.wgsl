// Slot `sink`: colour of the nearest opaque fragment of each sample. Of several at the same depth the brightest, whichever
// thread comes first.
// slot: sink
#define_import_path lorelei::fragments_visible
#import lorelei::fragment::{Fragment, band, nearness_of, is_same, pack_colour}
#import lorelei::keep::{keep}

@group(0) @binding(auto) var<storage, read> nearest: array<u32>;
@group(0) @binding(auto) var<storage, read_write> visible: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let mask = keep(fragment);
    for (var k = 0u; k < band.n_samples; k++) {
        let at = fragment.place * band.n_samples + k;
        if (mask & (1u << k)) != 0u && is_same(nearest[at], nearness_of(fragment.depth)) {
            atomicMax(&visible[at], pack_colour(fragment.colour));
        }
    }
}
