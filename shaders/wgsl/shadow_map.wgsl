// What the passes of the deep opacity maps and their look-ups share. Twin of render/src/shadow/mod.rs.
#define_import_path lorelei::shadow_map

struct ShadowLight {
    // World centimetres to (texel x * w, texel y * w, depth along the light's axis in cm, w); w is 1 for parallel light.
    map_from_world: mat4x4<f32>,
    // Texels of one centimetre at w = 1.
    texels_per_cm: f32,
    // 0 where the light casts no shadow.
    casts: u32,
    // Depths of the head's map: 0 and 1.
    near: f32,
    far: f32,
    // Radius of the blur of a shadow's edge for each centimetre between what casts and what receives it.
    softness: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

struct ShadowParams {
    resolution: u32,
    n_layers: u32,
    // Thickness of the first layer, cm; the next ones are 2, 3, .. times as thick.
    layer_size: f32,
    filter_radius: f32,
    density: f32,
    n_lights: u32,
    pad_a: u32,
    pad_b: u32,
}

// Optical depth 1 of a texel.
const FIXED_POINT: f32 = 65536.0;

// (texel x, texel y, depth in cm, w)
fn map_place(light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
    let q = light.map_from_world * vec4<f32>(position, 1.0);
    return vec4<f32>(q.xy / q.w, q.z, q.w);
}

// Where a depth behind the front lies among the layers' ends d_k = size k (k + 1) / 2: 0 at the front, k at d_k.
fn layer_of(behind: f32, layer_size: f32, n_layers: u32) -> f32 {
    if behind <= 0.0 {
        return 0.0;
    }
    // Between d_(k-1) and d_k opacity grows with depth: the inverse must be linear there, not the root's curve.
    let k = min(floor(0.5 * (sqrt(1.0 + 8.0 * behind / layer_size) - 1.0)), f32(n_layers));
    let start = 0.5 * layer_size * k * (k + 1.0);
    return min(k + (behind - start) / (layer_size * (k + 1.0)), f32(n_layers));
}
