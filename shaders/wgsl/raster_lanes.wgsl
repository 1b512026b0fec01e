// A tile's segments onto its pixels, near to far, for drivers that run on a CPU.
//
// There, eight threads are the lanes of one vector. Arithmetic costs an eighth for each; but what a lane reads from memory
// it reads alone, atomics and barriers are slow, and both sides of every `if` are paid for. So a lane owns a column of
// the tile and keeps its eight pixels in registers; each lane reads one of eight segments, and then all draw the eight
// in turn, handed from lane to lane, without a branch. (Compare raster_fine.wgsl, whose threads own segments.)
//
// Everything about the eight is written out eight times: lanes can only be named by constants, and the driver stops a
// thread that has gone round its loops 65,535 times, here after half a million segments.
#import lorelei::raster_frame::{raster, raster_layers, ENTRY_BITS, of_tile}
#import lorelei::raster_buckets::{N_BUCKETS, bucket_end}
#import lorelei::coverage::{strip_of, thin_across, wide_across}
#import lorelei::raster_lane_blend::{Blend, blend_add, blend_close, blend_is_done, blend_colour}
#import lorelei::raster_list::{round, tiles, totals, tile_list, bucket_ends, fronts, entries, lines, spans, head_depth, hair, unpacked, VERTEX}

const SIDE: u32 = 8u;

// The column of pixels that a lane owns.
struct Rows {
    r0: Blend,
    r1: Blend,
    r2: Blend,
    r3: Blend,
    r4: Blend,
    r5: Blend,
    r6: Blend,
    r7: Blend,
}

// For each of them: depth of the head, and the share of the pixel that is open behind it.
struct Surfaces {
    s0: vec2<f32>,
    s1: vec2<f32>,
    s2: vec2<f32>,
    s3: vec2<f32>,
    s4: vec2<f32>,
    s5: vec2<f32>,
    s6: vec2<f32>,
    s7: vec2<f32>,
}

// A segment as what its pixels need. Along it (in units in which a pixel at its end is 1 long) and across it, a place is
// linear in the tile's x and y: (at the corner, per x, per y, ..).
struct Segment {
    // .w: length
    along: vec4<f32>,
    // .w: 1 / length
    across: vec4<f32>,
    // Half width and depth at the root, and how they change to the tip.
    width_depth: vec4<f32>,
    // Of coverage.wgsl: ramp, per_a, reach; 0 for a segment that is not there.
    shape: vec4<f32>,
    fibre: vec4<f32>,
    fibre_step: vec4<f32>,
}

fn segment_at(vertex: u32, tile_origin: vec2<f32>, is_there: bool) -> Segment {
    let line = lines[vertex];
    let span = spans[vertex];
    let u = line.zw;
    let origin = line.xy - tile_origin;
    let half_widths = unpack2x16float(bitcast<u32>(span.w));
    let strip = strip_of(u, span.x, half_widths);
    let step = u * strip.per_a;
    let fibre = unpacked(vertex);
    var segment: Segment;
    segment.along = vec4<f32>(-dot(origin, step), step, span.x * strip.per_a);
    segment.across = vec4<f32>(origin.x * u.y - origin.y * u.x, -u.y, u.x, strip.a * strip.per_length);
    segment.width_depth = vec4<f32>(half_widths.x, span.y, half_widths.y - half_widths.x, span.z - span.y);
    segment.shape = vec4<f32>(strip.ramp, strip.per_a, strip.reach, select(0.0, 1.0, is_there));
    segment.fibre = fibre;
    segment.fibre_step = unpacked(vertex + 1u) - fibre;
    return segment;
}

fn fragment(before: Blend, segment: Segment, range: vec3<f32>, along: f32, across: f32, surface: vec2<f32>) -> Blend {
    let t = saturate(along * segment.across.w);
    let width_depth = segment.width_depth.xy + t * segment.width_depth.zw;
#ifdef WIDE
    let area = wide_across(segment.shape.xyz, across, width_depth.x);
#else
    let area = thin_across(segment.shape.xyz, across, width_depth.x);
#endif
    let ends = saturate(along + 0.5) - saturate(along + 0.5 - segment.along.w);
    let fibre = segment.fibre + t * segment.fibre_step;
    let open = select(1.0, surface.y, width_depth.y > surface.x);
    return blend_add(before, area * ends * fibre.w * segment.shape.w, open, width_depth.y, range, fibre.xyz);
}

