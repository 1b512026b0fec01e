// A segment as a camera-facing strip of two triangles.
//
// A strip thinner than a pixel is drawn a pixel wide, so that every pixel it touches is visited; how much of it is covered
// is decided there.
#define_import_path lorelei::ribbon_strip
#import lorelei::camera::{View, project}
#import lorelei::strands::{vertices}

struct Corner {
    @builtin(position) position: vec4<f32>,
    // Pixels across the strip, from its middle; not in perspective, so that it is measured on the screen.
    @location(0) @interpolate(linear) across: f32,
    @location(1) @interpolate(linear) half_width: f32,
    @location(2) @interpolate(linear) depth: f32,
    // 0 at the segment's first vertex, 1 at its second.
    @location(3) @interpolate(linear) t: f32,
    @location(4) @interpolate(flat) vertex: u32,
}

// A corner that nobody sees, of a segment that is not there.
fn nowhere() -> Corner {
    var out: Corner;
    out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    return out;
}

fn safe_direction(start: vec2<f32>, end: vec2<f32>) -> vec2<f32> {
    let step = end - start;
    let n = length(step);
    return select(vec2<f32>(1.0, 0.0), step / n, n > 1e-6);
}

// Corner `k` of 6 (two triangles of a quad) of the segment that starts at vertex `a`.
fn strip_corner(view: View, a: u32, is_first: bool, is_last: bool, k: u32) -> Corner {
    let end = select(0u, 1u, k == 2u || k == 3u || k == 5u);
    let side = select(-1.0, 1.0, k == 1u || k == 4u || k == 5u);
    let pa = project(view, vertices[a].xyz);
    let pb = project(view, vertices[a + 1u].xyz);
    let along = safe_direction(pa.xy, pb.xy);
    // Compute the mitre: at a joint the strip turns half way to the neighbouring segment, so that quads meet edge on edge.
    var tangent = along;
    if end == 0u && !is_first {
        tangent = normalize(along + safe_direction(project(view, vertices[a - 1u].xyz).xy, pa.xy) + 1e-6 * along);
    }
    if end == 1u && !is_last {
        tangent = normalize(along + safe_direction(pb.xy, project(view, vertices[a + 2u].xyz).xy) + 1e-6 * along);
    }
    // A sharp turn would send the mitre's corner far away.
    let stretch = 1.0 / max(dot(tangent, along), 0.5);
    let normal = vec2<f32>(-tangent.y, tangent.x);
    let p = select(pa, pb, end == 1u);
    let half_width = vertices[a + end].w * view.pixels_per_tangent / p.z;
    let reach = max(half_width, 0.5) + 0.5;
    let at = p.xy + normal * (side * reach * stretch);
    let in_front = pa.z > view.near && pb.z > view.near;
    var out: Corner;
    out.position = select(vec4<f32>(2.0, 2.0, 2.0, 1.0), clip_of(view, at), in_front);
    out.across = side * reach;
    out.half_width = half_width;
    out.depth = p.z;
    out.t = f32(end);
    out.vertex = a;
    return out;
}

// End `k` of 2 of the segment as a line of a pixel.
fn line_end(view: View, a: u32, k: u32) -> Corner {
    let pa = project(view, vertices[a].xyz);
    let pb = project(view, vertices[a + 1u].xyz);
    let p = select(pa, pb, k == 1u);
    let along = abs(safe_direction(pa.xy, pb.xy));
    let in_front = pa.z > view.near && pb.z > view.near;
    var out: Corner;
    out.position = select(vec4<f32>(2.0, 2.0, 2.0, 1.0), clip_of(view, p.xy), in_front);
    out.across = 0.0;
    // A line has one pixel for each step along its longer axis, however slanted: its alpha makes up for it.
    out.half_width = vertices[a + k].w * view.pixels_per_tangent / p.z / max(along.x, along.y);
    out.depth = p.z;
    out.t = f32(k);
    out.vertex = a;
    return out;
}

fn clip_of(view: View, at: vec2<f32>) -> vec4<f32> {
    return vec4<f32>(at.x / f32(view.size.x) * 2.0 - 1.0, 1.0 - at.y / f32(view.size.y) * 2.0, 0.5, 1.0);
}
