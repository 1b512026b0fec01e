// Slot `environment`: lamps only.
// slot: environment
#define_import_path lorelei::shade_environment_off
#import lorelei::scatter_volume::{Volume}

fn environment_through(volume: Volume, tau: f32, lit: f32) -> vec3<f32> {
    return vec3<f32>(0.0);
}
