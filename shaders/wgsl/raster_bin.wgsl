// Segments into tiles and, within a tile, into depth buckets. Run twice: first to count, then, with `SCATTER`
// defined, to write each segment where its bucket's part of the list has been laid out.
#import lorelei::raster_frame::{raster, segment_of, Tile, NO_VERTEX, TILE, COARSE, N_BUCKETS, ENTRY_BITS}

@group(0) @binding(auto) var<storage, read> lines: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> spans: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> fronts: array<u32>;
// Bits of the depth behind which a tile is all head.
@group(0) @binding(auto) var<storage, read> tile_backs: array<u32>;
// Segments of each bucket while counting; next free entry while scattering.
@group(0) @binding(auto) var<storage, read_write> buckets: array<atomic<u32>>;
#ifdef SCATTER
struct Round { round: u32 }
@group(0) @binding(auto) var<uniform> round: Round;
@group(0) @binding(auto) var<storage, read> tiles: array<Tile>;
@group(0) @binding(auto) var<storage, read_write> entries: array<u32>;
#endif

// Buckets are finest at the front, where the pixel still lets light through, and grow with depth behind it: log2 of
// 1 + depth / FINEST, from 0 to DEEPEST.
const FINEST: f32 = 0.5;
const DEEPEST: f32 = 25.0;

fn bucket_of(behind: f32) -> u32 {
    let share = log2(1.0 + max(behind, 0.0) / FINEST) / log2(1.0 + DEEPEST / FINEST);
    return min(u32(share * f32(N_BUCKETS)), N_BUCKETS - 1u);
}

@compute @workgroup_size(64)
fn bin(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= raster.n_items {
        return;
    }
    let vertex = segment_of(item);
    if vertex == NO_VERTEX {
        return;
    }
    let span = spans[vertex];
    let length = span.x;
    if length <= 0.0 {
        return;
    }
    let line = lines[vertex];
    let half_widths = unpack2x16float(bitcast<u32>(span.w));
    let u = line.zw;
    let size = abs(u);
    // Pixels whose centres are this far across and beyond the ends are touched: see coverage.wgsl.
    let across = max(half_widths.x, half_widths.y) + 0.5 * (size.x + size.y);
    let beyond = 0.5 * max(size.x, size.y);
    let nearest = min(span.y, span.z);

    let end_y = vec2<f32>(line.y - beyond * u.y, line.y + (length + beyond) * u.y);
    let low_y = min(end_y.x, end_y.y) - across * size.x;
    let high_y = max(end_y.x, end_y.y) + across * size.x;
    let first_row = max(i32(ceil((low_y - (TILE - 0.5)) / TILE)), 0);
    let last_row = min(i32(floor((high_y - 0.5) / TILE)), i32(raster.n_tiles.y) - 1);
    for (var row = first_row; row <= last_row; row++) {
        // The part of the segment whose strip has pixel centres in this row of tiles.
        var low_s = -beyond;
        var high_s = length + beyond;
        if size.y > 1e-6 {
            let top = (f32(row) * TILE + 0.5 - across * size.x - line.y) / u.y;
            let bottom = (f32(row) * TILE + TILE - 0.5 + across * size.x - line.y) / u.y;
            low_s = max(low_s, min(top, bottom));
            high_s = min(high_s, max(top, bottom));
        }
        let x = line.x + u.x * vec2<f32>(low_s, high_s);
        let low_x = min(x.x, x.y) - across * size.y;
        let high_x = max(x.x, x.y) + across * size.y;
        let first_column = max(i32(ceil((low_x - (TILE - 0.5)) / TILE)), 0);
        let last_column = min(i32(floor((high_x - 0.5) / TILE)), i32(raster.n_tiles.x) - 1);
        for (var column = first_column; column <= last_column; column++) {
            let tile_idx = u32(row) * raster.n_tiles.x + u32(column);
            if nearest > bitcast<f32>(tile_backs[tile_idx]) {
                continue;
            }
#ifdef SCATTER
            if tiles[tile_idx].round != round.round {
                continue;
            }
#endif
            let middle = (vec2<f32>(f32(column), f32(row)) + 0.5) * TILE;
            let t = clamp(dot(middle - line.xy, u) / length, 0.0, 1.0);
            let coarse = vec2<u32>(middle / COARSE);
            let coarse_idx = coarse.y * raster.n_coarse.x + coarse.x;
            let of_samples = fronts[coarse_idx];
            let front = select(of_samples, fronts[coarse_idx + raster.n_coarse.x * raster.n_coarse.y], of_samples == 0u);
            let behind = select(mix(span.y, span.z, t) - bitcast<f32>(~front), 0.0, front == 0u);
            let bucket = bucket_of(behind);
            let place = atomicAdd(&buckets[tile_idx * N_BUCKETS + bucket], 1u);
#ifdef SCATTER
            entries[place] = vertex | (bucket << ENTRY_BITS);
#endif
        }
    }
}
