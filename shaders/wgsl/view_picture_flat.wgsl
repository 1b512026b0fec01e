// Slot `view_picture`: false colours of the hair over a grey body.
// slot: view_picture
#define_import_path lorelei::view_picture_flat
#import lorelei::view_body::{grey}

fn over_body(pixel: vec2<u32>, front: vec4<f32>, body: vec4<f32>) -> vec4<f32> {
    return front + (1.0 - front.w) * grey(body);
}
