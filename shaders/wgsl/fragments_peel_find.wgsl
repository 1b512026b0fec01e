// Slot `sink`: the nearest fragment behind the layer that was peeled last.
// slot: sink
#define_import_path lorelei::fragments_peel_find
#import lorelei::fragment::{Fragment, nearness_of, SAME}

// Depth of the last layer; infinite: the pixel is done.
@group(0) @binding(auto) var<storage, read> peeled: array<f32>;
@group(0) @binding(auto) var<storage, read_write> nearest: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let mine = nearness_of(fragment.depth);
    if mine + SAME < nearness_of(peeled[fragment.place]) {
        atomicMax(&nearest[fragment.place], mine);
    }
}
