// Slot `multiple`: single scattering only.
// slot: multiple
#define_import_path lorelei::scatter_multiple_off
#import lorelei::scatter_fibre::{Fibre}
#import lorelei::scatter_volume::{Volume}

fn through(fibre: Fibre, volume: Volume, tau: f32) -> vec3<f32> {
    return vec3<f32>(exp(-tau));
}

fn spread(fibre: Fibre, tau: f32) -> Fibre {
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
    return vec3<f32>(0.0);
}
