// Slot `view_colour`: which way a strand runs; 0 is grey. Twin of `direction_colour` in render/src/false_colour.rs.
// slot: view_colour
#define_import_path lorelei::view_colour_tangent

fn colour(strand: u32, position: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    return 0.5 + 0.5 * tangent;
}
