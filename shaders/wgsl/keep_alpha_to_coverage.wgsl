// Slot `keep`: opaque in as many of four samples as alpha asks for, always the same ones: a screen door. 000, line 565.
// slot: keep
#define_import_path lorelei::keep_alpha_to_coverage
#import lorelei::fragment::{Fragment}
#import lorelei::hash::{combine, unit}

fn keep(fragment: Fragment) -> u32 {
    // The pixel's own threshold, as graphics cards dither: on average as much is covered as alpha says.
    let dither = unit(combine(fragment.pixel.x, fragment.pixel.y));
    return (1u << u32(clamp(4.0 * fragment.alpha + dither, 0.0, 4.0))) - 1u;
}
