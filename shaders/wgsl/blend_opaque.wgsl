// Slot `blend`: the nearest strand that touches a pixel covers all of it.
// slot: blend
#define_import_path lorelei::blend_opaque
#import lorelei::tile::{N_PIXELS}

struct Blend {
    colour: vec4<f32>,
    is_done: bool,
}

struct BlendScale {
    none: f32,
}

// Buckets that are open at once, and how many of them are filled and closed in a step.
const N_OPEN: u32 = 4u;
const N_STEP: u32 = 2u;
// Times that a segment's pixels are visited: first for which is the nearest, then for its colour.
const N_WALKS: u32 = 2u;
// Less than this share of the pixel is a graze, not a hair.
const GRAZE: f32 = 0.001;

// For each pixel: 1 / depth of the nearest fragment (bits of a positive number are in its order), and its colour.
var<workgroup> nearest: array<atomic<u32>, N_PIXELS>;
var<workgroup> colours: array<vec3<f32>, N_PIXELS>;

fn blend_scale(n_segments: u32) -> BlendScale {
    return BlendScale(0.0);
}

fn blend_clear(pixel: u32) {
    atomicStore(&nearest[pixel], 0u);
}

fn blend_add(walk_idx: u32, scale: BlendScale, bucket: u32, pixel: u32, coverage: f32, open: f32, depth: f32, colour: vec3<f32>) {
    if coverage < GRAZE || open < 0.5 {
        return;
    }
    let nearness = bitcast<u32>(1.0 / depth);
    if walk_idx == 0u {
        atomicMax(&nearest[pixel], nearness);
    } else if nearness == atomicLoad(&nearest[pixel]) {
        colours[pixel] = colour;
    }
}

// What is listed later is behind `closed_depth`.
fn blend_close(blend: ptr<function, Blend>, scale: BlendScale, first_bucket: u32, pixel: u32, closed_depth: f32) {
    let nearness = bitcast<f32>(atomicLoad(&nearest[pixel]));
    if nearness > 0.0 {
        (*blend).colour = vec4<f32>(colours[pixel], 1.0);
        (*blend).is_done = nearness * closed_depth > 1.0;
    }
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.is_done;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour;
}
