// Slot `keep`: a strand is opaque, in the one of three samples that its third of all strands owns. 000, line 646.
// slot: keep
#define_import_path lorelei::keep_subset
#import lorelei::fragment::{Fragment}
#import lorelei::hash::{pcg}

const GRAZE: f32 = 0.001;

fn keep(fragment: Fragment) -> u32 {
    return select(0u, 1u << (pcg(fragment.seed) % 3u), fragment.alpha > GRAZE);
}
