// Slot `ambient`: what skin gets of the picture of what is all around.
// slot: ambient
#define_import_path lorelei::ambient_picture
#import lorelei::environment_harmonics::{irradiance_at}

// Irradiance over pi.
fn ambient(normal: vec3<f32>) -> vec3<f32> {
    return irradiance_at(normal);
}
