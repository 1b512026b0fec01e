// What the passes of half-angle slices know: where the slices lie, the lights that shine through them, and the segments of
// the slice that is being made. Twin of render/src/fragments/half_angle.rs.
#define_import_path lorelei::half_angle
#import lorelei::shadow_map::{ShadowLight}

struct HalfAngle {
    // Slices lie across it; the one farthest along it is made first.
    half_vector: vec3<f32>,
    // Multiplies the strands' own area.
    density: f32,
    // Of the scene: those whose light is added up here.
    first_light: u32,
    n_lights: u32,
    // Texels of a side of the light buffer; each light has its own.
    resolution: u32,
    n_slices: u32,
}

// Part of the sorted list of segments.
struct Slice {
    first_segment: u32,
    n_segments: u32,
    slice_idx: u32,
    pad: u32,
}

@group(0) @binding(auto) var<uniform> half_angle: HalfAngle;
// Of each of those lights, its view: a map of `resolution` texels.
@group(0) @binding(auto) var<storage, read> half_angle_lights: array<ShadowLight>;
@group(0) @binding(auto) var<uniform> half_angle_slice: Slice;

// Optical depth 1 of a texel.
const DEPTH_ONE: f32 = 65536.0;
