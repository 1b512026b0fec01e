// What many fibres do to light: two streams. Twin of render/src/scattering/volume.rs.
#define_import_path lorelei::scatter_volume
#import lorelei::scatter_fibre::{Fibre, fresnel}

const H_FRESNEL_TT: f32 = 0.75;
const H_CHORD_TT: f32 = 0.55;
const H_FRESNEL_TRT: f32 = 0.65;
const H_CHORD_TRT: f32 = 0.75;
const A_R: f32 = 0.075;
const R_BACK: f32 = 0.637;
const TRT_BACK: f32 = 0.92;

struct Volume {
    albedo: vec3<f32>,
    decay: vec3<f32>,
    back: vec3<f32>,
    front: vec3<f32>,
}

fn chord(eta: f32, cos_theta_d: f32, h: f32) -> f32 {
    let sin2_theta_d = 1.0 - cos_theta_d * cos_theta_d;
    let cos_theta_t = sqrt(1.0 - sin2_theta_d / (eta * eta));
    let eta_prime = sqrt(eta * eta - sin2_theta_d) / cos_theta_d;
    let sin_gamma_t = h / eta_prime;
    return sqrt(1.0 - sin_gamma_t * sin_gamma_t) / cos_theta_t;
}

fn attenuation_tt(fibre: Fibre, cos_theta_d: f32) -> vec3<f32> {
    let f = fresnel(fibre.eta, cos_theta_d * sqrt(1.0 - H_FRESNEL_TT * H_FRESNEL_TT));
    let chords = 2.0 * chord(fibre.eta, cos_theta_d, H_CHORD_TT);
    return (1.0 - f) * (1.0 - f) * exp(fibre.sigma_a * -chords);
}

fn attenuation_trt(fibre: Fibre, cos_theta_d: f32) -> vec3<f32> {
    let f = fresnel(fibre.eta, cos_theta_d * sqrt(1.0 - H_FRESNEL_TRT * H_FRESNEL_TRT));
    let chords = 4.0 * chord(fibre.eta, cos_theta_d, H_CHORD_TRT);
    return (1.0 - f) * (1.0 - f) * f * exp(fibre.sigma_a * -chords);
}

fn volume(fibre: Fibre) -> Volume {
    let a_tt = attenuation_tt(fibre, 1.0);
    let lobe_trt = attenuation_trt(fibre, 1.0);
    let f_tt = fresnel(fibre.eta, sqrt(1.0 - H_FRESNEL_TT * H_FRESNEL_TT));
    let white_tt = (1.0 - f_tt) * (1.0 - f_tt);
    let f_trt = fresnel(fibre.eta, sqrt(1.0 - H_FRESNEL_TRT * H_FRESNEL_TRT));
    let white_trt = (1.0 - f_trt) * (1.0 - f_trt) * f_trt;
    let rest = (1.0 - A_R - white_tt) / white_trt;
    let a_trt = max(rest, 1.0) * lobe_trt;
    let front = vec3<f32>((1.0 - R_BACK) * A_R) + (1.0 - fibre.tt_back) * a_tt + (1.0 - TRT_BACK) * a_trt;
    let back = vec3<f32>(R_BACK * A_R) + fibre.tt_back * a_tt + TRT_BACK * a_trt;
    let lost = max(vec3<f32>(1.0) - front, back);
    let decay = sqrt(max(lost * lost - back * back, vec3<f32>(0.0)));
    var volume: Volume;
    volume.albedo = back / (lost + decay);
    volume.decay = decay;
    volume.back = back;
    volume.front = front;
    return volume;
}
