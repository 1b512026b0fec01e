// The share of a pixel that a strip covers: twin of what render/src/exact.rs finds by clipping, but for a strip without
// ends.
#define_import_path lorelei::coverage

// Integral of the pixel's profile across the strip, from one side to `x` pixels beyond the pixel's middle. The profile
// of a unit square seen along a direction is a trapezoid of area 1: flat to `inner`, falling to 0 at `outer`.
fn profile_integral(x: f32, inner: f32, outer: f32) -> f32 {
    let beyond = max(abs(x) - inner, 0.0);
    let rest = max(outer - abs(x), 0.0);
    let height = 1.0 / (inner + outer);
    let flat = height * min(abs(x), inner);
    let width = max(outer - inner, 1e-6);
    // Area of the falling side up to x: the whole triangle less what is left of it.
    let side = height * 0.5 * (width - min(rest, width) * min(rest, width) / width) * select(0.0, 1.0, beyond > 0.0);
    return sign(x) * (flat + side);
}

// `across`: from the strip's middle to the pixel's centre, in pixels; `normal`: unit vector across the strip.
fn strip_coverage(across: f32, half_width: f32, normal: vec2<f32>) -> f32 {
    let n = abs(normal);
    let inner = 0.5 * abs(n.x - n.y);
    let outer = 0.5 * (n.x + n.y);
    let covered = profile_integral(across + half_width, inner, outer) - profile_integral(across - half_width, inner, outer);
    return clamp(covered, 0.0, 1.0);
}
