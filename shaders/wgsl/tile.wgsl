// The rasteriser's tiles. Of 8 x 8 pixels and not 16 x 16: buckets of depth start at a tile's own front, and a small tile
// has one front; the error against the exact picture is about half, the last pass takes up to two thirds longer (H200,
// docs/performance.md).
#define_import_path lorelei::tile

// Side in pixels, and how many pixels.
const TILE: f32 = 8.0;
const N_PIXELS: u32 = 64u;
