// A fibre as a smooth dielectric cylinder. Twin of render/src/scattering/cylinder.rs, which says what everything means.
#define_import_path lorelei::scatter_cylinder
#import lorelei::scatter_fibre::{TAU, fresnel}

const PI: f32 = 3.14159265358979324;

struct Section {
    eta: f32,
    cos_theta: f32,
    eta_prime: f32,
    cos_theta_t: f32,
}

fn section_of(eta: f32, inclination_cos: f32) -> Section {
    let cos_theta = max(inclination_cos, 1e-3);
    let sin2_theta = 1.0 - cos_theta * cos_theta;
    var section: Section;
    section.eta = eta;
    section.cos_theta = cos_theta;
    section.eta_prime = sqrt(max(eta * eta - sin2_theta, 1e-6)) / cos_theta;
    section.cos_theta_t = sqrt(max(1.0 - sin2_theta / (eta * eta), 1e-6));
    return section;
}

fn exit_azimuth(section: Section, p: f32, h: f32) -> f32 {
    return 2.0 * p * asin(clamp(h / section.eta_prime, -1.0, 1.0)) - 2.0 * asin(clamp(h, -1.0, 1.0)) + p * PI;
}

fn fresnel_at(section: Section, h: f32) -> f32 {
    return fresnel(section.eta, section.cos_theta * sqrt(max(1.0 - h * h, 0.0)));
}

fn chord_at(section: Section, h: f32) -> f32 {
    let sin_gamma_t = h / section.eta_prime;
    return 2.0 * sqrt(max(1.0 - sin_gamma_t * sin_gamma_t, 0.0)) / section.cos_theta_t;
}

fn trimmed_logistic(x: f32, s: f32) -> f32 {
    let e = exp(-abs(x) / s);
    let density = e / (s * (1.0 + e) * (1.0 + e));
    // exp(pi / s) overflows from 1/s = 28 on; there the tanh is 1.
    return density / tanh(min(PI / (2.0 * s), 20.0));
}

fn wrapped(angle: f32) -> f32 {
    return angle - round(angle / TAU) * TAU;
}
