// How fragments of a pixel combine in raster_lanes.wgsl: those of a bucket weighted by their coverage, buckets composited
// front to back. Without a branch: see there.
//
// Within a bucket nothing is sorted: what it hides is the product of what its fragments let through, what it shows
// their mean. So the order in which atomics filled the bucket does not matter.
#define_import_path lorelei::raster_lane_blend
#import lorelei::raster_buckets::{front_gain}

// A bucket's sums weighted by coverage, and the share that it stops.
struct Bucket {
    colour: vec4<f32>,
    // Coverage, and coverage and brightness (the sum of the colours) times the place in the bucket.
    coverage: f32,
    place: f32,
    bright_place: f32,
    stopped: f32,
}

struct Blend {
    // Premultiplied, of the closed buckets.
    colour: vec4<f32>,
    // Share of the light from behind that the closed buckets stop.
    stopped: f32,
    open: Bucket,
    // What is behind the open one.
    next: Bucket,
}

// Where so much is stopped, what little is still to come is taken to look like what is there.
const OPAQUE: f32 = 0.99;

fn added(before: Bucket, alpha: f32, place: f32, colour: vec4<f32>) -> Bucket {
    let there = alpha * place;
    return Bucket(
        before.colour + alpha * colour,
        before.coverage + alpha,
        before.place + there,
        before.bright_place + there * (colour.x + colour.y + colour.z),
        before.stopped + alpha * (1.0 - before.stopped),
    );
}

// `range`: depths at which the open bucket begins and ends, and 1 / their difference.
fn blend_add(before: Blend, coverage: f32, open: f32, depth: f32, range: vec3<f32>, colour: vec3<f32>) -> Blend {
    let alpha = saturate(coverage);
    let seen = open * vec4<f32>(colour, 1.0);
    let is_next = depth > range.y;
    let place = saturate((depth - select(range.x, range.y, is_next)) * range.z);
    var blend = before;
    blend.open = added(before.open, select(alpha, 0.0, is_next), place, seen);
    blend.next = added(before.next, select(0.0, alpha, is_next), place, seen);
    return blend;
}

// Composite the open bucket.
fn blend_close(before: Blend) -> Blend {
    let shown = (1.0 - before.stopped) * before.open.stopped;
    var blend = Blend();
    let bucket = before.open;
    let per_coverage = 1.0 / max(bucket.coverage, 1e-6);
    let bright = max(bucket.colour.x + bucket.colour.y + bucket.colour.z, 1e-9);
    let optical = -log(max(1.0 - bucket.stopped, 1e-4));
    let gain = front_gain(optical, bucket.place * per_coverage, bucket.bright_place / bright);
    blend.colour = before.colour + shown * per_coverage * bucket.colour * vec4<f32>(vec3<f32>(gain), 1.0);
    blend.stopped = before.stopped + shown;
    blend.open = before.next;
    return blend;
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.stopped > OPAQUE;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour / select(1.0, blend.stopped, blend_is_done(blend));
}
