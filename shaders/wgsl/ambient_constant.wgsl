// Slot `ambient`: what skin gets from all around, where that is of one colour or nothing.
// slot: ambient
#define_import_path lorelei::ambient_constant
#import lorelei::shade_lights::{scene}

// Irradiance over pi.
fn ambient(normal: vec3<f32>) -> vec3<f32> {
    // Skin below sees the floor and the chest instead of the sky: a little less from all around.
    return scene.environment * (0.75 + 0.25 * normal.y);
}
