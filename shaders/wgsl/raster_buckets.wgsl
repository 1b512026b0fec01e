// Depth buckets of a tile. They are finest at the tile's front, where a pixel still lets light through, and grow with the
// distance from it: log2 of 1 + distance / FINEST, a quarter of them before the front.
//
// A segment is listed in the bucket in which it comes nearest within the tile. Its fragments go to the bucket of their
// own depth, as far as that one is open: where two locks cross, pixels change from one to the other and not tiles.
#define_import_path lorelei::raster_buckets

const N_BUCKETS: u32 = 32u;
// Centimetres.
const FINEST: f32 = 0.4;
const NEAREST: f32 = 8.0;
const DEEPEST: f32 = 25.0;
const N_BEFORE: f32 = 8.0;
const N_BEHIND: f32 = 24.0;

// Where a depth behind the front lies: its bucket, and how far into it.
fn bucket_place(behind: f32) -> f32 {
    let size = log2(1.0 + abs(behind) / FINEST);
    let place = select(
        size * (N_BEHIND / log2(1.0 + DEEPEST / FINEST)),
        -size * (N_BEFORE / log2(1.0 + NEAREST / FINEST)),
        behind < 0.0,
    );
    return clamp(N_BEFORE + place, 0.0, f32(N_BUCKETS) - 1e-3);
}

fn bucket_of(behind: f32) -> u32 {
    return u32(bucket_place(behind));
}

// Where a bucket ends, behind the front; the last one never does.
fn bucket_end(bucket: u32) -> f32 {
    let place = f32(bucket + 1u) - N_BEFORE;
    let per_place = select(
        log2(1.0 + DEEPEST / FINEST) / N_BEHIND,
        log2(1.0 + NEAREST / FINEST) / N_BEFORE,
        place < 0.0,
    );
    let distance = FINEST * (exp2(abs(place) * per_place) - 1.0);
    return select(select(distance, -distance, place < 0.0), 1e30, bucket >= N_BUCKETS - 1u);
}

// By how much a bucket looks brighter than the mean of what is in it, because its front hides its back. `optical` is its
// optical depth, `place` the mean place of its fragments (0 front, 1 back) and `with_place` the mean of brightness x place,
// over the mean brightness; all three weighted alike.
//
// Compute: fragments lie evenly over place +- w, brightness changes evenly over them, and light from s of the way in is
// weighted by exp(-optical s), whose mean is 1 / optical - 1 / (exp(optical) - 1).
fn front_gain(optical: f32, place: f32, with_place: f32) -> f32 {
    let w = max(min(place, 1.0 - place), 0.05);
    let seen = select(1.0 / optical - 1.0 / (exp(min(optical, 80.0)) - 1.0), 0.5 - optical / 12.0, optical < 0.05);
    return clamp(1.0 + 6.0 * (with_place - place) / w * (seen - 0.5), 0.5, 2.0);
}
