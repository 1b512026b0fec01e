// Slot `cover`: the exact share of a pixel that lies under a strip.
// slot: cover
#define_import_path lorelei::cover_analytic

// Samples of a pixel that are tested; none: the area decides.
const N_SAMPLES: u32 = 0u;

fn sample_offset(k: u32) -> vec2<f32> {
    return vec2<f32>(0.0);
}

// What becomes of an area; `dither` in 0-1 belongs to the pixel.
fn settled(area: f32, dither: f32) -> f32 {
    return area;
}

// The samples that an area (settled) covers.
fn samples_of(area: f32) -> u32 {
    return select(0u, 1u, area > 0.0);
}
