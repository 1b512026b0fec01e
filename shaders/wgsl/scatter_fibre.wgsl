// A hair material, and where light and eye are as a fibre sees them. Twin of render/src/scattering/{mod,fibre}.rs,
// which say what everything means.
#define_import_path lorelei::scatter_fibre
#import lorelei::hash::{pcg}

struct Fibre {
    sigma_a: vec3<f32>,
    eta: f32,
    beta: vec3<f32>,
    kappa_tt: f32,
    alpha: vec3<f32>,
    kappa_trt: f32,
    weight: vec3<f32>,
    norm_tt: f32,
    norm_trt: f32,
    tt_back: f32,
    colour_variation: f32,
    tip_lightening: f32,
    kk_diffuse: f32,
    kk_specular: f32,
    kk_exponent: f32,
    multiple_weight: f32,
    baked_sigma_a: vec3<f32>,
    table: u32,
    offsets: vec4<f32>,
    weight_rest: f32,
    logistic: f32,
    schlick: f32,
    roughness_variation: f32,
    dye_sigma_a: vec3<f32>,
    dye: f32,
    dye_from: f32,
    dye_to: f32,
    tilt_variation: f32,
    pad: f32,
}

struct Directions {
    sin_theta_i: f32,
    cos_theta_i: f32,
    sin_theta_r: f32,
    cos_theta_r: f32,
    cos_phi: f32,
    theta_h: f32,
    cos_theta_d: f32,
    sin_phi: f32,
    h: f32,
}

const INV_PI: f32 = 0.31830988618379067;
const TAU: f32 = 6.28318530717958647;
const TILT_VARIATION: f32 = 2.0;

fn directions(tangent: vec3<f32>, to_light: vec3<f32>, to_eye: vec3<f32>, h: f32) -> Directions {
    var d: Directions;
    d.sin_theta_i = clamp(dot(to_light, tangent), -1.0, 1.0);
    d.sin_theta_r = clamp(dot(to_eye, tangent), -1.0, 1.0);
    d.cos_theta_i = sqrt(max(1.0 - d.sin_theta_i * d.sin_theta_i, 1e-6));
    d.cos_theta_r = sqrt(max(1.0 - d.sin_theta_r * d.sin_theta_r, 1e-6));
    let across_i = to_light - tangent * d.sin_theta_i;
    let across_r = to_eye - tangent * d.sin_theta_r;
    d.cos_phi = clamp(dot(across_i, across_r) / (d.cos_theta_i * d.cos_theta_r), -1.0, 1.0);
    d.theta_h = atan((d.sin_theta_i + d.sin_theta_r) / (d.cos_theta_i + d.cos_theta_r));
    d.sin_phi = clamp(dot(across_i, cross(across_r, tangent)) / (d.cos_theta_i * d.cos_theta_r), -1.0, 1.0);
    d.h = h;
    let cos_difference = d.cos_theta_i * d.cos_theta_r + d.sin_theta_i * d.sin_theta_r;
    d.cos_theta_d = sqrt(max(0.5 + 0.5 * cos_difference, 1e-6));
    return d;
}

fn quarters(bits: u32) -> vec4<f32> {
    return vec4<f32>((vec4<u32>(bits) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u)) / 255.0;
}

// 0 before `first`, 1 from `last` on.
fn ramp(first: f32, last: f32, t: f32) -> f32 {
    if t >= last {
        return 1.0;
    }
    return clamp((t - first) / max(last - first, 1e-3), 0.0, 1.0);
}

// `dyed`: the share of the dye that is painted at the strand's root.
fn vary(base: Fibre, strand_seed: u32, t: f32, dyed: f32) -> Fibre {
    var fibre = base;
    let bytes = quarters(strand_seed);
    let pigment = 2.45 * (bytes.x + bytes.y - 1.0);
    let scales = 2.45 * (bytes.z + bytes.w - 1.0);
    let own = base.sigma_a * (exp(base.colour_variation * pigment) * (1.0 - base.tip_lightening * t * t));
    fibre.sigma_a = mix(own, base.dye_sigma_a, base.dye * dyed * ramp(base.dye_from, base.dye_to, t));
    let more = quarters(pcg(strand_seed));
    fibre.beta *= exp(base.roughness_variation * 2.45 * (more.x + more.y - 1.0));
    let more_tilt = base.tilt_variation * 2.45 * (more.z + more.w - 1.0);
    let shift = TILT_VARIATION * base.colour_variation * scales * base.beta.x + more_tilt;
    fibre.alpha += vec3<f32>(1.0, -0.5, -1.5) * shift;
    return fibre;
}

fn fresnel(eta: f32, cos_i: f32) -> f32 {
    let c = clamp(cos_i, 0.0, 1.0);
    let cos_t = sqrt(max(1.0 - (1.0 - c * c) / (eta * eta), 0.0));
    let s = (c - eta * cos_t) / (c + eta * cos_t);
    let p = (eta * c - cos_t) / (eta * c + cos_t);
    return 0.5 * (s * s + p * p);
}

fn fresnel_schlick(eta: f32, cos_i: f32) -> f32 {
    let root = (eta - 1.0) / (eta + 1.0);
    let f0 = root * root;
    let c = 1.0 - clamp(cos_i, 0.0, 1.0);
    let c2 = c * c;
    return f0 + (1.0 - f0) * (c2 * c2 * c);
}

// Reflectance by the look's choice.
fn reflectance(fibre: Fibre, cos_i: f32) -> f32 {
    if fibre.schlick > 0.5 {
        return fresnel_schlick(fibre.eta, cos_i);
    }
    return fresnel(fibre.eta, cos_i);
}

// 002, eq. 4.3, per theta_r.
fn gaussian(sigma: f32, x: f32) -> f32 {
    let q = x / sigma;
    return 0.19947114 / sigma * exp(-0.5 * q * q);
}
