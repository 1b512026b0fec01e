// Slot `lobe_tt`: straight through. 002, eq. 4.22. Twin of render/src/scattering/marschner.rs, `lobe_tt`.
// slot: lobe_tt
#define_import_path lorelei::scatter_tt
#import lorelei::scatter_fibre::{Fibre, Directions, gaussian}
#import lorelei::scatter_volume::{attenuation_tt}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    let d_tt = fibre.norm_tt * exp(fibre.kappa_tt * (-d.cos_phi - 1.0));
    let m = gaussian(fibre.beta.y, d.theta_h - fibre.alpha.y);
    return fibre.weight.y * m * d_tt * attenuation_tt(fibre, d.cos_theta_d);
}
