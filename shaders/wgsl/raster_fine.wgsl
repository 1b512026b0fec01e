// A tile's segments onto its pixels, near to far, until nothing more shines through.
//
// A thread takes a segment and walks the pixels that it touches; sums of a few depth buckets lie in workgroup memory.
// Then a thread takes a pixel and composites those buckets. So work grows with touched pixels and not with the area
// of tiles, and a frame has few barriers.
#import lorelei::raster_frame::{raster, raster_layers, ENTRY_BITS, of_tile}
#import lorelei::tile::{TILE, N_PIXELS}
#import lorelei::raster_buckets::{N_BUCKETS, bucket_place}
#import lorelei::coverage::{strip_of}
#import lorelei::cover_of::{cover_of_strip}
#import lorelei::radiance::{segment_radiance, fibre_radiance}
#import lorelei::strands::{offset_of}
#import lorelei::raster_blend::{Blend, BlendScale, N_OPEN, N_STEP, blend_scale, blend_clear, blend_add, blend_close, blend_is_done, blend_colour}
#import lorelei::raster_list::{round, tiles, totals, tile_list, bucket_ends, fronts, entries, lines, spans, head_depth, hair, VERTEX}

const SIDE: i32 = i32(TILE);
// Threads that share a segment.
const N_PARTS: u32 = 2u;
// Threads for each pixel: where many strands meet, tiles have lists of 100,000 segments.
const N_DEEP: u32 = 4u;

// For each pixel of the tile: depth of the head, and the share of the pixel that is open behind it.
var<workgroup> surfaces: array<vec2<f32>, N_PIXELS>;
// Bits of the nearest of those depths.
var<workgroup> nearest_surface: atomic<u32>;
// Pixels that are not done: for each column a bit of each row, then for each row a bit of each column.
var<workgroup> open_pixels: array<atomic<u32>, 2u * u32(TILE)>;

// A segment's fragments in the tile, column by column along its longer axis ("columns" are rows where it is steep).
fn walk(entry: u32, part: u32, scale: BlendScale, first_bucket: u32, front: f32, tile_origin: vec2<f32>) {
    let vertex = entry & VERTEX;
    let line = lines[vertex];
    let span = spans[vertex];
    let strip = strip_of(line.zw, span.x, unpack2x16float(bitcast<u32>(span.w)));
    let can_be_hidden = max(span.y, span.z) > bitcast<f32>(atomicLoad(&nearest_surface));
    let is_steep = abs(line.w) > abs(line.z);
    // Where axes change places, so do the sides of the strip.
    let side = select(1.0, -1.0, is_steep);
    // (longer, shorter)
    let u = select(line.zw, line.wz, is_steep);
    let from_tile = line.xy - tile_origin;
    let origin = select(from_tile, from_tile.yx, is_steep);
    let strides = select(vec2<u32>(1u, u32(SIDE)), vec2<u32>(u32(SIDE), 1u), is_steep);
    let lane = select(0u, u32(SIDE), is_steep);
    let across = strip.half_width + strip.reach;
    let shaded = segment_radiance(vertex);
    let end = 0.5 * strip.a;
    let ends = u.x * vec2<f32>(-end, strip.length + end);
    let slack = across * abs(u.y);
    let first_column = max(i32(ceil(origin.x + min(ends.x, ends.y) - slack - 0.5)), 0);
    let last_column = min(i32(floor(origin.x + max(ends.x, ends.y) + slack - 0.5)), SIDE - 1);
    let slope = u.y / u.x;
    let half_height = across / strip.a;
    for (var column = first_column + i32(part); column <= last_column; column += i32(N_PARTS)) {
        let x = f32(column) + 0.5 - origin.x;
        let middle = origin.y + x * slope - 0.5;
        let first_row = max(i32(ceil(middle - half_height)), 0);
        let last_row = min(i32(floor(middle + half_height)), SIDE - 1);
        if last_row < first_row {
            continue;
        }
        var rows = atomicLoad(&open_pixels[lane + u32(column)]) & ((2u << u32(last_row)) - (1u << u32(first_row)));
        while rows != 0u {
            let row = firstTrailingBit(rows);
            rows &= rows - 1u;
            let y = f32(row) + 0.5 - origin.y;
            let place = vec2<f32>(x * u.x + y * u.y, y * u.x - x * u.y);
            let t = saturate(place.x * strip.per_length);
            let at = u32(column) * strides.x + row * strides.y;
            let pixel = vec2<u32>(tile_origin) + vec2<u32>(at % u32(SIDE), at / u32(SIDE));
            let area = cover_of_strip(strip, place, t, u, pixel).area;
            if area <= 0.0 {
                continue;
            }
            let half_width = mix(strip.half_widths.x, strip.half_widths.y, t);
            let fibre = fibre_radiance(shaded, t, offset_of(side * place.y, half_width));
            let coverage = area * fibre.w;
            let depth = mix(span.y, span.z, t);
            var open = 1.0;
            if can_be_hidden {
                let surface = surfaces[at];
                open = select(1.0, surface.y, depth > surface.x);
            }
            if coverage * open > 0.0 {
                let along_buckets = bucket_place(depth - front);
                let bucket = clamp(u32(along_buckets), first_bucket, first_bucket + N_OPEN - 1u);
                blend_add(scale, bucket, at, coverage, open, saturate(along_buckets - f32(bucket)), fibre.xyz);
            }
        }
    }
}

