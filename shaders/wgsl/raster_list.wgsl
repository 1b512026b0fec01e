// What the rasteriser's last pass reads and writes, whichever of the two it is: raster_fine.wgsl or raster_lanes.wgsl.
#define_import_path lorelei::raster_list
#import lorelei::raster_frame::{Tile, ENTRY_BITS}

struct Round { round: u32 }
@group(0) @binding(auto) var<uniform> round: Round;
@group(0) @binding(auto) var<storage, read> tiles: array<Tile>;
// See raster_alloc.wgsl.
@group(0) @binding(auto) var<storage, read> totals: array<u32>;
@group(0) @binding(auto) var<storage, read> tile_list: array<u32>;
// After scattering: where each bucket's part of the list ends.
@group(0) @binding(auto) var<storage, read> bucket_ends: array<u32>;
// Depth in each tile from which strands hide what is behind them.
@group(0) @binding(auto) var<storage, read> fronts: array<f32>;
@group(0) @binding(auto) var<storage, read> entries: array<u32>;
@group(0) @binding(auto) var<storage, read> lines: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> spans: array<vec4<f32>>;
// Four half floats a vertex: outgoing radiance and the fibre's opacity.
@group(0) @binding(auto) var<storage, read> radiance: array<vec2<u32>>;
// View depth of the head, and the share of the pixel that it covers.
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;

const VERTEX: u32 = (1u << ENTRY_BITS) - 1u;

// Radiance and opacity of a vertex.
fn unpacked(vertex: u32) -> vec4<f32> {
    let packed = radiance[vertex];
    return vec4<f32>(unpack2x16float(packed.x), unpack2x16float(packed.y));
}
