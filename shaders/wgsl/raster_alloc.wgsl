// Room in the list for every tile, one thread each; within a tile, bucket after bucket from near to far.
//
// The list outgrows its buffer in rounds: a tile that would start beyond `round_size` entries belongs to a later round, which is
// scattered and drawn after the earlier one into the same list. A list of `round_size` + all segments fits any tile.
// Where tiles lie in the list depends on the order of the atomics, and matters to nobody.
#import lorelei::raster_frame::{raster, raster_layers, Tile, of_tile}
#import lorelei::raster_buckets::{N_BUCKETS}

struct Arguments {
    // Workgroups of the scatter and of the drawing of each round, 4 numbers each (the fourth is unused).
    groups: array<u32>,
}

@group(0) @binding(auto) var<storage, read_write> buckets: array<u32>;
@group(0) @binding(auto) var<storage, read_write> tiles: array<Tile>;
// Entries of all tiles, then tiles of each round.
@group(0) @binding(auto) var<storage, read_write> totals: array<atomic<u32>>;
// Tiles that have entries, a round's behind those of the round before.
@group(0) @binding(auto) var<storage, read_write> tile_list: array<u32>;
@group(0) @binding(auto) var<storage, read_write> arguments: Arguments;

@compute @workgroup_size(64)
fn allocate(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile_idx = id.x;
    if tile_idx >= raster.n_tiles.x * raster.n_tiles.y {
        return;
    }
    var n = 0u;
    for (var k = 0u; k < N_BUCKETS; k++) {
        n += buckets[of_tile(tile_idx, k)];
    }
    if n == 0u {
        tiles[tile_idx] = Tile(0u, 0u, 0u, 0u);
        return;
    }
    let place = atomicAdd(&totals[0], n);
    let round = place / raster.round_size;
    var next = place - round * raster.round_size;
    tiles[tile_idx] = Tile(next, n, round, 0u);
    if round < raster.n_rounds {
        let n_tiles = raster.n_tiles.x * raster.n_tiles.y;
        tile_list[round * n_tiles + atomicAdd(&totals[1u + round], 1u)] = tile_idx;
    }
    for (var k = 0u; k < N_BUCKETS; k++) {
        let in_bucket = buckets[of_tile(tile_idx, k)];
        buckets[of_tile(tile_idx, k)] = next;
        next += in_bucket;
    }
}

// One thread: rounds that have no tiles get no workgroups.
@compute @workgroup_size(1)
fn plan() {
    let total = atomicLoad(&totals[0]);
    let n_item_groups = (raster.n_items + 63u) / 64u;
    let n_rows = max((n_item_groups + 65534u) / 65535u, 1u);
    for (var k = 0u; k < raster.n_rounds; k++) {
        let is_used = k == 0u || total > k * raster.round_size;
        let at = 8u * k;
        arguments.groups[at] = select(0u, (n_item_groups + n_rows - 1u) / n_rows, is_used);
        arguments.groups[at + 1u] = select(0u, n_rows, is_used);
        arguments.groups[at + 2u] = 1u;
        let n_tiles = atomicLoad(&totals[1u + k]);
        let n_tile_rows = (n_tiles + 65534u) / 65535u;
        arguments.groups[at + 4u] = (n_tiles + n_tile_rows - 1u) / max(n_tile_rows, 1u);
        arguments.groups[at + 5u] = n_tile_rows;
        arguments.groups[at + 6u] = 1u;
    }
}
