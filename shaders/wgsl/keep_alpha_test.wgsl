// Slot `keep`: opaque where alpha is over a threshold. 002, section on transparency.
// slot: keep
#define_import_path lorelei::keep_alpha_test
#import lorelei::fragment::{Fragment, band}

fn keep(fragment: Fragment) -> u32 {
    return select(0u, fragment.mask, fragment.alpha >= max(band.cutoff, 1e-4));
}
