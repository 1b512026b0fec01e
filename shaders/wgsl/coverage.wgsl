// How much of a pixel a straight strip covers.
#define_import_path lorelei::coverage

// A segment in pixels, with what does not change from pixel to pixel.
struct Strip {
    length: f32,
    per_length: f32,
    // Half widths at its ends, and the larger one.
    half_widths: vec2<f32>,
    half_width: f32,
    // Larger and smaller component of the unit direction.
    a: f32,
    b: f32,
    per_a: f32,
    // 1 / (a b).
    ramp: f32,
    // Half the extent of a pixel across the strip.
    reach: f32,
}

// Half widths in pixels below which a strip is a line with a weight: see strip_coverage.
const THIN: f32 = 0.2;

fn strip_of(along: vec2<f32>, length: f32, half_widths: vec2<f32>) -> Strip {
    let size = abs(along);
    let a = max(size.x, size.y);
    let b = min(size.x, size.y);
    let half_width = max(half_widths.x, half_widths.y);
    return Strip(length, 1.0 / length, half_widths, half_width, a, b, 1.0 / a, 1.0 / max(a * b, 1e-6), 0.5 * (a + b));
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

// Area of the part of a pixel that is inside a strip without ends, whose middle passes at `across` from the pixel's
// centre; of the shape (ramp, per_a, reach) of its direction.
fn wide_across(shape: vec3<f32>, across: f32, half_width: f32) -> f32 {
    let a = 1.0 / shape.y;
    let b = 2.0 * shape.z - a;
    return half_plane_area(a, b, across + half_width) - half_plane_area(a, b, across - half_width);
}

// The same for strips so thin that their width times the area's derivative in their middle is as good. Its sum over
// a column of pixels is exact.
fn thin_across(shape: vec3<f32>, across: f32, half_width: f32) -> f32 {
    return 2.0 * half_width * clamp((shape.z - abs(across)) * shape.x, 0.0, shape.y);
}

// Covered area of the pixel at `place`: its centre along the strip from its origin, and across (either side);
// t is along / length, 0 to 1. At an end it falls linearly over one pixel, so that two segments of one strand share
// the pixel of their joint: their areas add to the strand's.
fn strip_coverage(strip: Strip, place: vec2<f32>, t: f32) -> f32 {
    let half_width = mix(strip.half_widths.x, strip.half_widths.y, t);
    let shape = vec3<f32>(strip.ramp, strip.per_a, strip.reach);
    var across: f32;
    if strip.half_width < THIN {
        across = thin_across(shape, place.y, half_width);
    } else {
        across = wide_across(shape, place.y, half_width);
    }
    let root = saturate(place.x * strip.per_a + 0.5);
    let tip = saturate((place.x - strip.length) * strip.per_a + 0.5);
    return across * (root - tip);
}

// Whether a place (along the strip, across it) is inside. Half open, so that two segments of a strand share none.
fn is_inside(strip: Strip, place: vec2<f32>) -> bool {
    let half_width = mix(strip.half_widths.x, strip.half_widths.y, saturate(place.x * strip.per_length));
    return place.x >= 0.0 && place.x < strip.length && abs(place.y) <= half_width;
}
