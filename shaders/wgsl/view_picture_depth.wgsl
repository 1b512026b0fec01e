// Slot `view_picture`: strands that a ray through the pixel meets, on average.
// slot: view_picture
#define_import_path lorelei::view_picture_depth
#import lorelei::view_body::{grey}
#import lorelei::view_counts::{counts, most}
#import lorelei::view_ramp::{light_of, ramp}

fn over_body(pixel: vec2<u32>, front: vec4<f32>, body: vec4<f32>) -> vec4<f32> {
    let n = counts(pixel).y;
    if n <= 0.0 {
        return grey(body);
    }
    return vec4<f32>(light_of(ramp(n / most())), 1.0);
}
