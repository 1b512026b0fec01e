// The view, and the way from world centimetres to pixels. Depth is the distance along the view axis, in centimetres.
#define_import_path lorelei::camera

struct View {
    clip_from_world: mat4x4<f32>,
    view_from_world: mat4x4<f32>,
    // World position of the eye.
    eye: vec3<f32>,
    // Pixels of one centimetre at one centimetre from the eye: n_rows / (2 tan(fov_y / 2)).
    pixels_per_tangent: f32,
    size: vec2<u32>,
    near: f32,
    far: f32,
}

// A world position as pixel coordinates (y down, centres at .5) and view depth.
fn project(view: View, position: vec3<f32>) -> vec3<f32> {
    let clip = view.clip_from_world * vec4<f32>(position, 1.0);
    let ndc = clip.xy / clip.w;
    let half_size = 0.5 * vec2<f32>(view.size);
    return vec3<f32>((ndc * vec2<f32>(1.0, -1.0) + 1.0) * half_size, clip.w);
}
