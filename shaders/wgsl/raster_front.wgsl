// How near the hair comes in each coarse tile: from a share of the strands, spread over the scalp, since strands are in
// the order of the level of detail. One stray strand before a lock must not take the fine buckets away from the lock.
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, sampled_segment_of, NO_VERTEX, COARSE}

@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Bits of the nearest depth, inverted: 0 is empty and the nearest is the largest.
@group(0) @binding(auto) var<storage, read_write> fronts: array<atomic<u32>>;

@compute @workgroup_size(64)
fn front(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let vertex = sampled_segment_of(id.x + id.y * n_groups.x * 64u);
    if vertex == NO_VERTEX {
        return;
    }
    let a = project(raster.view, vertices[vertex].xyz);
    let b = project(raster.view, vertices[vertex + 1u].xyz);
    let nearest = min(a.z, b.z);
    let middle = 0.5 * (a.xy + b.xy);
    if nearest <= raster.view.near || any(middle < vec2<f32>(0.0)) || any(middle >= vec2<f32>(raster.view.size)) {
        return;
    }
    let coarse = vec2<u32>(middle / COARSE);
    let at = coarse.y * raster.n_coarse.x + coarse.x;
    let nearness = ~bitcast<u32>(nearest);
    // Most segments are behind the front: reading first saves their atomics.
    if nearness > atomicLoad(&fronts[at]) {
        atomicMax(&fronts[at], nearness);
    }
}
