// Slot `multiple`: the fake normal. Twin of render/src/scattering/multiple.rs.
// slot: multiple
#define_import_path lorelei::scatter_multiple_fake_normal
#import lorelei::scatter_fibre::{Fibre, INV_PI}
#import lorelei::scatter_volume::{Volume}

const LEAK: f32 = 0.15;

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
    let wrapped = 0.25 * (dot(normal, to_light) + 1.0);
    let beyond_single = max(volume.albedo - 0.5 * volume.back, vec3<f32>(0.0));
    let through = exp(sqrt(volume.decay * volume.decay + LEAK * LEAK) * -tau);
    return fibre.multiple_weight * INV_PI * wrapped * beyond_single * through;
}
