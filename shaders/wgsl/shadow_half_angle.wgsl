// Slot `shadow`: what of a light arrives at a slice of hair (half-angle slices): of the light that shines through the
// slices, what those before this one have left; of all others, what the slot `shadow_others` says.
// slot: shadow
#define_import_path lorelei::shadow_half_angle
#import lorelei::half_angle::{half_angle, half_angle_lights, DEPTH_ONE}
#import lorelei::shadow_map::{map_place}
#import lorelei::shadow_others as others

// Of each of the lights and texels: the optical depth of the slices before.
@group(0) @binding(auto) var<storage, read> half_angle_map: array<u32>;

// Texels from the place that is asked to where a texel counts no more: a tent, as deep opacity maps are filtered with.
const REACH: i32 = 2;

fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    let k = light_idx - half_angle.first_light;
    if light_idx < half_angle.first_light || k >= half_angle.n_lights {
        return others::hair_depth(light_idx, position);
    }
    let place = map_place(half_angle_lights[k], position);
    if place.w <= 0.0 {
        return 0.0;
    }
    let resolution = i32(half_angle.resolution);
    let base = k * half_angle.resolution * half_angle.resolution;
    let first = vec2<i32>(floor(place.xy - 0.5)) - (REACH - 1);
    var sum = 0.0;
    for (var y = first.y; y < first.y + 2 * REACH; y++) {
        for (var x = first.x; x < first.x + 2 * REACH; x++) {
            if x >= 0 && y >= 0 && x < resolution && y < resolution {
                let away = abs(vec2<f32>(vec2<i32>(x, y)) + 0.5 - place.xy);
                let weight = max(f32(REACH) - away, vec2<f32>(0.0));
                sum += weight.x * weight.y * f32(half_angle_map[base + u32(y * resolution + x)]);
            }
        }
    }
    // The weights add up to the fourth power of the reach.
    return half_angle.density * sum / (DEPTH_ONE * f32(REACH * REACH * REACH * REACH));
}

fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return others::head_visibility(light_idx, position);
}

fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return others::light_visibility(light_idx, position);
}
