// Slot `scattering`: Marschner et al. 2003 from the two lookups of the Nalu demo (004). Twin of
// render/src/scattering/marschner_2003.rs, `scatter_nalu`.
// slot: scattering
#define_import_path lorelei::scatter_marschner_2003_nalu
#import lorelei::scatter_fibre::{Fibre, Directions}
#import lorelei::scatter_tables::{look_up, look_up_longitudinal}
#import lorelei::scatter_volume::{H_CHORD_TT, chord}

const MIN_COS2: f32 = 0.01;

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let m = look_up_longitudinal(fibre.table / 4u, 0.5 + 0.5 * d.sin_theta_i, 0.5 + 0.5 * d.sin_theta_r);
    let cos_theta_d = m.w;
    let x = 0.5 + 0.5 * d.cos_phi;
    let n_r = vec3<f32>(look_up(fibre.table, x, cos_theta_d).x);
    let n_tt = look_up(fibre.table + 1u, x, cos_theta_d).xyz;
    let n_trt = look_up(fibre.table + 2u, x, cos_theta_d).xyz;
    let added = fibre.sigma_a - fibre.baked_sigma_a;
    let t = exp(added * -2.0 * chord(fibre.eta, max(cos_theta_d, 1e-3), H_CHORD_TT));
    let lobes = fibre.weight.x * m.x * n_r + fibre.weight.y * m.y * n_tt * t + fibre.weight.z * m.z * n_trt * t * t;
    return lobes * d.cos_theta_i / max(cos_theta_d * cos_theta_d, MIN_COS2);
}
