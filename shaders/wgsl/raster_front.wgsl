// Where the hair in each tile begins to hide what is behind it: the depth at which strands cover a first share. That is
// where depth buckets must be finest, and a few stray strands before a lock must not take them away.
//
// Some of the strands stand for all: they are in the order of the level of detail, spread over the scalp. `gather`
// sums what they cover in bins of depth, `find` reads the bins from near to far.
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, sampled_segment_of, NO_VERTEX, of_tile}
#import lorelei::tile::{TILE, N_PIXELS}

// Bins of each tile: covered pixels, fixed point.
@group(0) @binding(auto) var<storage, read_write> bins: array<atomic<u32>>;

const N_BINS: u32 = 128u;
const ONE_PIXEL: f32 = 64.0;
// Of what the strands cover, and of the tile where they cover it more than once.
const SHARE: f32 = 0.2;

#ifdef FIND
// Depth in centimetres.
@group(0) @binding(auto) var<storage, read_write> fronts: array<f32>;

@compute @workgroup_size(64)
fn find(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= raster.n_tiles.x * raster.n_tiles.y {
        return;
    }
    var total = 0u;
    for (var k = 0u; k < N_BINS; k++) {
        total += atomicLoad(&bins[of_tile(id.x, k)]);
    }
    let wanted = SHARE * min(f32(total), f32(N_PIXELS) * ONE_PIXEL);
    var before = 0.0;
    var place = 0.0;
    for (var k = 0u; k < N_BINS; k++) {
        let inside = f32(atomicLoad(&bins[of_tile(id.x, k)]));
        if before + inside > wanted {
            place = f32(k) + (wanted - before) / inside;
            break;
        }
        before += inside;
    }
    fronts[id.x] = raster.nearest + place / raster.bins_per_cm;
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
    if min(a.z, b.z) <= raster.view.near {
        return;
    }
    let length = distance(a.xy, b.xy);
    let n_steps = clamp(ceil(length / TILE), 1.0, 64.0);
    let width = 2.0 * root.w * raster.view.pixels_per_tangent / a.z;
    let area = u32(min(width * length / n_steps * f32(raster.sample_step), f32(N_PIXELS)) * ONE_PIXEL + 0.5);
    for (var k = 0.5; k < n_steps; k += 1.0) {
        let at = mix(a, b, k / n_steps);
        if all(at.xy >= vec2<f32>(0.0)) && all(at.xy < vec2<f32>(raster.view.size)) {
            let tile = vec2<u32>(at.xy / TILE);
            let bin = min(u32(max(at.z - raster.nearest, 0.0) * raster.bins_per_cm), N_BINS - 1u);
            atomicAdd(&bins[of_tile(tile.y * raster.n_tiles.x + tile.x, bin)], area);
        }
    }
}
#endif
