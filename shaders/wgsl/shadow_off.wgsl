// Slot `shadow`: no light is lost.
// slot: shadow
// slot: shadow_others
#define_import_path lorelei::shadow_off

fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    return 0.0;
}

fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return 1.0;
}

fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return 1.0;
}
