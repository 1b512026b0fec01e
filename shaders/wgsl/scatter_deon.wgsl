// Slot `scattering`: d'Eon et al. 2011. Twin of render/src/scattering/deon.rs.
// slot: scattering
#define_import_path lorelei::scatter_deon
#import lorelei::scatter_fibre::{Fibre, Directions}
#import lorelei::scatter_longitudinal::{longitudinal}
#import lorelei::scatter_tables::{azimuthal}

// Cosine of theta_d with a lobe's shift of theta_i + theta_r taken off the light's inclination.
fn cos_untilted(d: Directions, shift: f32) -> f32 {
    let sin_theta_d = 0.5 * (d.sin_theta_r * d.cos_theta_i - d.cos_theta_r * d.sin_theta_i) / d.cos_theta_d;
    return max(d.cos_theta_d * cos(0.5 * shift) - sin_theta_d * sin(0.5 * shift), 0.0);
}

fn lobe(fibre: Fibre, d: Directions, p: u32, beta: f32, shift: f32) -> vec3<f32> {
    return longitudinal(4.0 * beta * beta, d, shift) * azimuthal(fibre, p, d.cos_phi, cos_untilted(d, shift));
}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let shift = 2.0 * fibre.alpha;
    return fibre.weight.x * lobe(fibre, d, 0u, fibre.beta.x, shift.x)
        + fibre.weight.y * lobe(fibre, d, 1u, fibre.beta.y, shift.y)
        + fibre.weight.z * lobe(fibre, d, 2u, fibre.beta.z, shift.z)
        + fibre.weight_rest * lobe(fibre, d, 3u, fibre.beta.z, 0.0);
}
