// Slot `lobe_trt`: off the inside of the far wall. 002, eq. 4.28. Twin of render/src/scattering/marschner.rs, `lobe_trt`.
// slot: lobe_trt
#define_import_path lorelei::scatter_trt
#import lorelei::scatter_fibre::{Fibre, Directions, gaussian, reflectance}
#import lorelei::scatter_volume::{chord}

fn attenuation(fibre: Fibre, cos_theta_d: f32) -> vec3<f32> {
    let h = fibre.offsets.zw;
    let f = reflectance(fibre, cos_theta_d * sqrt(max(1.0 - h.x * h.x, 0.0)));
    let chords = 4.0 * chord(fibre.eta, cos_theta_d, h.y);
    return (1.0 - f) * (1.0 - f) * f * exp(fibre.sigma_a * -chords);
}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    let d_trt = fibre.norm_trt * exp(fibre.kappa_trt * (d.cos_phi - 1.0));
    let m = gaussian(fibre.beta.z, d.theta_h - fibre.alpha.z);
    return fibre.weight.z * m * d_trt * attenuation(fibre, d.cos_theta_d);
}
