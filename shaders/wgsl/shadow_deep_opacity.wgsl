// Slot `shadow`: what of a light arrives, from deep opacity maps of the hair and a depth map of the head.
// slot: shadow
#define_import_path lorelei::shadow_deep_opacity
#import lorelei::shadow_map::{ShadowLight, ShadowParams, map_place, layer_of}

@group(0) @binding(auto) var<uniform> shadow_params: ShadowParams;
@group(0) @binding(auto) var<storage, read> shadow_lights: array<ShadowLight>;
@group(0) @binding(auto) var<storage, read> shadow_filtered: array<f32>;
@group(0) @binding(auto) var shadow_head: texture_depth_2d_array;

// Centimetres that hair or skin must lie behind the head's front before it is in its shadow, and over which the
// shadow comes: the map's texels are about 0.06 cm and see a surface at up to 60 degrees, and hair roots lie on it.
const HEAD_BIAS: f32 = 0.15;
const HEAD_RAMP: f32 = 0.35;

// Optical depth of one filtered texel at a depth from the light.
fn texel_depth(light_idx: u32, texel: vec2<i32>, depth: f32) -> f32 {
    let resolution = i32(shadow_params.resolution);
    let clamped = clamp(texel, vec2<i32>(0), vec2<i32>(resolution - 1));
    let n_texels = shadow_params.resolution * shadow_params.resolution;
    let at = (light_idx * n_texels + u32(clamped.y * resolution + clamped.x)) * (shadow_params.n_layers + 1u);
    let behind = depth - shadow_filtered[at];
    if behind <= 0.0 {
        return 0.0;
    }
    let layer = layer_of(behind, shadow_params.layer_size, shadow_params.n_layers);
    let below = min(u32(layer), shadow_params.n_layers - 1u);
    // At the front the optical depth is 0; it has no number of its own.
    let upper = select(shadow_filtered[at + below], 0.0, below == 0u);
    return mix(upper, shadow_filtered[at + below + 1u], layer - f32(below));
}

// Optical depth at a place of the map, between four texels.
fn depth_at(light_idx: u32, at: vec2<f32>, depth: f32) -> f32 {
    let corner = floor(at - 0.5);
    let f = at - 0.5 - corner;
    let texel = vec2<i32>(corner);
    let near_row = mix(
        texel_depth(light_idx, texel, depth),
        texel_depth(light_idx, texel + vec2<i32>(1, 0), depth),
        f.x,
    );
    let far_row = mix(
        texel_depth(light_idx, texel + vec2<i32>(0, 1), depth),
        texel_depth(light_idx, texel + vec2<i32>(1, 1), depth),
        f.x,
    );
    return shadow_params.density * mix(near_row, far_row, f.y);
}

// Depth of the head's front in cm at a texel.
fn head_front(light_idx: u32, texel: vec2<i32>) -> f32 {
    let light = &shadow_lights[light_idx];
    let clamped = clamp(texel, vec2<i32>(0), vec2<i32>(i32(shadow_params.resolution) - 1));
    return mix((*light).near, (*light).far, textureLoad(shadow_head, clamped, i32(light_idx), 0));
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

// Where a light casts no shadow, or has no map: behind it, or outside of what it was fitted to.
fn is_unmapped(light_idx: u32, place: vec4<f32>) -> bool {
    let resolution = vec2<f32>(f32(shadow_params.resolution));
    return shadow_lights[light_idx].casts == 0u || place.w <= 0.0 || any(place.xy < vec2<f32>(0.0))
        || any(place.xy > resolution);
}

// Optical depth of the hair between a light and a position: exp(-hair_depth) of the light comes through black fibres.
fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return 0.0;
    }
    // A fibre is as wide as its share of a texel: what lies within half a texel before it is mostly itself.
    let own = 0.5 * place.w / shadow_lights[light_idx].texels_per_cm;
    return depth_at(light_idx, place.xy, place.z - own);
}

// For hair: 1 where the head does not stand between a light and a position.
fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
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

// For surfaces: the share of a light that reaches a position through hair and past the head, with edges that soften with
// the distance to what casts the shadow, as the size of the light has it.
fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    let light = shadow_lights[light_idx];
    let place = map_place(light, position);
    if is_unmapped(light_idx, place) {
        return 1.0;
    }
    let resolution = i32(shadow_params.resolution);
    let texel = clamp(vec2<i32>(place.xy), vec2<i32>(0), vec2<i32>(resolution - 1));
    let n_texels = shadow_params.resolution * shadow_params.resolution;
    let at = (light_idx * n_texels + u32(texel.y * resolution + texel.x)) * (shadow_params.n_layers + 1u);
    let blur_per_cm = light.softness * light.texels_per_cm / place.w;
    let hair_blur = clamp((place.z - shadow_filtered[at]) * blur_per_cm, MIN_BLUR, MAX_BLUR);
    let head_blur = clamp((place.z - head_front(light_idx, texel)) * blur_per_cm, MIN_BLUR, MAX_BLUR);
    var through_hair = 0.0;
    var past = 0.0;
    for (var tap = 0u; tap < N_TAPS; tap++) {
        // A golden spiral fills the disc evenly.
        let angle = 2.3999632 * f32(tap);
        let offset = sqrt((f32(tap) + 0.5) / f32(N_TAPS)) * vec2<f32>(cos(angle), sin(angle));
        through_hair += exp(-depth_at(light_idx, place.xy + hair_blur * offset, place.z));
        past += past_head_at(light_idx, place.xy + head_blur * offset, place.z);
    }
    return through_hair * past / f32(N_TAPS * N_TAPS);
}
