// Slot `environment`: the same radiance from every direction, sent back by thick hair.
// slot: environment
#define_import_path lorelei::shade_environment_constant
#import lorelei::scatter_fibre::{Fibre}
#import lorelei::scatter_volume::{Volume}
#import lorelei::environment_open::{Open}
#import lorelei::shade_lights::{scene}

const SHINES: bool = true;

fn environment(fibre: Fibre, heap: Volume, tangent: vec3<f32>, to_eye: vec3<f32>, open: Open) -> vec3<f32> {
    return heap.albedo * open.share * scene.environment;
}
