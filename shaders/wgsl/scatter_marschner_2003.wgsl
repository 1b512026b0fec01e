// Slot `scattering`: Marschner et al. 2003 from tables of its lobes, colour outside. Twin of
// render/src/scattering/marschner_2003.rs, `scatter`.
// slot: scattering
#define_import_path lorelei::scatter_marschner_2003
#import lorelei::scatter_fibre::{Fibre, Directions, gaussian}
#import lorelei::scatter_tables::{azimuthal}

const MIN_COS2: f32 = 0.01;

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let m = fibre.weight * vec3<f32>(
        gaussian(fibre.beta.x, d.theta_h - fibre.alpha.x),
        gaussian(fibre.beta.y, d.theta_h - fibre.alpha.y),
        gaussian(fibre.beta.z, d.theta_h - fibre.alpha.z),
    );
    let lobes = m.x * azimuthal(fibre, 0u, d.cos_phi, d.cos_theta_d)
        + m.y * azimuthal(fibre, 1u, d.cos_phi, d.cos_theta_d)
        + m.z * azimuthal(fibre, 2u, d.cos_phi, d.cos_theta_d);
    return lobes * d.cos_theta_i / max(d.cos_theta_d * d.cos_theta_d, MIN_COS2);
}
