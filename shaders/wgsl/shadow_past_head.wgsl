// Whether the head stands between a light and a place: look-ups of the depth map of the head.
#define_import_path lorelei::shadow_past_head
#import lorelei::shadow_map::{shadow_params, shadow_lights, map_place, texel_index, front_depth}

// See shadow_head.wgsl.
@group(0) @binding(auto) var<storage, read> shadow_head: array<u32>;

// Centimetres that hair or skin must lie behind the head's front before it is in its shadow, and over which the
// shadow comes: the map's texels are about 0.06 cm and see a surface at up to 60 degrees, and hair roots lie on it.
const HEAD_BIAS: f32 = 0.15;
const HEAD_RAMP: f32 = 0.35;

// Where a light casts no shadow, or has no map: behind it, or outside of what it was fitted to.
fn is_unmapped(light_idx: u32, place: vec4<f32>) -> bool {
    let resolution = vec2<f32>(f32(shadow_params.resolution));
    return shadow_lights[light_idx].casts == 0u || place.w <= 0.0 || any(place.xy < vec2<f32>(0.0))
        || any(place.xy > resolution);
}

// Depth of the head's front in cm at a texel.
fn head_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    return front_depth(shadow_head[texel_index(light_idx, texel)]);
}

fn past_head(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    return 1.0 - smoothstep(HEAD_BIAS, HEAD_BIAS + HEAD_RAMP, depth - head_front(light_idx, texel));
}

// 1 where the head does not stand between the light and a place of the map, between four texels.
fn past_head_at(light_idx: u32, at: vec2<f32>, depth: f32) -> f32 {
    let corner = floor(at - 0.5);
    let f = at - 0.5 - corner;
    let texel = vec2<i32>(corner);
    let near_row = mix(
        past_head(light_idx, texel, depth),
        past_head(light_idx, texel + vec2<i32>(1, 0), depth),
        f.x,
    );
    let far_row = mix(
        past_head(light_idx, texel + vec2<i32>(0, 1), depth),
        past_head(light_idx, texel + vec2<i32>(1, 1), depth),
        f.x,
    );
    return mix(near_row, far_row, f.y);
}

// 1 where the head does not stand between a light and a position.
fn past_head_of(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return 1.0;
    }
    return past_head_at(light_idx, place.xy, place.z);
}

const N_TAPS: u32 = 7u;
// Texels: the narrowest and widest blur of an edge. Wider, seven taps show one by one.
const MIN_BLUR: f32 = 1.5;
const MAX_BLUR: f32 = 10.0;

// One of N_TAPS places of the unit disc: a golden spiral fills it evenly.
fn disc_tap(tap: u32) -> vec2<f32> {
    let angle = 2.3999632 * f32(tap);
    return sqrt((f32(tap) + 0.5) / f32(N_TAPS)) * vec2<f32>(cos(angle), sin(angle));
}

// Texels by which the shadow of what stands at `front` is blurred at a place behind it.
fn blur_of(light_idx: u32, place: vec4<f32>, front: f32) -> f32 {
    let light = &shadow_lights[light_idx];
    let blur_per_cm = (*light).softness * (*light).texels_per_cm / place.w;
    return clamp((place.z - front) * blur_per_cm, MIN_BLUR, MAX_BLUR);
}