fn draw(rows: ptr<function, Rows>, surfaces: Surfaces, column: f32, range: vec3<f32>, segment: Segment) {
    let along = segment.along.x + column * segment.along.y;
    let across = segment.across.x + column * segment.across.y;
    (*rows).r0 = fragment((*rows).r0, segment, range, along + 0.5 * segment.along.z, across + 0.5 * segment.across.z, surfaces.s0);
    (*rows).r1 = fragment((*rows).r1, segment, range, along + 1.5 * segment.along.z, across + 1.5 * segment.across.z, surfaces.s1);
    (*rows).r2 = fragment((*rows).r2, segment, range, along + 2.5 * segment.along.z, across + 2.5 * segment.across.z, surfaces.s2);
    (*rows).r3 = fragment((*rows).r3, segment, range, along + 3.5 * segment.along.z, across + 3.5 * segment.across.z, surfaces.s3);
    (*rows).r4 = fragment((*rows).r4, segment, range, along + 4.5 * segment.along.z, across + 4.5 * segment.across.z, surfaces.s4);
    (*rows).r5 = fragment((*rows).r5, segment, range, along + 5.5 * segment.along.z, across + 5.5 * segment.across.z, surfaces.s5);
    (*rows).r6 = fragment((*rows).r6, segment, range, along + 6.5 * segment.along.z, across + 6.5 * segment.across.z, surfaces.s6);
    (*rows).r7 = fragment((*rows).r7, segment, range, along + 7.5 * segment.along.z, across + 7.5 * segment.across.z, surfaces.s7);
}

// Composite the open bucket.
fn close(rows: ptr<function, Rows>) -> bool {
    (*rows).r0 = blend_close((*rows).r0);
    (*rows).r1 = blend_close((*rows).r1);
    (*rows).r2 = blend_close((*rows).r2);
    (*rows).r3 = blend_close((*rows).r3);
    (*rows).r4 = blend_close((*rows).r4);
    (*rows).r5 = blend_close((*rows).r5);
    (*rows).r6 = blend_close((*rows).r6);
    (*rows).r7 = blend_close((*rows).r7);
    return blend_is_done((*rows).r0)
        && blend_is_done((*rows).r1)
        && blend_is_done((*rows).r2)
        && blend_is_done((*rows).r3)
        && blend_is_done((*rows).r4)
        && blend_is_done((*rows).r5)
        && blend_is_done((*rows).r6)
        && blend_is_done((*rows).r7);
}

fn surface_at(pixel: vec2<u32>) -> vec2<f32> {
    // Pixels beyond the picture are drawn and thrown away.
    let inside = min(pixel, raster.view.size - 1u) / raster.supersampling;
    let head = textureLoad(head_depth, inside, 0);
    return vec2<f32>(head.x, 1.0 - head.y);
}

