// Slot `scattering`: R, TT and TRT. Twin of render/src/scattering/marschner.rs.
// slot: scattering
#define_import_path lorelei::scatter_marschner
#import lorelei::scatter_fibre::{Fibre, Directions}
#import lorelei::lobe_r
#import lorelei::lobe_tt
#import lorelei::lobe_trt

const MIN_COS2: f32 = 0.01;

fn specular_cone(d: Directions) -> f32 {
    return 1.0 / max(0.5 * (d.cos_theta_i * d.cos_theta_i + d.cos_theta_r * d.cos_theta_r), MIN_COS2);
}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let lobes = lobe_r::lobe(fibre, d) + lobe_tt::lobe(fibre, d) + lobe_trt::lobe(fibre, d);
    return lobes * specular_cone(d) * d.cos_theta_i;
}
