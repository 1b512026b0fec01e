// Slot `environment`: the environment's spherical harmonics integrated against what the fibre scatters. Twin of `harmonics`
// in render/src/environment/lit.rs, which says how.
// slot: environment
#define_import_path lorelei::shade_environment_harmonics
#import lorelei::scatter_fibre::{Fibre, directions}
#import lorelei::scatter_volume::{Volume}
#import lorelei::scattering::{scatter}
#import lorelei::environment_harmonics::{radiance_from, irradiance_at}
#import lorelei::environment_open::{Open}

const SHINES: bool = true;

// Inclinations on either side of the mirror cone where lobes are, and in what is left; azimuths from the eye's side to the
// other.
const N_THETA: i32 = 4;
const N_REST: i32 = 2;
const N_PHI: i32 = 6;
// Of a lobe's deviations, how many are looked at.
const REACH: f32 = 1.3;
const MOST_STEP: f32 = 0.35;
// Where a fibre scatters as little as this, it shows what is diffuse.
const LEAST: f32 = 1e-4;
const PI: f32 = 3.14159265358979324;
const FAR: f32 = 2.0;

fn seen(d: vec3<f32>, open: Open) -> vec3<f32> {
    return radiance_from(d) * (1.0 + dot(open.towards, d));
}

fn environment(fibre: Fibre, heap: Volume, tangent: vec3<f32>, to_eye: vec3<f32>, open: Open) -> vec3<f32> {
    let sin_theta_r = clamp(dot(to_eye, tangent), -1.0, 1.0);
    let across = to_eye - tangent * sin_theta_r;
    let normal = across / max(length(across), 1e-3);
    let side = cross(tangent, normal);
    let tilt = max(max(abs(fibre.alpha.x), abs(fibre.alpha.y)), abs(fibre.alpha.z));
    let beta = max(max(fibre.beta.x, fibre.beta.y), fibre.beta.z);
    let step = min((2.0 * tilt + REACH * 2.0 * beta) / f32(N_THETA), MOST_STEP);

    var scattered = vec3<f32>(0.0);
    var lit = vec3<f32>(0.0);
    let theta_r = asin(sin_theta_r);
    for (var k = -N_THETA - N_REST; k <= N_THETA + N_REST; k++) {
        var theta_i = f32(k) * step - theta_r;
        var share = 1.0;
        if abs(k) > N_THETA {
            let outwards = sign(f32(k));
            let edge = outwards * (f32(N_THETA) + 0.5) * step - theta_r;
            let cell = max(0.5 * PI - outwards * edge, 0.0) / f32(N_REST);
            theta_i = edge + outwards * cell * (f32(abs(k) - N_THETA) - 0.5);
            share = cell / step;
        }
        let cos_theta_i = cos(theta_i);
        if cos_theta_i <= 0.0 || abs(theta_i) > 0.5 * PI {
            continue;
        }
        let along = tangent * sin(theta_i);
        for (var j = 0; j <= N_PHI; j++) {
            let phi = PI * f32(j) / f32(N_PHI);
            let facing = along + normal * (cos_theta_i * cos(phi));
            let aside = side * (cos_theta_i * sin(phi));
            // Both ends of the half circle are there once, what is between them on both sides.
            let weight = share * cos_theta_i * select(1.0, 0.5, j == 0 || j == N_PHI);
            let f = weight * scatter(fibre, directions(tangent, facing + aside, to_eye, FAR));
            scattered += f;
            lit += f * 0.5 * (seen(facing + aside, open) + seen(facing - aside, open));
        }
    }
    let diffuse = irradiance_at(normal) * (1.0 + 2.0 / 3.0 * dot(open.towards, normal));
    let single = (lit + LEAST * diffuse) / (scattered + LEAST);
    let single_share = clamp(heap.back / (2.0 - heap.front) / max(heap.albedo, vec3<f32>(1e-4)), vec3<f32>(0.0), vec3<f32>(1.0));
    return heap.albedo * open.share * mix(diffuse, single, single_share);
}
