// Slot `tile`: tiles of 8 x 8 pixels, for raster_lanes.wgsl.
// slot: tile
#define_import_path lorelei::tile_8

// Side in pixels, and how many pixels.
const TILE: f32 = 8.0;
const N_PIXELS: u32 = 64u;
