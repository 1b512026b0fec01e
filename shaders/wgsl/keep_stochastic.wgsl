// Slot `keep`: opaque in samples chosen at random, each with the probability alpha (Enderton et al. 2010). Fragments
// choose independently of each other, so the mean over samples and seeds is the exact composite.
// slot: keep
#define_import_path lorelei::keep_stochastic
#import lorelei::fragment::{Fragment, band}
#import lorelei::hash::{combine, unit}

fn keep(fragment: Fragment) -> u32 {
    let of_pixel = combine(combine(band.seed, fragment.pixel.x), fragment.pixel.y);
    let of_fragment = combine(of_pixel, fragment.vertex);
    var mask = 0u;
    for (var k = 0u; k < band.n_samples; k++) {
        let is_kept = unit(combine(of_fragment, band.first_sample + k)) < fragment.alpha;
        mask |= select(0u, 1u << k, is_kept && band.first_sample + k < band.n_all_samples);
    }
    return mask;
}
