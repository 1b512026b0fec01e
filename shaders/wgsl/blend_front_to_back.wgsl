// Slot `blend`: fragments of a bucket weighted by their coverage, buckets composited front to back.
//
// Within a bucket nothing is sorted: what it hides is the product of what its fragments let through, what it shows
// their mean. So the order in which atomics filled the bucket does not matter.
// slot: blend
#define_import_path lorelei::blend_front_to_back

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

fn blend_add(blend: ptr<function, Blend>, coverage: f32, open: f32, depth: f32, colour: vec3<f32>) {
    let alpha = clamp(coverage, 0.0, 1.0);
    (*blend).bucket_colour += alpha * open * vec4<f32>(colour, 1.0);
    (*blend).bucket_coverage += alpha;
    (*blend).bucket_stopped += alpha * (1.0 - (*blend).bucket_stopped);
}

fn blend_close(blend: ptr<function, Blend>) {
    if (*blend).bucket_coverage > 0.0 {
        let shown = (1.0 - (*blend).stopped) * (*blend).bucket_stopped;
        (*blend).colour += (shown / (*blend).bucket_coverage) * (*blend).bucket_colour;
        (*blend).stopped += shown;
    }
    (*blend).bucket_colour = vec4<f32>(0.0);
    (*blend).bucket_coverage = 0.0;
    (*blend).bucket_stopped = 0.0;
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.stopped > OPAQUE;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour / select(1.0, blend.stopped, blend_is_done(blend));
}
