// What a strand leaves in one pixel, what the passes over all fragments know of the picture, and how sums are kept.
// Twin of render/src/fragments/mod.rs.
#define_import_path lorelei::fragment
#import lorelei::raster_frame::{raster}

struct Fragment {
    // The pixel's index among those of the band.
    place: u32,
    pixel: vec2<u32>,
    // Centimetres along the view axis.
    depth: f32,
    // Share of the pixel that is covered, times the fibre's opacity.
    alpha: f32,
    // Samples of the pixel that are covered.
    mask: u32,
    // Linear radiance.
    colour: vec3<f32>,
    // First vertex of the segment, and the strand's random number.
    vertex: u32,
    seed: u32,
    // Centimetres along the strand, from its root.
    along: f32,
}

// Rows of the picture that are made at a time: as many as memory has room for.
struct Band {
    first_row: u32,
    n_rows: u32,
    // Samples kept of each pixel at a time, and in all.
    n_samples: u32,
    n_all_samples: u32,
    // The first of those kept now.
    first_sample: u32,
    seed: u32,
    n_nearest: u32,
    cutoff: f32,
}

@group(0) @binding(auto) var<uniform> band: Band;

// Fixed point of sums of alpha and of alpha x radiance at the picture's exposure. 4,096 fragments as bright as
// BRIGHTEST fit.
const ONE: f32 = 65536.0;
// Brighter than this, at the picture's exposure, is white in every tonemapping.
const BRIGHTEST: f32 = 16.0;

fn fixed(x: f32) -> u32 {
    return u32(x * ONE + 0.5);
}

fn fixed_colour(weight: f32, colour: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(weight * min(colour * raster.exposure, vec3<f32>(BRIGHTEST)) * ONE + 0.5);
}

fn unfixed(x: u32) -> f32 {
    return f32(x) / ONE;
}

fn unfixed_colour(x: vec3<u32>) -> vec3<f32> {
    return vec3<f32>(x) / (ONE * raster.exposure);
}

// Depths as numbers of which the largest is the nearest; 0: none.
fn nearness_of(depth: f32) -> u32 {
    return ~bitcast<u32>(depth);
}

fn depth_of(nearness: u32) -> f32 {
    return bitcast<f32>(~nearness);
}

// The same fragment may come out a little nearer or farther in another pass, whose code is compiled on its own: so many
// units in the last place (a tenth of a micrometre at a metre) are the same depth.
const SAME: u32 = 4u;

fn is_same(a: u32, b: u32) -> bool {
    return max(a, b) - min(a, b) <= SAME;
}

// Three numbers with nine bits each and an exponent for all: EXT_texture_shared_exponent.
fn pack_colour(colour: vec3<f32>) -> u32 {
    let clamped = clamp(colour, vec3<f32>(0.0), vec3<f32>(65408.0));
    let most = max(max(clamped.x, clamped.y), clamped.z);
    var exponent = max(-16, i32(floor(log2(max(most, 1e-20))))) + 16;
    var scale = exp2(f32(24 - exponent));
    if floor(most * scale + 0.5) >= 512.0 {
        exponent += 1;
        scale *= 0.5;
    }
    let mantissas = vec3<u32>(clamped * scale + 0.5);
    return u32(exponent) << 27u | mantissas.z << 18u | mantissas.y << 9u | mantissas.x;
}

fn unpack_colour(packed: u32) -> vec3<f32> {
    let scale = exp2(f32(i32(packed >> 27u) - 24));
    return scale * vec3<f32>(vec3<u32>(packed, packed >> 9u, packed >> 18u) & vec3<u32>(511u));
}
