// Slots `lobe_r`, `lobe_tt`, `lobe_trt`: left out.
// slot: lobe_r
// slot: lobe_tt
// slot: lobe_trt
#define_import_path lorelei::scatter_lobe_off
#import lorelei::scatter_fibre::{Fibre, Directions}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    return vec3<f32>(0.0);
}
