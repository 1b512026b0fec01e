// Slot `lobe_trt`: off the inside of the far wall. 002, eq. 4.28. Twin of render/src/scattering/marschner.rs, `lobe_trt`.
// slot: lobe_trt
#define_import_path lorelei::scatter_trt
#import lorelei::scatter_fibre::{Fibre, Directions, gaussian}
#import lorelei::scatter_volume::{attenuation_trt}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    let d_trt = fibre.norm_trt * exp(fibre.kappa_trt * (d.cos_phi - 1.0));
    let m = gaussian(fibre.beta.z, d.theta_h - fibre.alpha.z);
    return fibre.weight.z * m * d_trt * attenuation_trt(fibre, d.cos_theta_d);
}
