// The body under false colours: its shape, and no colour that could be taken for one of them.
#define_import_path lorelei::view_body

// Premultiplied. Light of the body is brought into a narrow range of dark greys.
fn grey(body: vec4<f32>) -> vec4<f32> {
    let light = dot(body.xyz, vec3<f32>(0.2126, 0.7152, 0.0722)) / max(body.w, 1e-4);
    return vec4<f32>(vec3<f32>(0.02 + 0.12 * light / (light + 0.5)) * body.w, body.w);
}
