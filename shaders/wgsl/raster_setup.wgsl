// Segments in pixels, one thread each, and how near the hair comes in each coarse tile.
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, segment_of, is_sample, NO_VERTEX, COARSE}

@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Origin and unit direction in pixels, at the index of the segment's first vertex.
@group(0) @binding(auto) var<storage, read_write> lines: array<vec4<f32>>;
// Length in pixels (0: not drawn), view depth at both ends, half widths in pixels as two half floats.
@group(0) @binding(auto) var<storage, read_write> spans: array<vec4<f32>>;
// Bits of the nearest depth, inverted: 0 is empty and the nearest is the largest. First of the samples, then of all:
// one stray strand before a lock must not take the fine buckets away from the lock.
@group(0) @binding(auto) var<storage, read_write> fronts: array<atomic<u32>>;

@compute @workgroup_size(64)
fn setup(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= raster.n_items {
        return;
    }
    let vertex = segment_of(item);
    if vertex == NO_VERTEX {
        return;
    }
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    let a = project(raster.view, root.xyz);
    let b = project(raster.view, tip.xyz);
    let offset = b.xy - a.xy;
    let length2 = dot(offset, offset);
    let half_a = root.w * raster.view.pixels_per_tangent / a.z;
    let half_b = tip.w * raster.view.pixels_per_tangent / b.z;
    let reach = max(half_a, half_b) + 1.0;
    let size = vec2<f32>(raster.view.size);
    let is_seen = min(a.z, b.z) > raster.view.near && length2 > 1e-12
        && all(max(a.xy, b.xy) > vec2<f32>(-reach)) && all(min(a.xy, b.xy) < size + reach);
    if !is_seen {
        spans[vertex] = vec4<f32>(0.0);
        return;
    }
    let length = sqrt(length2);
    lines[vertex] = vec4<f32>(a.xy, offset / length);
    spans[vertex] = vec4<f32>(length, a.z, b.z, bitcast<f32>(pack2x16float(vec2<f32>(half_a, half_b))));

    let middle = vec2<i32>(floor(0.5 * (a.xy + b.xy) / COARSE));
    let coarse = vec2<u32>(clamp(middle, vec2<i32>(0), vec2<i32>(raster.n_coarse) - 1));
    let front = ~bitcast<u32>(min(a.z, b.z));
    let at = coarse.y * raster.n_coarse.x + coarse.x;
    let of_all = at + raster.n_coarse.x * raster.n_coarse.y;
    // Most segments are behind the front: reading first saves their atomics.
    if front > atomicLoad(&fronts[of_all]) {
        atomicMax(&fronts[of_all], front);
    }
    if front > atomicLoad(&fronts[at]) && is_sample(vertex) {
        atomicMax(&fronts[at], front);
    }
}
