// Slot `environment`: lamps only.
// slot: environment
#define_import_path lorelei::shade_environment_off
#import lorelei::scatter_fibre::{Fibre}
#import lorelei::scatter_volume::{Volume}
#import lorelei::environment_open::{Open}

const SHINES: bool = false;

fn environment(fibre: Fibre, heap: Volume, tangent: vec3<f32>, to_eye: vec3<f32>, open: Open) -> vec3<f32> {
    return vec3<f32>(0.0);
}
