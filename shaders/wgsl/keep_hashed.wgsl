// Slot `keep`: opaque where alpha is over a threshold that is hashed from the place on the strand (Wyman and McGuire
// 2017, "Improved Alpha Testing Using Hashed Sampling"). The hash belongs to the hair and not to the screen: noise moves
// with the strand instead of crawling over it.
// slot: keep
#define_import_path lorelei::keep_hashed
#import lorelei::fragment::{Fragment}
#import lorelei::raster_frame::{raster}
#import lorelei::hash::{combine, unit}

fn cell_noise(seed: u32, along: f32, cell: f32) -> f32 {
    return unit(combine(combine(seed, u32(i32(floor(along / cell)))), bitcast<u32>(cell)));
}

fn keep(fragment: Fragment) -> u32 {
    // Cells about as long as a pixel: two powers of two, mixed so that neither comes suddenly.
    let size = log2(fragment.depth / raster.view.pixels_per_tangent);
    let between = fract(size);
    let fine = cell_noise(fragment.seed, fragment.along, exp2(floor(size)));
    let coarse = cell_noise(fragment.seed, fragment.along, exp2(floor(size) + 1.0));
    let x = mix(fine, coarse, between);
    // Two even distributions mixed are not even: their cumulative distribution makes them so (the paper's listing).
    let a = min(between, 1.0 - between);
    var threshold = 0.5 * x * x / max(a * (1.0 - a), 1e-6);
    if x >= a {
        threshold = (x - 0.5 * a) / (1.0 - a);
    }
    if x >= 1.0 - a {
        threshold = 1.0 - 0.5 * (1.0 - x) * (1.0 - x) / max(a * (1.0 - a), 1e-6);
    }
    return select(0u, fragment.mask, fragment.alpha > clamp(threshold, 1e-4, 1.0));
}
