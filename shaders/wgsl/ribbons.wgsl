// Camera-facing strips, one quad a segment, drawn from back to front and blended over each other.
//
// A strip thinner than a pixel is drawn a pixel wide and its alpha carries the width: the strip's exact overlap with a
// pixel-wide box across it. Summed over the pixels, that is the strip's projected area.
#import lorelei::camera::{View, project}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> radiance: array<vec2<u32>>;
// Segments from back to front, see ribbons_sort.wgsl.
@group(0) @binding(auto) var<storage, read> order: array<u32>;
// View depth in centimetres of the head, and the share of the pixel that it covers.
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;

// 1: every fragment is opaque.
override OPAQUE: u32 = 0u;

const FIRST: u32 = 0x80000000u;
const LAST: u32 = 0x40000000u;
const INDEX: u32 = 0x3fffffffu;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) radiance: vec4<f32>,
    // Pixels across the strip, from its middle; not in perspective, so that it is measured on the screen.
    @location(1) @interpolate(linear) across: f32,
    @location(2) @interpolate(linear) half_width: f32,
    @location(3) depth: f32,
}

fn safe_direction(start: vec2<f32>, end: vec2<f32>) -> vec2<f32> {
    let step = end - start;
    let n = length(step);
    return select(vec2<f32>(1.0, 0.0), step / n, n > 1e-6);
}

@vertex
fn strip(@builtin(vertex_index) vertex_idx: u32) -> Corner {
    let packed = order[vertex_idx / 6u];
    let a = packed & INDEX;
    // Two triangles of a quad: which end of the segment, and which side of it.
    let k = vertex_idx % 6u;
    let end = select(0u, 1u, k == 2u || k == 3u || k == 5u);
    let side = select(-1.0, 1.0, k == 1u || k == 4u || k == 5u);
    let here = vertices[a + end];
    let pa = project(view, vertices[a].xyz);
    let pb = project(view, vertices[a + 1u].xyz);
    let along = safe_direction(pa.xy, pb.xy);
    // Compute the mitre: at a joint the strip turns half way to the neighbouring segment, so that quads meet edge on edge.
    var tangent = along;
    if end == 0u && (packed & FIRST) == 0u {
        tangent = normalize(along + safe_direction(project(view, vertices[a - 1u].xyz).xy, pa.xy) + 1e-6 * along);
    }
    if end == 1u && (packed & LAST) == 0u {
        tangent = normalize(along + safe_direction(pb.xy, project(view, vertices[a + 2u].xyz).xy) + 1e-6 * along);
    }
    // A sharp turn would send the mitre's corner far away.
    let stretch = 1.0 / max(dot(tangent, along), 0.5);
    let normal = vec2<f32>(-tangent.y, tangent.x);
    let p = select(pa, pb, end == 1u);
    let half_width = here.w * view.pixels_per_tangent / p.z;
    let reach = max(half_width, 0.5) + 0.5;
    let at = p.xy + normal * (side * reach * stretch);
    let in_front = pa.z > view.near && pb.z > view.near;
    let ndc = vec2<f32>(at.x / f32(view.size.x) * 2.0 - 1.0, 1.0 - at.y / f32(view.size.y) * 2.0);
    var out: Corner;
    out.position = select(vec4<f32>(2.0, 2.0, 2.0, 1.0), vec4<f32>(ndc, 0.5, 1.0), in_front);
    let colour = radiance[a + end];
    out.radiance = vec4<f32>(unpack2x16float(colour.x), unpack2x16float(colour.y));
    out.across = side * reach;
    out.half_width = half_width;
    out.depth = p.z;
    return out;
}

@fragment
fn shade(in: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy);
    var coverage = clamp(min(in.across + 0.5, in.half_width) - max(in.across - 0.5, -in.half_width), 0.0, 1.0);
    if OPAQUE == 1u {
        if abs(in.across) > max(in.half_width, 0.5) {
            discard;
        }
        coverage = 1.0;
    }
    let behind = in.depth > textureLoad(head_depth, pixel, 0).x;
    let open = select(1.0, 1.0 - textureLoad(head_colour, pixel, 0).a, behind);
    let alpha = coverage * in.radiance.a * open;
    return vec4<f32>(in.radiance.rgb * alpha, alpha);
}
