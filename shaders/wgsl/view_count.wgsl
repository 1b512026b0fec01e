// Strands counted in every pixel, whatever draws them in the picture: camera-facing strips, added up.
//
// A strip reaches half a pixel beyond its edges, so that a thin one touches every pixel that its middle crosses. Its
// coverage is its exact overlap with a pixel-wide box across it, as in ribbons.wgsl.
#import lorelei::camera::{View, project}

struct ViewLayer {
    first_vertex: u32,
    first_strand: u32,
    n_strands: u32,
    vertices_per_strand: u32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> view_layer: ViewLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// View depth in centimetres of the head, and the share of the pixel that it covers.
@group(0) @binding(auto) var head_depth: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4<f32>,
    // Pixels across the strip, from its middle.
    @location(0) @interpolate(linear) across: f32,
    @location(1) @interpolate(linear) half_width: f32,
    @location(2) depth: f32,
}

@vertex
fn strip(@builtin(vertex_index) corner_idx: u32) -> Corner {
    let segment = corner_idx / 6u;
    let k = corner_idx % 6u;
    let per_strand = view_layer.vertices_per_strand - 1u;
    let a = view_layer.first_vertex + segment / per_strand * view_layer.vertices_per_strand + segment % per_strand;
    let end = select(0u, 1u, k == 2u || k == 3u || k == 5u);
    let side = select(-1.0, 1.0, k == 1u || k == 4u || k == 5u);
    let pa = project(view, vertices[a].xyz);
    let pb = project(view, vertices[a + 1u].xyz);
    let step = pb.xy - pa.xy;
    let n = length(step);
    let along = select(vec2<f32>(1.0, 0.0), step / n, n > 1e-6);
    let p = select(pa, pb, end == 1u);
    let half_width = vertices[a + end].w * view.pixels_per_tangent / p.z;
    let reach = max(half_width, 0.5) + 0.5;
    let at = p.xy + vec2<f32>(-along.y, along.x) * (side * reach);
    let in_front = pa.z > view.near && pb.z > view.near;
    let ndc = vec2<f32>(at.x / f32(view.size.x) * 2.0 - 1.0, 1.0 - at.y / f32(view.size.y) * 2.0);
    var out: Corner;
    out.position = select(vec4<f32>(2.0, 2.0, 2.0, 1.0), vec4<f32>(ndc, 0.5, 1.0), in_front);
    out.across = side * reach;
    out.half_width = half_width;
    out.depth = p.z;
    return out;
}

// 1 where the strand touches the pixel, and its coverage; what lies behind the head does not count.
@fragment
fn count(in: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy);
    let coverage = clamp(min(in.across + 0.5, in.half_width) - max(in.across - 0.5, -in.half_width), 0.0, 1.0);
    let head = textureLoad(head_depth, pixel, 0);
    let open = select(1.0, 1.0 - head.y, in.depth > head.x);
    let touches = select(0.0, 1.0, coverage > 0.0);
    return vec4<f32>(touches * open, coverage * open, 0.0, 0.0);
}