@compute @workgroup_size(8, 8, N_DEEP)
fn fine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) local_idx: u32,
) {
    let place = group.x + group.y * n_groups.x;
    if place >= totals[1u + round.round] {
        return;
    }
    let tile_idx = tile_list[round.round * raster.n_tiles.x * raster.n_tiles.y + place];
    let tile = tiles[tile_idx];
    let corner = vec2<u32>(tile_idx % raster.n_tiles.x, tile_idx / raster.n_tiles.x) * u32(SIDE);
    let pixel = corner + local.xy;
    let is_inside = all(pixel < raster.view.size);
    let tile_origin = vec2<f32>(corner);
    if local_idx == 0u {
        atomicStore(&nearest_surface, 0x7f800000u);
    }
    if local_idx < 2u * u32(SIDE) {
        atomicStore(&open_pixels[local_idx], (1u << u32(SIDE)) - 1u);
    }
    workgroupBarrier();
    // The first of a pixel's threads composites it.
    let is_first = local.z == 0u;
    var surface = vec2<f32>(0.0);
    if is_inside && is_first {
        let head = textureLoad(head_depth, pixel / raster.supersampling, 0);
        surface = vec2<f32>(head.x, 1.0 - head.y);
        atomicMin(&nearest_surface, bitcast<u32>(surface.x));
    }
    if is_first {
        surfaces[local_idx] = surface;
        blend_clear(local_idx);
    }
    var blend = Blend();
    var is_open = true;
    let front = fronts[tile_idx];
    let scale = blend_scale(tile.n_entries);
    var first = tile.start;
    var is_idle = true;
    for (var bucket = 0u; bucket < N_BUCKETS; bucket += N_STEP) {
        let end = bucket_ends[of_tile(tile_idx, bucket + N_STEP - 1u)];
        // A step may only close what an earlier one has left open.
        if end == first && is_idle {
            continue;
        }
        is_idle = end == first;
        workgroupBarrier();
        for (var k = first + local_idx / N_PARTS; k < end; k += N_DEEP * N_PIXELS / N_PARTS) {
            walk(entries[k], local_idx % N_PARTS, scale, bucket, front, tile_origin);
        }
        workgroupBarrier();
        if is_first {
            blend_close(&blend, scale, bucket, local_idx);
        }
        if is_first && is_open && (blend_is_done(blend) || !is_inside) {
            is_open = false;
            atomicAnd(&open_pixels[local.x], ~(1u << local.y));
            atomicAnd(&open_pixels[u32(SIDE) + local.y], ~(1u << local.x));
        }
        first = end;
        workgroupBarrier();
        var still_open = 0u;
        for (var k = 0u; k < u32(SIDE); k++) {
            still_open |= atomicLoad(&open_pixels[k]);
        }
        if still_open == 0u {
            break;
        }
    }
    if is_inside && is_first {
        textureStore(hair, pixel, blend_colour(blend));
    }
}
