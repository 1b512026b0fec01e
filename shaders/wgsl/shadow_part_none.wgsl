// Slot `shadow_part`: a technique without layers, slices or clusters.
// slot: shadow_part
#define_import_path lorelei::shadow_part_none

fn n_parts() -> u32 {
    return 0u;
}

fn part_at(light_idx: u32, position: vec3<f32>) -> u32 {
    return 0u;
}

fn part_depth(light_idx: u32, position: vec3<f32>, part: u32) -> f32 {
    return 0.0;
}
