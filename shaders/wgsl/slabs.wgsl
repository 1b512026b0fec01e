// The tail of a pixel: what lies behind its nearest few fragments, in slabs that grow with the distance.
#define_import_path lorelei::slabs

const N_SLABS: u32 = 8u;
// Centimetres; a slab is so much thicker than the one before it.
const THINNEST: f32 = 0.04;

// Slabs from the tail's beginning: the k-th ends at THINNEST k (k + 1) / 2, the last never.
fn slab_place(behind: f32) -> f32 {
    let x = 2.0 * max(behind, 0.0) / THINNEST;
    return min(0.5 * (sqrt(1.0 + 4.0 * x) - 1.0), f32(N_SLABS) - 1e-3);
}
