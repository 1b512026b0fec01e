// Slot `environment`: the same radiance from every direction, dying in the hair much as two-stream theory has it. Without
// absorption it does not die: a white furnace stays white.
// slot: environment
#define_import_path lorelei::shade_environment_constant
#import lorelei::scatter_volume::{Volume}

// Around a place there are shorter ways out of the hair than the one to a lamp: about half as long.
const SHORTER: f32 = 0.5;
// Share of it that comes in between the locks, however deep.
const GAPS: f32 = 0.2;

// What one direction of the environment adds, `tau` deep in the hair and `lit` past the head.
fn environment_through(volume: Volume, tau: f32, lit: f32) -> vec3<f32> {
    // The skin sends back about a third of what it hides.
    let let_in = mix(exp(volume.decay * (-SHORTER * tau)), vec3<f32>(1.0), GAPS);
    return volume.albedo * let_in * mix(0.3, 1.0, lit);
}
