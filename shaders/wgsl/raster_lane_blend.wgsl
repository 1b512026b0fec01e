// How fragments of a pixel combine in raster_lanes.wgsl: those of a bucket weighted by their coverage, buckets composited
// front to back. Without a branch: see there.
//
// Within a bucket nothing is sorted: what it hides is the product of what its fragments let through, what it shows
// their mean. So the order in which atomics filled the bucket does not matter.
#define_import_path lorelei::raster_lane_blend

// A bucket's sums weighted by coverage, and the share that it stops.
struct Bucket {
    colour: vec4<f32>,
    coverage: f32,
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

fn added(before: Bucket, alpha: f32, colour: vec4<f32>) -> Bucket {
    return Bucket(before.colour + alpha * colour, before.coverage + alpha, before.stopped + alpha * (1.0 - before.stopped));
}

fn blend_add(before: Blend, coverage: f32, open: f32, depth: f32, is_next: bool, colour: vec3<f32>) -> Blend {
    let alpha = saturate(coverage);
    let seen = open * vec4<f32>(colour, 1.0);
    var blend = before;
    blend.open = added(before.open, select(alpha, 0.0, is_next), seen);
    blend.next = added(before.next, select(0.0, alpha, is_next), seen);
    return blend;
}

// What is listed later is behind `closed_depth`.
fn blend_close(before: Blend, closed_depth: f32) -> Blend {
    let shown = (1.0 - before.stopped) * before.open.stopped;
    var blend = Blend();
    blend.colour = before.colour + (shown / max(before.open.coverage, 1e-6)) * before.open.colour;
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
