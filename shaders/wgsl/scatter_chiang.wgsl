// Slot `scattering`: Chiang et al. 2016, near field where the offset across the fibre is known, else far field. Twin of
// render/src/scattering/chiang.rs.
// slot: scattering
#define_import_path lorelei::scatter_chiang
#import lorelei::scatter_fibre::{Fibre, Directions, TAU}
#import lorelei::scatter_cylinder::{section_of, exit_azimuth, fresnel_at, chord_at, trimmed_logistic, wrapped}
#import lorelei::scatter_longitudinal::{longitudinal}
#import lorelei::scatter_tables::{azimuthal}

const FAR: f32 = 2.0;

fn lobe_m(fibre: Fibre, d: Directions, beta: f32, tilts: f32) -> f32 {
    return longitudinal(4.0 * beta * beta, d, tilts * fibre.alpha.x);
}

fn scatter(fibre: Fibre, d: Directions) -> vec3<f32> {
    let m_r = fibre.weight.x * lobe_m(fibre, d, fibre.beta.x, 2.0);
    let m_tt = fibre.weight.y * lobe_m(fibre, d, fibre.beta.y, -1.0);
    let m_trt = fibre.weight.z * lobe_m(fibre, d, fibre.beta.z, -4.0);
    let m_rest = fibre.weight_rest * lobe_m(fibre, d, fibre.beta.z, 0.0);
    if d.h >= FAR {
        return m_r * azimuthal(fibre, 0u, d.cos_phi, d.cos_theta_r)
            + m_tt * azimuthal(fibre, 1u, d.cos_phi, d.cos_theta_r)
            + m_trt * azimuthal(fibre, 2u, d.cos_phi, d.cos_theta_r)
            + m_rest * azimuthal(fibre, 3u, d.cos_phi, d.cos_theta_r);
    }
    let h = clamp(d.h, -1.0, 1.0);
    let section = section_of(fibre.eta, d.cos_theta_r);
    let f = fresnel_at(section, h);
    let t = exp(-fibre.sigma_a * chord_at(section, h));
    let phi = atan2(d.sin_phi, d.cos_phi);
    let s = fibre.logistic;
    let n_r = trimmed_logistic(wrapped(phi - exit_azimuth(section, 0.0, h)), s);
    let n_tt = trimmed_logistic(wrapped(phi - exit_azimuth(section, 1.0, h)), s);
    let n_trt = trimmed_logistic(wrapped(phi - exit_azimuth(section, 2.0, h)), s);
    let through = (1.0 - f) * (1.0 - f);
    let rest = through * f * f * t * t * t / max(vec3<f32>(1.0) - f * t, vec3<f32>(1e-6)) / TAU;
    return vec3<f32>(m_r * f * n_r) + m_tt * through * n_tt * t + m_trt * through * f * n_trt * t * t + m_rest * rest;
}
