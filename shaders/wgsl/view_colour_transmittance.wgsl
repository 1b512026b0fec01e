// Slot `view_colour`: what of a lamp's light arrives, past hair and head.
// slot: view_colour
#define_import_path lorelei::view_colour_transmittance
#import lorelei::shadow::{hair_depth, head_visibility}
#import lorelei::shade_lights::{scene}
#import lorelei::view_ramp::{ramp}

struct ViewLight {
    // 0: all lamps, weighted alike; else the lamp's number from 1.
    light: u32,
    pad_a: u32,
    pad_b: u32,
    pad_c: u32,
}

@group(0) @binding(auto) var<uniform> view_light: ViewLight;

fn arrives(light_idx: u32, position: vec3<f32>) -> f32 {
    return exp(-hair_depth(light_idx, position)) * head_visibility(light_idx, position);
}

fn colour(strand: u32, position: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    var first = 0u;
    var end = scene.n_lights;
    if view_light.light > 0u {
        first = min(view_light.light - 1u, scene.n_lights);
        end = min(view_light.light, scene.n_lights);
    }
    var sum = 0.0;
    for (var light_idx = first; light_idx < end; light_idx++) {
        sum += arrives(light_idx, position);
    }
    return ramp(sum / f32(max(end - first, 1u)));
}
