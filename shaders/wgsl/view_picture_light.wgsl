// Slot `view_picture`: hair over the body, as light.
// slot: view_picture
#define_import_path lorelei::view_picture_light

fn over_body(pixel: vec2<u32>, front: vec4<f32>, body: vec4<f32>) -> vec4<f32> {
    return front + (1.0 - front.w) * body;
}
