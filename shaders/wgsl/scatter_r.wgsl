// Slot `lobe_r`: off the cuticle. 002, eq. 4.12. Twin of render/src/scattering/marschner.rs, `lobe_r`.
// slot: lobe_r
#define_import_path lorelei::scatter_r
#import lorelei::scatter_fibre::{Fibre, Directions, reflectance, gaussian}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    let cos_half_phi = sqrt(max(0.5 + 0.5 * d.cos_phi, 0.0));
    let light_dot_eye = d.cos_theta_i * d.cos_theta_r * d.cos_phi + d.sin_theta_i * d.sin_theta_r;
    let f = reflectance(fibre, sqrt(max(0.5 + 0.5 * light_dot_eye, 0.0)));
    let n_r = 0.25 * cos_half_phi * f;
    return vec3<f32>(fibre.weight.x * gaussian(fibre.beta.x, d.theta_h - fibre.alpha.x) * n_r);
}
