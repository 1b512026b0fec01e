// Slot `lobe_tt`: straight through. 002, eq. 4.22. Twin of render/src/scattering/marschner.rs, `lobe_tt`.
// slot: lobe_tt
#define_import_path lorelei::scatter_tt
#import lorelei::scatter_fibre::{Fibre, Directions, gaussian, reflectance}
#import lorelei::scatter_volume::{chord}

// Karis 2016; 002, eq. 4.16.
fn offset_of_karis(fibre: Fibre, d: Directions) -> f32 {
    let a = d.cos_theta_d / sqrt(fibre.eta * fibre.eta - (1.0 - d.cos_theta_d * d.cos_theta_d));
    return min((1.0 + a * (0.6 - 0.8 * d.cos_phi)) * sqrt(max(0.5 + 0.5 * d.cos_phi, 0.0)), 1.0);
}

fn attenuation(fibre: Fibre, d: Directions) -> vec3<f32> {
    var h = fibre.offsets.xy;
    if h.x < 0.0 {
        h = vec2<f32>(offset_of_karis(fibre, d));
    }
    let f = reflectance(fibre, d.cos_theta_d * sqrt(max(1.0 - h.x * h.x, 0.0)));
    let chords = 2.0 * chord(fibre.eta, d.cos_theta_d, h.y);
    return (1.0 - f) * (1.0 - f) * exp(fibre.sigma_a * -chords);
}

fn lobe(fibre: Fibre, d: Directions) -> vec3<f32> {
    let d_tt = fibre.norm_tt * exp(fibre.kappa_tt * (-d.cos_phi - 1.0));
    let m = gaussian(fibre.beta.y, d.theta_h - fibre.alpha.y);
    return fibre.weight.y * m * d_tt * attenuation(fibre, d);
}
