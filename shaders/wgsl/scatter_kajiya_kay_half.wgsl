// Slot `scattering`: the half-vector form of Kajiya and Kay (003, section 3.4). Twin of
// render/src/scattering/kajiya_kay_1989.rs, `scatter_half`.
// slot: scattering
#define_import_path lorelei::scatter_kajiya_kay_half
#import lorelei::scatter_fibre::{Fibre, Directions, INV_PI}
#import lorelei::scatter_volume::{volume}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let light_dot_eye = d.cos_theta_i * d.cos_theta_r * d.cos_phi + d.sin_theta_i * d.sin_theta_r;
    let t_dot_h = (d.sin_theta_i + d.sin_theta_r) * inverseSqrt(max(2.0 + 2.0 * light_dot_eye, 1e-6));
    // pow of zero is 0 in Rust; here its logarithm could be taken.
    let highlight = pow(max(1.0 - t_dot_h * t_dot_h, 1e-12), 0.5 * fibre.kk_exponent);
    let diffuse = fibre.kk_diffuse * volume(fibre).albedo * d.cos_theta_i;
    return (diffuse + fibre.weight.x * fibre.kk_specular * highlight) * INV_PI;
}
