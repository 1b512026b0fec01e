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

// Optical depth of the hair between a light and a position: exp(-hair_depth) of the light comes through black fibres.
fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    let light = shadow_lights[light_idx];
    let place = map_place(light, position);
    let resolution = f32(shadow_params.resolution);
    if light.casts == 0u || place.w <= 0.0 || any(place.xy < vec2<f32>(0.0)) || any(place.xy > vec2<f32>(resolution)) {
        return 0.0;
    }
    let corner = floor(place.xy - 0.5);
    let f = place.xy - 0.5 - corner;
    let texel = vec2<i32>(corner);
    let near_row = mix(
        texel_depth(light_idx, texel, place.z),
        texel_depth(light_idx, texel + vec2<i32>(1, 0), place.z),
        f.x,
    );
    let far_row = mix(
        texel_depth(light_idx, texel + vec2<i32>(0, 1), place.z),
        texel_depth(light_idx, texel + vec2<i32>(1, 1), place.z),
        f.x,
    );
    return shadow_params.density * mix(near_row, far_row, f.y);
}

// 1 where the head does not stand between the light and a position, with `reach` texels of filter around it.
fn head_filtered(light_idx: u32, position: vec3<f32>, reach: i32) -> f32 {
    let light = shadow_lights[light_idx];
    let place = map_place(light, position);
    let resolution = i32(shadow_params.resolution);
    if light.casts == 0u || place.w <= 0.0 || any(place.xy < vec2<f32>(0.0)) || any(place.xy > vec2<f32>(f32(resolution))) {
        return 1.0;
    }
    let corner = floor(place.xy - 0.5);
    let f = place.xy - 0.5 - corner;
    var lit = 0.0;
    var weights = 0.0;
    for (var y = -reach; y <= reach + 1; y++) {
        for (var x = -reach; x <= reach + 1; x++) {
            let texel = clamp(vec2<i32>(corner) + vec2<i32>(x, y), vec2<i32>(0), vec2<i32>(resolution - 1));
            let front = mix(light.near, light.far, textureLoad(shadow_head, texel, i32(light_idx), 0));
            // A tent around the position.
            let offset = abs(vec2<f32>(f32(x), f32(y)) - f);
            let weight = max(f32(reach) + 1.0 - offset.x, 0.0) * max(f32(reach) + 1.0 - offset.y, 0.0);
            lit += weight * (1.0 - smoothstep(HEAD_BIAS, HEAD_BIAS + HEAD_RAMP, place.z - front));
            weights += weight;
        }
    }
    return lit / weights;
}

// For hair: many vertices, small filter.
fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return head_filtered(light_idx, position, 0);
}

// For surfaces: the share of a light that reaches a position through hair and past the head.
fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return exp(-hair_depth(light_idx, position)) * head_filtered(light_idx, position, 2);
}