@compute @workgroup_size(8)
fn fine(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = group.x + group.y * n_groups.x;
    if place >= totals[1u + round.round] {
        return;
    }
    let tile_idx = tile_list[round.round * raster.n_tiles.x * raster.n_tiles.y + place];
    let tile = tiles[tile_idx];
    let corner = vec2<u32>(tile_idx % raster.n_tiles.x, tile_idx / raster.n_tiles.x) * SIDE;
    let pixel = corner + vec2<u32>(lane, 0u);
    let tile_origin = vec2<f32>(corner);
    let column = f32(lane) + 0.5;
    var surfaces: Surfaces;
    surfaces.s0 = surface_at(pixel + vec2<u32>(0u, 0u));
    surfaces.s1 = surface_at(pixel + vec2<u32>(0u, 1u));
    surfaces.s2 = surface_at(pixel + vec2<u32>(0u, 2u));
    surfaces.s3 = surface_at(pixel + vec2<u32>(0u, 3u));
    surfaces.s4 = surface_at(pixel + vec2<u32>(0u, 4u));
    surfaces.s5 = surface_at(pixel + vec2<u32>(0u, 5u));
    surfaces.s6 = surface_at(pixel + vec2<u32>(0u, 6u));
    surfaces.s7 = surface_at(pixel + vec2<u32>(0u, 7u));
    var rows = Rows();
    let end = tile.start + tile.n_entries;
    for (var first = tile.start; first < end;) {
        let bucket = entries[first] >> ENTRY_BITS;
        let last = bucket_ends[of_tile(tile_idx, bucket)];
        // The first bucket has no beginning, the last no end.
        let ends = vec2<f32>(bucket_end(max(bucket, 1u) - 1u), min(bucket_end(bucket), 1e6));
        let range = vec3<f32>(fronts[tile_idx] + ends, 1.0 / max(ends.y - ends.x, 1e-3));
        for (; first < last; first += 8u) {
            let at = first + lane;
            let mine = segment_at(entries[min(at, last - 1u)] & VERTEX, tile_origin, at < last);
            var segment: Segment;
            segment.along = subgroupBroadcast(mine.along, 0u);
            segment.across = subgroupBroadcast(mine.across, 0u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 0u);
            segment.shape = subgroupBroadcast(mine.shape, 0u);
            segment.fibre = subgroupBroadcast(mine.fibre, 0u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 0u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 1u);
            segment.across = subgroupBroadcast(mine.across, 1u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 1u);
            segment.shape = subgroupBroadcast(mine.shape, 1u);
            segment.fibre = subgroupBroadcast(mine.fibre, 1u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 1u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 2u);
            segment.across = subgroupBroadcast(mine.across, 2u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 2u);
            segment.shape = subgroupBroadcast(mine.shape, 2u);
            segment.fibre = subgroupBroadcast(mine.fibre, 2u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 2u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 3u);
            segment.across = subgroupBroadcast(mine.across, 3u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 3u);
            segment.shape = subgroupBroadcast(mine.shape, 3u);
            segment.fibre = subgroupBroadcast(mine.fibre, 3u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 3u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 4u);
            segment.across = subgroupBroadcast(mine.across, 4u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 4u);
            segment.shape = subgroupBroadcast(mine.shape, 4u);
            segment.fibre = subgroupBroadcast(mine.fibre, 4u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 4u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 5u);
            segment.across = subgroupBroadcast(mine.across, 5u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 5u);
            segment.shape = subgroupBroadcast(mine.shape, 5u);
            segment.fibre = subgroupBroadcast(mine.fibre, 5u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 5u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 6u);
            segment.across = subgroupBroadcast(mine.across, 6u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 6u);
            segment.shape = subgroupBroadcast(mine.shape, 6u);
            segment.fibre = subgroupBroadcast(mine.fibre, 6u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 6u);
            draw(&rows, surfaces, column, range, segment);
            segment.along = subgroupBroadcast(mine.along, 7u);
            segment.across = subgroupBroadcast(mine.across, 7u);
            segment.width_depth = subgroupBroadcast(mine.width_depth, 7u);
            segment.shape = subgroupBroadcast(mine.shape, 7u);
            segment.fibre = subgroupBroadcast(mine.fibre, 7u);
            segment.fibre_step = subgroupBroadcast(mine.fibre_step, 7u);
            draw(&rows, surfaces, column, range, segment);
        }
        first = last;
        if subgroupAll(close(&rows) || pixel.x >= raster.view.size.x) {
            break;
        }
    }
    close(&rows);
    if all(pixel + vec2<u32>(0u, 0u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 0u), blend_colour(rows.r0));
    }
    if all(pixel + vec2<u32>(0u, 1u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 1u), blend_colour(rows.r1));
    }
    if all(pixel + vec2<u32>(0u, 2u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 2u), blend_colour(rows.r2));
    }
    if all(pixel + vec2<u32>(0u, 3u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 3u), blend_colour(rows.r3));
    }
    if all(pixel + vec2<u32>(0u, 4u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 4u), blend_colour(rows.r4));
    }
    if all(pixel + vec2<u32>(0u, 5u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 5u), blend_colour(rows.r5));
    }
    if all(pixel + vec2<u32>(0u, 6u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 6u), blend_colour(rows.r6));
    }
    if all(pixel + vec2<u32>(0u, 7u) < raster.view.size) {
        textureStore(hair, pixel + vec2<u32>(0u, 7u), blend_colour(rows.r7));
    }
}
