// Slot `radiance`: shaded at the vertices, interpolated between.
// slot: radiance
#define_import_path lorelei::radiance_vertex
#import lorelei::raster_list::{unpacked}

// Linear radiance and the fibre's opacity at `t` of the segment that starts at a vertex; `across` is the place across
// the fibre, see strands.wgsl.
fn fibre_radiance(vertex: u32, t: f32, across: f32) -> vec4<f32> {
    let root = unpacked(vertex);
    return root + t * (unpacked(vertex + 1u) - root);
}
