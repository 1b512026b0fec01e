// What every pass of the rasteriser knows about the frame, and which vertex a thread works on. Twin of
// render/src/raster/mod.rs.
#define_import_path lorelei::raster_frame
#import lorelei::camera::{View}

struct RasterFrame {
    view: View,
    // Tiles that cover the picture.
    n_tiles: vec2<u32>,
    // Vertices of all drawn strands.
    n_items: u32,
    n_layers: u32,
    // List entries that a round may start in: see raster_alloc.wgsl.
    round_size: u32,
    n_rounds: u32,
    // 2 to the power of the picture's stops.
    exposure: f32,
    // Depth in front of which there is no hair.
    nearest: f32,
    // One strand in so many is a sample.
    sample_step: u32,
    // Of the bins that the front is found with.
    bins_per_cm: f32,
    // Pixels drawn for one of the picture, along a side.
    supersampling: u32,
    pad: u32,
}

struct RasterLayer {
    first_vertex: u32,
    first_strand: u32,
    n_strands: u32,
    vertices_per_strand: u32,
    material: u32,
}

// A tile's part of the list, and the round that it is made and drawn in.
struct Tile {
    start: u32,
    n_entries: u32,
    round: u32,
    pad: u32,
}

@group(0) @binding(auto) var<uniform> raster: RasterFrame;
@group(0) @binding(auto) var<storage, read> raster_layers: array<RasterLayer>;

// The k-th of what each tile has several of. The k-th of all tiles lie side by side, as do the threads of passes that have
// one for each tile.
fn of_tile(tile_idx: u32, k: u32) -> u32 {
    return k * raster.n_tiles.x * raster.n_tiles.y + tile_idx;
}

const NO_VERTEX: u32 = 0xFFFFFFFFu;
// A list entry is a vertex in the low bits and its bucket above them.
const ENTRY_BITS: u32 = 26u;

// The first vertex of the segment of a thread, NO_VERTEX where a strand has ended.
fn segment_of(item: u32) -> u32 {
    var left = item;
    for (var layer_idx = 0u; layer_idx < raster.n_layers; layer_idx++) {
        let layer = raster_layers[layer_idx];
        let n = layer.n_strands * layer.vertices_per_strand;
        if left < n {
            let is_tip = left % layer.vertices_per_strand == layer.vertices_per_strand - 1u;
            return select(layer.first_vertex + left, NO_VERTEX, is_tip);
        }
        left -= n;
    }
    return NO_VERTEX;
}

// The same for the strands that stand for all.
fn sampled_segment_of(item: u32) -> u32 {
    var left = item;
    for (var layer_idx = 0u; layer_idx < raster.n_layers; layer_idx++) {
        let layer = raster_layers[layer_idx];
        let n = ((layer.n_strands + raster.sample_step - 1u) / raster.sample_step) * layer.vertices_per_strand;
        if left < n {
            let along = left % layer.vertices_per_strand;
            let strand = left / layer.vertices_per_strand * raster.sample_step;
            let vertex = layer.first_vertex + strand * layer.vertices_per_strand + along;
            return select(vertex, NO_VERTEX, along == layer.vertices_per_strand - 1u);
        }
        left -= n;
    }
    return NO_VERTEX;
}
