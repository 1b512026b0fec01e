// Slot `lane_blend`: fragments of a bucket weighted by their coverage, buckets composited front to back. Without a
// branch: see raster_lanes.wgsl.
//
// Within a bucket nothing is sorted: what it hides is the product of what its fragments let through, what it shows
// their mean. So the order in which atomics filled the bucket does not matter.
// slot: lane_blend
#define_import_path lorelei::lane_blend_front_to_back

struct Blend {
    // Premultiplied, of the closed buckets.
    colour: vec4<f32>,
    // The open bucket: sums weighted by coverage, and the share that it stops.
    bucket_colour: vec4<f32>,
    // Share of the light from behind that the closed buckets stop.
    stopped: f32,
    bucket_coverage: f32,
    bucket_stopped: f32,
}

// Where so much is stopped, what little is still to come is taken to look like what is there.
const OPAQUE: f32 = 0.99;

fn blend_add(before: Blend, coverage: f32, open: f32, depth: f32, colour: vec3<f32>) -> Blend {
    let alpha = saturate(coverage);
    var blend = before;
    blend.bucket_colour += (alpha * open) * vec4<f32>(colour, 1.0);
    blend.bucket_coverage += alpha;
    blend.bucket_stopped += alpha * (1.0 - blend.bucket_stopped);
    return blend;
}

fn blend_close(before: Blend) -> Blend {
    let shown = (1.0 - before.stopped) * before.bucket_stopped;
    var blend = Blend();
    blend.colour = before.colour + (shown / max(before.bucket_coverage, 1e-6)) * before.bucket_colour;
    blend.stopped = before.stopped + shown;
    return blend;
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.stopped > OPAQUE;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour / select(1.0, blend.stopped, blend_is_done(blend));
}
