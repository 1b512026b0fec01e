// How much of a pixel a straight strip covers.
#define_import_path lorelei::coverage

// A segment in pixels: `from`, unit direction, length; half widths at its ends.
struct Strip {
    origin: vec2<f32>,
    along: vec2<f32>,
    length: f32,
    half_widths: vec2<f32>,
}

// Area of the unit square around the origin on the side `n . p <= t` of a line with unit normal n, a = max |n_i| and
// b = min |n_i|: the integral of the square's projection on n, which is a trapezoid of height 1 / a.
fn half_plane_area(a: f32, b: f32, t: f32) -> f32 {
    let reach = 0.5 * (a + b);
    let flat = 0.5 * (a - b);
    let at = min(abs(t), reach);
    // Where b is 0 the corner piece has no width and `rest` is 0 too.
    let rest = reach - at;
    let corner = 0.5 - rest * rest / max(2.0 * a * b, 1e-9);
    let side = select(corner, at / a, at <= flat);
    return 0.5 + sign(t) * side;
}

// Place of a pixel's centre in the strip's own frame: along it from its origin, and across.
fn strip_place(strip: Strip, centre: vec2<f32>) -> vec2<f32> {
    let q = centre - strip.origin;
    return vec2<f32>(dot(q, strip.along), q.y * strip.along.x - q.x * strip.along.y);
}

// Half the extent of a pixel across the strip, and the length of strip that belongs to a pixel at an end.
fn strip_reach(strip: Strip) -> vec2<f32> {
    let size = abs(strip.along);
    return vec2<f32>(0.5 * (size.x + size.y), max(size.x, size.y));
}

// Covered area of the pixel at `place`. Across, the area is exact. At an end it falls linearly over one pixel, so that
// two segments of one strand share the pixel of their joint: their areas add to the strand's.
fn strip_coverage(strip: Strip, place: vec2<f32>) -> f32 {
    let size = abs(strip.along);
    let a = max(size.x, size.y);
    let b = min(size.x, size.y);
    let t = clamp(place.x / strip.length, 0.0, 1.0);
    let half_width = mix(strip.half_widths.x, strip.half_widths.y, t);
    let across = half_plane_area(a, b, place.y + half_width) - half_plane_area(a, b, place.y - half_width);
    let root = clamp(place.x / a + 0.5, 0.0, 1.0);
    let tip = clamp((place.x - strip.length) / a + 0.5, 0.0, 1.0);
    return across * (root - tip);
}
