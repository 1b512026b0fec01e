// How much of the environment gets to a place in the hair, and from where. Twin of `Open` in render/src/environment/lit.rs.
#define_import_path lorelei::environment_open
#import lorelei::scatter_volume::{Volume}

// Around a place there are shorter ways out of the hair than the one to a lamp: about half as long.
const SHORTER: f32 = 0.5;
// Share of it that comes in between the locks, however deep.
const GAPS: f32 = 0.2;

struct Open {
    // The mean share that gets in.
    share: vec3<f32>,
    // Towards where it is open: from a direction comes `share` (1 + dot(towards, direction)). No longer than 1.
    towards: vec3<f32>,
}

// What gets in from the direction of a lamp or a probe, `tau` deep in the hair and `lit` past the head. It dies much as
// two-stream theory has it; without absorption it does not die, and a white furnace stays white.
fn let_in(volume: Volume, tau: f32, lit: f32) -> vec3<f32> {
    // The skin sends back about a third of what it hides.
    return mix(exp(volume.decay * (-SHORTER * tau)), vec3<f32>(1.0), GAPS) * mix(0.3, 1.0, lit);
}
