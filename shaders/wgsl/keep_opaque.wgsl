// Slot `keep`: whatever touches a pixel is opaque there.
// slot: keep
#define_import_path lorelei::keep_opaque
#import lorelei::fragment::{Fragment}

// Less than this share of the pixel is a graze, not a hair.
const GRAZE: f32 = 0.001;

// Samples in which a fragment is opaque.
fn keep(fragment: Fragment) -> u32 {
    return select(0u, fragment.mask, fragment.alpha > GRAZE);
}
