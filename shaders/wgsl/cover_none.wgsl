// Slot `cover`: a strip covers a pixel whose centre it touches.
// slot: cover
#define_import_path lorelei::cover_none

const N_SAMPLES: u32 = 1u;

fn sample_offset(k: u32) -> vec2<f32> {
    return vec2<f32>(0.0);
}

fn settled(area: f32, dither: f32) -> f32 {
    return area;
}

fn samples_of(area: f32) -> u32 {
    return select(0u, 1u, area > 0.0);
}
