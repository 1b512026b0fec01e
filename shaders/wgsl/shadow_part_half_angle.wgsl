// Slot `shadow_part`: half-angle slices. What a slice alone holds back is not known before the next is lit: of one slice, it
// is what all before it have taken of the light.
// slot: shadow_part
#define_import_path lorelei::shadow_part_half_angle
#import lorelei::half_angle::{half_angle, half_angle_slice}
#import lorelei::shadow_half_angle::{hair_depth}

fn n_parts() -> u32 {
    return half_angle.n_slices;
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    return half_angle_slice.slice_idx;
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    return hair_depth(half_angle.first_light, position);
}
