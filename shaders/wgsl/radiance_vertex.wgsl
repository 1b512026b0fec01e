// Slot `radiance`: shaded at the vertices, interpolated between.
// slot: radiance
#define_import_path lorelei::radiance_vertex
#import lorelei::raster_list::{unpacked}

// What is known of a segment before its fragments are.
struct SegmentRadiance {
    root: vec4<f32>,
    step: vec4<f32>,
}

// Of the segment that starts at a vertex.
fn segment_radiance(vertex: u32) -> SegmentRadiance {
    let root = unpacked(vertex);
    return SegmentRadiance(root, unpacked(vertex + 1u) - root);
}

// Linear radiance and the fibre's opacity at `t` of the segment; `across` is the place across the fibre, see strands.wgsl.
fn fibre_radiance(segment: SegmentRadiance, t: f32, across: f32) -> vec4<f32> {
    return segment.root + t * segment.step;
}
