// Segments into tiles and, within a tile, into depth buckets. Run twice: first from vertices to segments in pixels and
// to how many each bucket gets; then, with `SCATTER` defined, to write each segment where its bucket's part of the list
// has been laid out.
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, segment_of, Tile, NO_VERTEX, ENTRY_BITS, of_tile}
#import lorelei::raster_buckets::{bucket_of}
#import lorelei::tile::{TILE}

// Depth in each tile from which strands hide what is behind them.
@group(0) @binding(auto) var<storage, read> fronts: array<f32>;
// Bits of the depth behind which a tile is all head.
@group(0) @binding(auto) var<storage, read> tile_backs: array<u32>;
// Segments of each bucket while counting; next free entry while scattering.
@group(0) @binding(auto) var<storage, read_write> buckets: array<atomic<u32>>;
#ifdef SCATTER
struct Round { round: u32 }
@group(0) @binding(auto) var<uniform> round: Round;
@group(0) @binding(auto) var<storage, read> tiles: array<Tile>;
@group(0) @binding(auto) var<storage, read_write> entries: array<u32>;
@group(0) @binding(auto) var<storage, read> lines: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> spans: array<vec4<f32>>;
#else
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Origin and unit direction in pixels, at the index of the segment's first vertex.
@group(0) @binding(auto) var<storage, read_write> lines: array<vec4<f32>>;
// Length in pixels (0: not drawn), view depth at both ends, half widths in pixels as two half floats.
@group(0) @binding(auto) var<storage, read_write> spans: array<vec4<f32>>;
#endif

@compute @workgroup_size(64)
fn bin(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let vertex = segment_of(id.x + id.y * n_groups.x * 64u);
    if vertex == NO_VERTEX {
        return;
    }
#ifdef SCATTER
    let span = spans[vertex];
    let line = lines[vertex];
    if span.x <= 0.0 {
        return;
    }
#else
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    let a = project(raster.view, root.xyz);
    let b = project(raster.view, tip.xyz);
    let offset = b.xy - a.xy;
    let length2 = dot(offset, offset);
    let half_a = root.w * raster.view.pixels_per_tangent / a.z;
    let half_b = tip.w * raster.view.pixels_per_tangent / b.z;
    let margin = max(half_a, half_b) + 1.0;
    let picture = vec2<f32>(raster.view.size);
    let is_seen = min(a.z, b.z) > raster.view.near && length2 > 1e-12
        && all(max(a.xy, b.xy) > vec2<f32>(-margin)) && all(min(a.xy, b.xy) < picture + margin);
    if !is_seen {
        spans[vertex] = vec4<f32>(0.0);
        return;
    }
    let line = vec4<f32>(a.xy, offset * inverseSqrt(length2));
    let packed = bitcast<f32>(pack2x16float(vec2<f32>(half_a, half_b)));
    let span = vec4<f32>(sqrt(length2), a.z, b.z, packed);
    lines[vertex] = line;
    spans[vertex] = span;
#endif
    let length = span.x;
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
    // One loop over all tiles, so that threads side by side go round it about as often as each other.
    let reach = 0.5 * TILE * (size.x + size.y);
    var row = first_row - 1;
    var column = 0;
    var last_column = -1;
    var inside = vec2<f32>(0.0);
    loop {
        if column > last_column {
            row++;
            // The part of the segment whose strip has pixel centres in this row of tiles.
            inside = vec2<f32>(-beyond, length + beyond);
            if size.y > 1e-6 {
                let top = (f32(row) * TILE + 0.5 - across * size.x - line.y) / u.y;
                let bottom = (f32(row) * TILE + TILE - 0.5 + across * size.x - line.y) / u.y;
                inside = vec2<f32>(max(inside.x, min(top, bottom)), min(inside.y, max(top, bottom)));
            }
            let x = line.x + u.x * inside;
            let low_x = min(x.x, x.y) - across * size.y;
            let high_x = max(x.x, x.y) + across * size.y;
            column = max(i32(ceil((low_x - (TILE - 0.5)) / TILE)), 0);
            last_column = min(i32(floor((high_x - 0.5) / TILE)), i32(raster.n_tiles.x) - 1);
        }
        if row > last_row {
            break;
        }
        if column <= last_column {
            let tile_idx = u32(row) * raster.n_tiles.x + u32(column);
            let middle = (vec2<f32>(f32(column), f32(row)) + 0.5) * TILE;
            column++;
            if nearest > bitcast<f32>(tile_backs[tile_idx]) {
                continue;
            }
#ifdef SCATTER
            if tiles[tile_idx].round != round.round {
                continue;
            }
#endif
            // The part of the segment that lies in the tile.
            let at = dot(middle - line.xy, u);
            let part = clamp(vec2<f32>(max(at - reach, inside.x), min(at + reach, inside.y)) / length, vec2<f32>(0.0), vec2<f32>(1.0));
            let bucket = bucket_of(span.y + (span.z - span.y) * select(part.y, part.x, span.z > span.y) - fronts[tile_idx]);
            let place = atomicAdd(&buckets[of_tile(tile_idx, bucket)], 1u);
#ifdef SCATTER
            entries[place] = vertex | (bucket << ENTRY_BITS);
#endif
        }
    }
}
