// What `view_count.wgsl` has counted.
#define_import_path lorelei::view_counts

struct CountLook {
    // Strands at the end of the colours.
    most: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(auto) var<uniform> count_look: CountLook;
@group(0) @binding(auto) var view_count: texture_2d<f32>;

// Strands that touch the pixel, and the sum of their coverage.
fn counts(pixel: vec2<u32>) -> vec2<f32> {
    return textureLoad(view_count, pixel, 0).xy;
}

fn most() -> f32 {
    return count_look.most;
}
