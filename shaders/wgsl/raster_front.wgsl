// How near the hair comes in each coarse tile: the depth at which strands cover a first small share of it. A few stray
// strands before a lock are not its front, so that the fine buckets go to the lock.
//
// A share of the strands stands for all: they are in the order of the level of detail, spread over the scalp. `gather`
// sums what they cover in bins of depth, `find` reads the bins from near to far.
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, sampled_segment_of, NO_VERTEX, COARSE, NO_FRONT}

// Bins of each coarse tile: covered pixels, fixed point.
@group(0) @binding(auto) var<storage, read_write> bins: array<atomic<u32>>;

const N_BINS: u32 = 128u;
const ONE_PIXEL: f32 = 64.0;
// Of the coarse tile's area.
const SHARE: f32 = 0.05;

#ifdef FIND
// Depth in centimetres; NO_FRONT where there is no hair.
@group(0) @binding(auto) var<storage, read_write> fronts: array<f32>;

@compute @workgroup_size(64)
fn find(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= raster.n_coarse.x * raster.n_coarse.y {
        return;
    }
    let wanted = u32(SHARE * COARSE * COARSE * ONE_PIXEL);
    var before = 0u;
    var last = NO_FRONT;
    for (var k = 0u; k < N_BINS; k++) {
        let inside = atomicLoad(&bins[id.x * N_BINS + k]);
        if before + inside > wanted {
            last = f32(k) + f32(wanted - before) / f32(inside);
            break;
        }
        if inside > 0u {
            last = f32(k);
        }
        before += inside;
    }
    fronts[id.x] = select(raster.nearest + last / raster.bins_per_cm, NO_FRONT, last == NO_FRONT);
}
#else
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let vertex = sampled_segment_of(id.x + id.y * n_groups.x * 64u);
    if vertex == NO_VERTEX {
        return;
    }
    let root = vertices[vertex];
    let a = project(raster.view, root.xyz);
    let b = project(raster.view, vertices[vertex + 1u].xyz);
    let middle = 0.5 * (a + b);
    if min(a.z, b.z) <= raster.view.near || any(middle.xy < vec2<f32>(0.0)) || any(middle.xy >= vec2<f32>(raster.view.size)) {
        return;
    }
    let coarse = vec2<u32>(middle.xy / COARSE);
    let bin = min(u32(max(middle.z - raster.nearest, 0.0) * raster.bins_per_cm), N_BINS - 1u);
    let width = 2.0 * root.w * raster.view.pixels_per_tangent / middle.z;
    let area = min(width * distance(a.xy, b.xy) * f32(raster.sample_step), COARSE * COARSE);
    atomicAdd(&bins[(coarse.y * raster.n_coarse.x + coarse.x) * N_BINS + bin], u32(area * ONE_PIXEL + 0.5));
}
#endif
