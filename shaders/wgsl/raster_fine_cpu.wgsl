// A tile's segments onto its pixels, one thread a tile: raster_fine.wgsl for drivers that run on a CPU.
//
// There a thread a pixel is wasteful: every lane loads every segment, and both sides of every branch are executed.
// A thread a tile visits only the pixels that a segment touches. A GPU would starve: it has few threads left.
#import lorelei::raster_frame::{raster, raster_layers, Tile, ENTRY_BITS}
#import lorelei::coverage::{Strip, strip_place, strip_reach, strip_coverage}
#import lorelei::blend::{Blend, blend_add, blend_close, blend_is_done, blend_colour}

struct Round { round: u32 }
@group(0) @binding(auto) var<uniform> round: Round;
@group(0) @binding(auto) var<storage, read> tiles: array<Tile>;
@group(0) @binding(auto) var<storage, read> entries: array<u32>;
@group(0) @binding(auto) var<storage, read> lines: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> spans: array<vec4<f32>>;
// Four half floats a vertex: outgoing radiance and the fibre's opacity.
@group(0) @binding(auto) var<storage, read> radiance: array<vec2<u32>>;
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;
@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;

// 64 pixels of 8 threads. Each thread keeps to its own 64: workgroup memory only because it can be indexed, which
// a thread's own arrays cannot without a ladder of selects.
var<workgroup> blends: array<Blend, 512>;
// The bucket that each pixel has open.
var<workgroup> buckets: array<u32, 512>;
var<workgroup> depths: array<f32, 512>;
var<workgroup> opens: array<f32, 512>;

const VERTEX: u32 = (1u << ENTRY_BITS) - 1u;

fn unpacked(vertex: u32) -> vec4<f32> {
    let packed = radiance[vertex];
    return vec4<f32>(unpack2x16float(packed.x), unpack2x16float(packed.y));
}

@compute @workgroup_size(8)
fn fine(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    if any(id.xy >= raster.n_tiles) {
        return;
    }
    let tile = tiles[id.y * raster.n_tiles.x + id.x];
    if tile.round != round.round {
        return;
    }
    let corner = id.xy * 8u;
    let size = min(raster.view.size - corner, vec2<u32>(8u));
    let own = 64u * lane;
    for (var k = 0u; k < 64u; k++) {
        let pixel = min(corner + vec2<u32>(k % 8u, k / 8u), raster.view.size - 1u);
        blends[own + k] = Blend();
        buckets[own + k] = 0u;
        depths[own + k] = textureLoad(head_depth, pixel, 0).x;
        opens[own + k] = 1.0 - textureLoad(head_colour, pixel, 0).w;
    }
    // Pixels that still let light through.
    var n_left = size.x * size.y;
    let end = tile.start + tile.n_entries;
    for (var i = tile.start; i < end && n_left > 0u; i++) {
        let entry = entries[i];
        let vertex = entry & VERTEX;
        let bucket = entry >> ENTRY_BITS;
        let line = lines[vertex];
        let span = spans[vertex];
        let root_fibre = unpacked(vertex);
        let tip_fibre = unpacked(vertex + 1u);
        // In pixels from the centre of the tile's first pixel.
        let strip = Strip(line.xy - vec2<f32>(corner) - 0.5, line.zw, span.x, unpack2x16float(bitcast<u32>(span.w)));
        let reach = strip_reach(strip);
        let across = max(strip.half_widths.x, strip.half_widths.y) + reach.x;
        // Walk the longer axis; x is along it.
        let is_steep = abs(line.w) > abs(line.z);
        let u = select(line.zw, line.wz, is_steep);
        let origin = select(strip.origin, strip.origin.yx, is_steep);
        let ends = origin.x + u.x * vec2<f32>(-0.5 * reach.y, span.x + 0.5 * reach.y);
        let first = max(i32(ceil(min(ends.x, ends.y) - across * abs(u.y))), 0);
        let last = min(i32(floor(max(ends.x, ends.y) + across * abs(u.y))), 7);
        let half = across / abs(u.x);
        for (var m = first; m <= last; m++) {
            let middle = origin.y + (f32(m) - origin.x) * u.y / u.x;
            let low = max(i32(ceil(middle - half)), 0);
            let high = min(i32(floor(middle + half)), 7);
            for (var n = low; n <= high; n++) {
                let at = vec2<u32>(select(vec2<i32>(m, n), vec2<i32>(n, m), is_steep));
                let place = strip_place(strip, vec2<f32>(at));
                let k = own + at.y * 8u + at.x;
                var blend = blends[k];
                if all(at < size) && abs(place.x - 0.5 * span.x) < 0.5 * (span.x + reach.y) && !blend_is_done(blend) {
                    if buckets[k] != bucket {
                        blend_close(&blend);
                        n_left -= select(0u, 1u, blend_is_done(blend));
                        buckets[k] = bucket;
                    }
                    if !blend_is_done(blend) {
                        let t = clamp(place.x / span.x, 0.0, 1.0);
                        let fibre = mix(root_fibre, tip_fibre, t);
                        let depth = mix(span.y, span.z, t);
                        let open = select(1.0, opens[k], depth > depths[k]);
                        blend_add(&blend, strip_coverage(strip, place) * fibre.w, open, depth, fibre.xyz);
                    }
                    blends[k] = blend;
                }
            }
        }
    }
    for (var k = 0u; k < 64u; k++) {
        let at = vec2<u32>(k % 8u, k / 8u);
        if all(at < size) {
            var blend = blends[own + k];
            blend_close(&blend);
            textureStore(hair, corner + at, blend_colour(blend));
        }
    }
}
