// Slot `tile`: tiles of 16 x 16 pixels, for raster_fine.wgsl.
// slot: tile
#define_import_path lorelei::tile_16

// Side in pixels, and how many pixels.
const TILE: f32 = 16.0;
const N_PIXELS: u32 = 256u;
