// How fragments of a pixel combine in raster_fine.wgsl: those of a bucket weighted by their optical depth, buckets
// composited front to back.
//
// Within a bucket nothing is sorted: what it hides is the product of what its fragments let through, what it shows
// their mean, and by how much its front is brighter or darker (`front_gain`). So the order in which threads come to a
// pixel does not matter.
#define_import_path lorelei::raster_blend
#import lorelei::raster_frame::{raster}
#import lorelei::raster_buckets::{front_gain}
#import lorelei::tile::{N_PIXELS}

struct Blend {
    // Premultiplied, of the closed buckets.
    colour: vec4<f32>,
    // Share of the light from behind that the closed buckets stop.
    stopped: f32,
}

// Buckets that are open at once, and how many of them are filled and closed in a step. Their sums lie in a ring.
const N_OPEN: u32 = 4u;
const N_STEP: u32 = 2u;
// Where so much is stopped, what little is still to come is taken to look like what is there.
const OPAQUE: f32 = 0.99;
// Optical depth of a fragment that stops everything (less than 1 - OPAQUE comes through).
const MOST: f32 = 5.0;
// Fixed point of optical depths.
const DEPTH_ONE: f32 = 4096.0;
// Brighter than this, at the picture's exposure, is white in every tonemapping.
const BRIGHTEST: f32 = 16.0;

// Fixed point of colours, which are radiance x optical depth at the picture's exposure.
struct BlendScale {
    colour: f32,
    per_colour: f32,
}

// For each open bucket and pixel: optical depth, how much of that the head hides, three colours; and optical depth and
// brightness (the sum of the colours) times the place in the bucket.
var<workgroup> depths: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> shut: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> reds: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> greens: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> blues: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> places: array<atomic<u32>, N_OPEN * N_PIXELS>;
var<workgroup> bright_places: array<atomic<u32>, N_OPEN * N_PIXELS>;

// A segment comes to a pixel once: no sum of so many segments overflows.
fn blend_scale(n_segments: u32) -> BlendScale {
    let most = 4294967040.0 / f32(n_segments);
    let colour = min(most / (MOST * BRIGHTEST) - 1.0, 1048576.0);
    return BlendScale(raster.exposure * colour, 1.0 / (raster.exposure * colour));
}

fn clear(at: u32) {
    atomicStore(&depths[at], 0u);
    atomicStore(&shut[at], 0u);
    atomicStore(&reds[at], 0u);
    atomicStore(&greens[at], 0u);
    atomicStore(&blues[at], 0u);
    atomicStore(&places[at], 0u);
    atomicStore(&bright_places[at], 0u);
}

fn blend_clear(pixel: u32) {
    for (var k = 0u; k < N_OPEN; k++) {
        clear(k * N_PIXELS + pixel);
    }
}

fn blend_add(scale: BlendScale, bucket: u32, pixel: u32, coverage: f32, open: f32, place: f32, colour: vec3<f32>) {
    let at = bucket % N_OPEN * N_PIXELS + pixel;
    let optical = min(-log(max(1.0 - coverage, 1e-6)), MOST);
    let brightest = vec3<f32>(BRIGHTEST / raster.exposure);
    let weighted = (optical * open * scale.colour) * min(colour, brightest) + 0.5;
    atomicAdd(&depths[at], u32(optical * DEPTH_ONE + 0.5));
    atomicAdd(&places[at], u32(optical * place * DEPTH_ONE + 0.5));
    atomicAdd(&bright_places[at], u32((weighted.x + weighted.y + weighted.z - 1.5) * (place / 3.0) + 0.5));
    atomicAdd(&reds[at], u32(weighted.x));
    atomicAdd(&greens[at], u32(weighted.y));
    atomicAdd(&blues[at], u32(weighted.z));
    if open < 1.0 {
        atomicAdd(&shut[at], u32(optical * (1.0 - open) * DEPTH_ONE + 0.5));
    }
}

// Composite the buckets of a step; their places in the ring are free for later ones.
fn blend_close(blend: ptr<function, Blend>, scale: BlendScale, first_bucket: u32, pixel: u32) {
    for (var k = 0u; k < N_STEP; k++) {
        let at = (first_bucket + k) % N_OPEN * N_PIXELS + pixel;
        let optical = f32(atomicLoad(&depths[at])) / DEPTH_ONE;
        if optical > 0.0 {
            let open = 1.0 - f32(atomicLoad(&shut[at])) / (DEPTH_ONE * optical);
            let shown = (1.0 - (*blend).stopped) * (1.0 - exp(-optical));
            let colour = vec3<f32>(f32(atomicLoad(&reds[at])), f32(atomicLoad(&greens[at])), f32(atomicLoad(&blues[at])));
            let place = f32(atomicLoad(&places[at])) / (DEPTH_ONE * optical);
            let bright = max((colour.x + colour.y + colour.z) / 3.0, 1.0);
            let gain = front_gain(optical, place, f32(atomicLoad(&bright_places[at])) / bright);
            (*blend).colour += shown * vec4<f32>(colour * (gain * scale.per_colour / optical), open);
            (*blend).stopped += shown;
            clear(at);
        }
    }
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.stopped > OPAQUE;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour / select(1.0, blend.stopped, blend_is_done(blend));
}
