// Slot `view_picture`: the share of a pixel that hair hides.
// slot: view_picture
#define_import_path lorelei::view_picture_coverage
#import lorelei::view_body::{grey}
#import lorelei::view_ramp::{light_of, ramp}

fn over_body(pixel: vec2<u32>, front: vec4<f32>, body: vec4<f32>) -> vec4<f32> {
    if front.w <= 0.0 {
        return grey(body);
    }
    return vec4<f32>(light_of(ramp(front.w)), 1.0);
}
