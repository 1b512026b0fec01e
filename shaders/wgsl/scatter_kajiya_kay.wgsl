// Slot `scattering`: diffuse and two highlights. Twin of render/src/scattering/kajiya_kay.rs.
// slot: scattering
#define_import_path lorelei::scatter_kajiya_kay
#import lorelei::scatter_fibre::{Fibre, Directions, INV_PI, TAU}
#import lorelei::scatter_volume::{volume}

fn highlight(exponent: f32, angle: f32) -> f32 {
    // pow of zero is 0 in Rust; here its logarithm could be taken.
    return sqrt(exponent / TAU) / TAU * pow(max(cos(angle), 1e-12), exponent);
}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let colour = volume(fibre).albedo;
    let diffuse = fibre.kk_diffuse * INV_PI * colour;
    let white = highlight(fibre.kk_exponent, 2.0 * (d.theta_h - fibre.alpha.x));
    let coloured = highlight(0.5 * fibre.kk_exponent, 2.0 * (d.theta_h - fibre.alpha.z));
    let facing = 0.5 + 0.5 * d.cos_phi;
    let specular = fibre.kk_specular * facing
        * (vec3<f32>(fibre.weight.x * white) + fibre.weight.z * coloured * colour);
    return (diffuse + specular) * d.cos_theta_i;
}
