// Slot `background`: the picture of what is all around, as the tonemapper shows it.
// slot: background
#define_import_path lorelei::background_environment
#import lorelei::behind::{Behind}
#import lorelei::tonemap::{display}

@group(0) @binding(auto) var panorama: texture_2d<f32>;
@group(0) @binding(auto) var panorama_sampler: sampler;

const PI: f32 = 3.14159265358979324;

// The place of a unit direction in the picture. Twin of `place_of` in core/src/panorama/mod.rs.
fn panorama_place(d: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(0.5 - atan2(d.x, d.z) / (2.0 * PI), 0.5 - asin(clamp(d.y, -1.0, 1.0)) / PI);
}

// A cubic B-spline through four bilinear lookups (Sigg and Hadwiger 2005): a texel is many pixels wide, and it is not seen.
fn smooth_radiance(place: vec2<f32>) -> vec3<f32> {
    let size = vec2<f32>(textureDimensions(panorama));
    let at = place * size - 0.5;
    let f = fract(at);
    let corner = floor(at);
    let f2 = f * f;
    let f3 = f2 * f;
    let w0 = (1.0 - f) * (1.0 - f) * (1.0 - f) / 6.0;
    let w1 = (4.0 - 6.0 * f2 + 3.0 * f3) / 6.0;
    let w3 = f3 / 6.0;
    let g0 = w0 + w1;
    let g1 = 1.0 - g0;
    let low = (corner - 0.5 + w1 / g0) / size;
    let high = (corner + 1.5 + w3 / g1) / size;
    let above = mix(
        textureSampleLevel(panorama, panorama_sampler, high, 0.0).xyz,
        textureSampleLevel(panorama, panorama_sampler, vec2<f32>(low.x, high.y), 0.0).xyz,
        g0.x,
    );
    let below = mix(
        textureSampleLevel(panorama, panorama_sampler, vec2<f32>(high.x, low.y), 0.0).xyz,
        textureSampleLevel(panorama, panorama_sampler, low, 0.0).xyz,
        g0.x,
    );
    return mix(above, below, g0.y);
}

// Display value and alpha.
fn background(behind: Behind) -> vec4<f32> {
    // The picture is turned; the ray is turned back.
    let c = cos(behind.turn);
    let s = sin(behind.turn);
    let d = vec3<f32>(behind.ray.x * c - behind.ray.z * s, behind.ray.y, behind.ray.x * s + behind.ray.z * c);
    let l = smooth_radiance(panorama_place(d)) * behind.gain;
    return vec4<f32>(display(behind.picture_from_scene * l), 1.0);
}
