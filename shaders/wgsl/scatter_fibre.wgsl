// A hair material, and where light and eye are as a fibre sees them. Twin of render/src/scattering/{mod,fibre}.rs,
// which say what everything means.
#define_import_path lorelei::scatter_fibre

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

fn vary(base: Fibre, strand_seed: u32, t: f32) -> Fibre {
    var fibre = base;
    let bytes = vec4<f32>((vec4<u32>(strand_seed) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(255u)) / 255.0;
    let pigment = 2.45 * (bytes.x + bytes.y - 1.0);
    let scales = 2.45 * (bytes.z + bytes.w - 1.0);
    fibre.sigma_a *= exp(base.colour_variation * pigment) * (1.0 - base.tip_lightening * t * t);
    let shift = TILT_VARIATION * base.colour_variation * scales * base.beta.x;
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

// 002, eq. 4.3, per theta_r.
fn gaussian(sigma: f32, x: f32) -> f32 {
    let q = x / sigma;
    return 0.19947114 / sigma * exp(-0.5 * q * q);
}
