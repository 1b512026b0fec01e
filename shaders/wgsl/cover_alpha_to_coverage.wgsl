// Slot `cover`: as many of four samples as the area asks for, rounded by a threshold of the pixel's own.
// slot: cover
#define_import_path lorelei::cover_alpha_to_coverage

const N_SAMPLES: u32 = 0u;

fn sample_offset(k: u32) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn settled(area: f32, dither: f32) -> f32 {
    return 0.25 * floor(4.0 * saturate(area) + dither);
}

fn samples_of(area: f32) -> u32 {
    return (1u << u32(round(saturate(area) * 4.0))) - 1u;
}
