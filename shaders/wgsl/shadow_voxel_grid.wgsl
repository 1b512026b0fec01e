// The grid of hair's area and direction.
#define_import_path lorelei::shadow_voxel_grid

// Numbers of a cell while it is filled, and words after.
const N_NUMBERS: u32 = 6u;
const N_WORDS: u32 = 3u;
// 1 square centimetre.
const AREA_FIXED_POINT: f32 = 4194304.0;
