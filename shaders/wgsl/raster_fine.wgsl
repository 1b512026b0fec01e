// A tile's segments onto its pixels, one thread a pixel, near to far, until nothing more shines through.
//
// There is no barrier and no workgroup memory: the threads of a tile read the same entries, which caches serve, and
// barriers are what the software driver is slowest at.
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

const VERTEX: u32 = (1u << ENTRY_BITS) - 1u;

fn unpacked(vertex: u32) -> vec4<f32> {
    let packed = radiance[vertex];
    return vec4<f32>(unpack2x16float(packed.x), unpack2x16float(packed.y));
}

@compute @workgroup_size(8, 8)
fn fine(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let tile = tiles[group.y * raster.n_tiles.x + group.x];
    let pixel = group.xy * 8u + local.xy;
    if tile.round != round.round || any(pixel >= raster.view.size) {
        return;
    }
    let centre = vec2<f32>(pixel) + 0.5;
    let surface_depth = textureLoad(head_depth, pixel, 0).x;
    let open_behind = 1.0 - textureLoad(head_colour, pixel, 0).w;
    var blend = Blend();
    var bucket = 0u;
    // Data is asked for one segment ahead, and its entry two ahead: where they come from is far away.
    let last = tile.start + max(tile.n_entries, 1u) - 1u;
    var entry = entries[tile.start];
    var next_entry = entries[min(tile.start + 1u, last)];
    var line = lines[entry & VERTEX];
    var span = spans[entry & VERTEX];
    for (var left = tile.n_entries; left > 0u; left--) {
        let next_line = lines[next_entry & VERTEX];
        let next_span = spans[next_entry & VERTEX];
        let far_entry = entries[min(last + 3u - left, last)];
        if entry >> ENTRY_BITS != bucket {
            blend_close(&blend);
            if blend_is_done(blend) {
                break;
            }
            bucket = entry >> ENTRY_BITS;
        }
        let strip = Strip(line.xy, line.zw, span.x, unpack2x16float(bitcast<u32>(span.w)));
        let place = strip_place(strip, centre);
        let reach = strip_reach(strip);
        let half_width = max(strip.half_widths.x, strip.half_widths.y);
        if abs(place.y) < half_width + reach.x && abs(place.x - 0.5 * span.x) < 0.5 * (span.x + reach.y) {
            let vertex = entry & VERTEX;
            let t = clamp(place.x / span.x, 0.0, 1.0);
            let fibre = mix(unpacked(vertex), unpacked(vertex + 1u), t);
            let depth = mix(span.y, span.z, t);
            let open = select(1.0, open_behind, depth > surface_depth);
            blend_add(&blend, strip_coverage(strip, place) * fibre.w, open, depth, fibre.xyz);
        }
        entry = next_entry;
        next_entry = far_entry;
        line = next_line;
        span = next_span;
    }
    blend_close(&blend);
    textureStore(hair, pixel, blend_colour(blend));
}
