// Slot `multiple`: the fake normal. Twin of render/src/scattering/multiple.rs.
// slot: multiple
#define_import_path lorelei::scatter_multiple_fake_normal
#import lorelei::scatter_fibre::{Fibre, INV_PI}
#import lorelei::scatter_volume::{Volume}

const LEAK: f32 = 0.35;
const GAIN: f32 = 2.2;
const MAX_SPREADING: f32 = 8.0;

fn through(fibre: Fibre, volume: Volume, tau: f32) -> vec3<f32> {
    let kept = exp(-tau);
    let sent_on = exp((volume.front - 1.0) * tau) - kept;
    return kept + min(fibre.multiple_weight, 1.0) * sent_on;
}

fn spread(base: Fibre, tau: f32) -> Fibre {
    var fibre = base;
    let added = min(tau, MAX_SPREADING) * base.beta.y * base.beta.y;
    fibre.beta = sqrt(base.beta * base.beta + added);
    return fibre;
}

fn multiple(
    fibre: Fibre,
    volume: Volume,
    tangent: vec3<f32>,
    to_light: vec3<f32>,
    to_eye: vec3<f32>,
    tau: f32,
) -> vec3<f32> {
    let across = to_eye - tangent * dot(to_eye, tangent);
    let normal = across / max(length(across), 1e-3);
    let wrapped = GAIN * 0.25 * (dot(normal, to_light) + 1.0);
    let beyond_single = max(volume.albedo - volume.back / (2.0 - volume.front), vec3<f32>(0.0));
    let left = exp(sqrt(volume.decay * volume.decay + LEAK * LEAK) * -tau);
    return fibre.multiple_weight * INV_PI * wrapped * beyond_single * left;
}
