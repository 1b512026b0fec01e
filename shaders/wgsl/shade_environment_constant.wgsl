// Slot `environment`: the same radiance from every direction, dying in the hair as two-stream theory has it. Without
// absorption it does not die: a white furnace stays white.
// slot: environment
#define_import_path lorelei::shade_environment_constant
#import lorelei::scatter_volume::{Volume}

// What one direction of the environment adds, `tau` deep in the hair and `lit` past the head.
fn environment_through(volume: Volume, tau: f32, lit: f32) -> vec3<f32> {
    // The skin sends back about a third of what it hides.
    return volume.albedo * exp(volume.decay * -tau) * mix(0.3, 1.0, lit);
}
