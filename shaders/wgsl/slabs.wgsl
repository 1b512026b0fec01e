// The tail of a pixel: what lies behind its nearest few fragments, in slabs that grow with the distance.
#define_import_path lorelei::slabs

const N_SLABS: u32 = 8u;
// Thickness of the first, centimetres; each is twice as thick as the one before, so that all of them span a head.
const THINNEST: f32 = 0.06;

// Slabs from the tail's beginning. The last never ends: in the middle of it is whatever lies behind.
fn slab_place(behind: f32) -> f32 {
    return min(log2(1.0 + max(behind, 0.0) / THINNEST), f32(N_SLABS) - 0.5);
}
