// Slot `cover`: four samples of a pixel on a rotated grid, as graphics cards have them.
// slot: cover
#define_import_path lorelei::cover_msaa4

const N_SAMPLES: u32 = 4u;

// The standard pattern of four samples (Direct3D 11.3 specification, 19.2.4.1): multiples of a sixteenth.
fn sample_offset(k: u32) -> vec2<f32> {
    var offsets = array<vec2<f32>, 4>(
        vec2<f32>(-0.125, -0.375),
        vec2<f32>(0.375, -0.125),
        vec2<f32>(-0.375, 0.125),
        vec2<f32>(0.125, 0.375),
    );
    return offsets[k];
}

fn settled(area: f32, dither: f32) -> f32 {
    return area;
}

fn samples_of(area: f32) -> u32 {
    return (1u << u32(round(saturate(area) * 4.0))) - 1u;
}
