// Where the slices of an opacity shadow map lie: evenly between the nearest and the farthest that the light's map holds.
#define_import_path lorelei::shadow_slices
#import lorelei::shadow_map::{shadow_params, shadow_lights}

// Optical depth 1: half a word holds 255, which is night.
const SLICE_FIXED_POINT: f32 = 256.0;

// 0 at the start of the first slice, the number of slices at the end of the last one.
fn slice_of(light_idx: u32, depth: f32) -> f32 {
    let near = shadow_lights[light_idx].near;
    let far = shadow_lights[light_idx].far;
    return saturate((depth - near) / (far - near)) * f32(shadow_params.n_parts);
}
