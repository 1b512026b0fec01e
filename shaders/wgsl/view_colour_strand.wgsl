// Slot `view_colour`: a colour for each strand, made on the CPU (render/src/false_colour.rs).
// slot: view_colour
#define_import_path lorelei::view_colour_strand

// Four bytes a strand, encoded for a display.
@group(0) @binding(auto) var<storage, read> strand_colours: array<u32>;

fn colour(strand: u32, position: vec3<f32>, tangent: vec3<f32>) -> vec3<f32> {
    return unpack4x8unorm(strand_colours[strand]).xyz;
}
