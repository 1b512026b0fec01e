// Slot `view_picture`: which way the body faces, without hair.
// slot: view_picture
#define_import_path lorelei::view_picture_normals
#import lorelei::view_ramp::{light_of}

// World normals; what no body covers is 0.
@group(0) @binding(auto) var head_normal: texture_2d<f32>;

fn over_body(pixel: vec2<u32>, front: vec4<f32>, body: vec4<f32>) -> vec4<f32> {
    let normal = textureLoad(head_normal, pixel, 0).xyz;
    let unit = normal * inverseSqrt(max(dot(normal, normal), 1e-12));
    return vec4<f32>(light_of(0.5 + 0.5 * unit) * body.w, body.w);
}
