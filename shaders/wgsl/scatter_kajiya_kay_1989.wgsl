// Slot `scattering`: Kajiya and Kay 1989 as printed. Twin of render/src/scattering/kajiya_kay_1989.rs, `scatter`.
// slot: scattering
#define_import_path lorelei::scatter_kajiya_kay_1989
#import lorelei::scatter_fibre::{Fibre, Directions, INV_PI}
#import lorelei::scatter_volume::{volume}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let cos_to_cone = d.cos_theta_i * d.cos_theta_r - d.sin_theta_i * d.sin_theta_r;
    // pow of zero is 0 in Rust; here its logarithm could be taken.
    let highlight = pow(max(cos_to_cone, 1e-12), fibre.kk_exponent);
    let diffuse = fibre.kk_diffuse * volume(fibre).albedo * d.cos_theta_i;
    return (diffuse + fibre.weight.x * fibre.kk_specular * highlight) * INV_PI;
}
