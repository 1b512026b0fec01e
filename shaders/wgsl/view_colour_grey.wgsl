// Slot `view_colour`: no colour, where the last pass shows something else.
// slot: view_colour
#define_import_path lorelei::view_colour_grey

fn colour(strand: u32, position: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.5);
}
