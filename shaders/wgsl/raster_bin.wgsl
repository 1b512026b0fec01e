// Segments into the tiles that they touch, nearest first: projection, counting, placing, scattering.
//
// A tile's list is cut into N_BUCKETS slabs of depth that begin at the tile's nearest hair and grow thicker away from
// it: the hair that decides a pixel's colour lies in the first millimetres. Order within a slab is arbitrary.
#import lorelei::camera::{View, project}

struct Layer {
    first_vertex: u32,
    n_strands: u32,
    vertices_per_strand: u32,
    n_items: u32,
}

struct Tiles {
    n: vec2<u32>,
    // Depth behind a tile's nearest hair that the slabs reach, centimetres; what is farther falls into the last one.
    reach: f32,
    // Entries that the list has room for.
    capacity: u32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> layer: Layer;
@group(0) @binding(auto) var<uniform> tiles: Tiles;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Pixel, view depth and half width in pixels of every vertex; depth 0 is behind the eye.
@group(0) @binding(auto) var<storage, read_write> projected: array<vec4<f32>>;
// Per tile: all ones minus the bits of the nearest depth, so that zero means no hair.
@group(0) @binding(auto) var<storage, read_write> nearest: array<atomic<u32>>;
// Per tile: depth behind which a surface hides everything, centimetres.
@group(0) @binding(auto) var<storage, read_write> hidden: array<f32>;
// Per tile and slab: number of segments, then where the next one goes; in the end, where the slab's list ends.
@group(0) @binding(auto) var<storage, read_write> slabs: array<atomic<u32>>;
// Per tile: where its list begins.
@group(0) @binding(auto) var<storage, read_write> starts: array<u32>;
// Entries used.
@group(0) @binding(auto) var<storage, read_write> total: atomic<u32>;
// Index of each segment's first vertex.
@group(0) @binding(auto) var<storage, read_write> list: array<u32>;
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;

// Twin of `TILE` in raster/mod.rs.
const TILE: u32 = 8u;
override N_BUCKETS: u32 = 64u;
// Of `walk`: 0 counts, 1 scatters.
override SCATTER: u32 = 0u;

fn item(id: vec3<u32>, n: vec3<u32>) -> u32 {
    return id.x + id.y * n.x * 64u;
}

@compute @workgroup_size(64)
fn project_vertices(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let item_idx = item(id, n);
    if item_idx >= layer.n_items {
        return;
    }
    let vertex_idx = layer.first_vertex + item_idx;
    let vertex = vertices[vertex_idx];
    let at = project(view, vertex.xyz);
    if at.z <= view.near {
        projected[vertex_idx] = vec4<f32>(0.0);
        return;
    }
    projected[vertex_idx] = vec4<f32>(at, vertex.w * view.pixels_per_tangent / at.z);
    let tile = vec2<i32>(floor(at.xy / f32(TILE)));
    if all(tile >= vec2<i32>(0)) && all(tile < vec2<i32>(tiles.n)) {
        atomicMax(&nearest[u32(tile.y) * tiles.n.x + u32(tile.x)], 0xffffffffu - bitcast<u32>(at.z));
    }
}

// What a surface hides of each tile: nothing, unless it covers every pixel.
@compute @workgroup_size(64)
fn hide_tiles(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let tile_idx = item(id, n);
    if tile_idx >= tiles.n.x * tiles.n.y {
        return;
    }
    let corner = vec2<u32>(tile_idx % tiles.n.x, tile_idx / tiles.n.x) * TILE;
    var deepest = 0.0;
    for (var y = corner.y; y < min(corner.y + TILE, view.size.y); y++) {
        for (var x = corner.x; x < min(corner.x + TILE, view.size.x); x++) {
            let pixel = vec2<i32>(i32(x), i32(y));
            let full = textureLoad(head_colour, pixel, 0).a > 0.999;
            deepest = max(deepest, select(1e30, textureLoad(head_depth, pixel, 0).x, full));
        }
    }
    hidden[tile_idx] = deepest;
}

fn slab_of(tile_idx: u32, depth: f32) -> u32 {
    let stored = atomicLoad(&nearest[tile_idx]);
    let front = select(bitcast<f32>(0xffffffffu - stored), depth, stored == 0u);
    let behind = clamp((depth - front) / tiles.reach, 0.0, 1.0);
    return min(u32(sqrt(behind) * f32(N_BUCKETS)), N_BUCKETS - 1u);
}

// Visit every tile that a segment may touch: rows of tiles, and in each the columns that the segment spans there.
@compute @workgroup_size(64)
fn walk(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let segment_idx = item(id, n);
    if segment_idx >= layer.n_items {
        return;
    }
    let per_strand = layer.vertices_per_strand - 1u;
    let vertex_idx = layer.first_vertex + (segment_idx / per_strand) * layer.vertices_per_strand + segment_idx % per_strand;
    let a = projected[vertex_idx];
    let b = projected[vertex_idx + 1u];
    if a.z == 0.0 || b.z == 0.0 {
        return;
    }
    let pad = max(a.w, b.w) + 0.75;
    let low = min(a.xy, b.xy) - pad;
    let high = max(a.xy, b.xy) + pad;
    if any(high < vec2<f32>(0.0)) || any(low >= vec2<f32>(view.size)) {
        return;
    }
    let size = f32(TILE);
    let last = vec2<i32>(tiles.n) - 1;
    let first_row = clamp(i32(floor(low.y / size)), 0, last.y);
    let last_row = clamp(i32(floor(high.y / size)), 0, last.y);
    let step = b.xy - a.xy;
    let per_length = 1.0 / max(dot(step, step), 1e-12);
    let steep = abs(step.y) > 1e-3;
    for (var row = first_row; row <= last_row; row++) {
        var left = low.x;
        var right = high.x;
        if steep {
            // Compute the columns that the segment crosses while it is within `pad` of this row.
            let t0 = clamp((f32(row) * size - pad - a.y) / step.y, 0.0, 1.0);
            let t1 = clamp((f32(row + 1) * size + pad - a.y) / step.y, 0.0, 1.0);
            let x0 = a.x + step.x * t0;
            let x1 = a.x + step.x * t1;
            left = min(x0, x1) - pad;
            right = max(x0, x1) + pad;
        }
        let first_column = clamp(i32(floor(left / size)), 0, last.x);
        let last_column = clamp(i32(floor(right / size)), 0, last.x);
        if right < 0.0 || left >= f32(view.size.x) {
            continue;
        }
        for (var column = first_column; column <= last_column; column++) {
            let tile_idx = u32(row) * tiles.n.x + u32(column);
            let middle = (vec2<f32>(f32(column), f32(row)) + 0.5) * size;
            let t = clamp(dot(middle - a.xy, step) * per_length, 0.0, 1.0);
            let depth = mix(a.z, b.z, t);
            if min(a.z, b.z) > hidden[tile_idx] {
                continue;
            }
            let slab_idx = tile_idx * N_BUCKETS + slab_of(tile_idx, depth);
            let place = atomicAdd(&slabs[slab_idx], 1u);
            if SCATTER == 1u && place < tiles.capacity {
                list[place] = vertex_idx;
            }
        }
    }
}

// Room in the list for each tile, and in it for each slab.
@compute @workgroup_size(64)
fn place_tiles(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let tile_idx = item(id, n);
    if tile_idx >= tiles.n.x * tiles.n.y {
        return;
    }
    var sum = 0u;
    for (var i = 0u; i < N_BUCKETS; i++) {
        sum += atomicLoad(&slabs[tile_idx * N_BUCKETS + i]);
    }
    var start = 0u;
    if sum > 0u {
        start = atomicAdd(&total, sum);
    }
    starts[tile_idx] = start;
    for (var i = 0u; i < N_BUCKETS; i++) {
        let n_segments = atomicLoad(&slabs[tile_idx * N_BUCKETS + i]);
        atomicStore(&slabs[tile_idx * N_BUCKETS + i], start);
        start += n_segments;
    }
}
