// Two pictures as one: a wipe, or their difference. Twin of `compared` in render/src/versus.rs.

struct Versus {
    size: vec2<u32>,
    // Pixels from the left that the first picture has.
    wipe: f32,
    // What the difference is multiplied with; below 0 there is a wipe instead.
    gain: f32,
}

@group(0) @binding(auto) var<uniform> versus: Versus;
// Encoded for a display, premultiplied.
@group(0) @binding(auto) var first: texture_2d<f32>;
@group(0) @binding(auto) var second: texture_2d<f32>;
@group(0) @binding(auto) var picture: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(8, 8)
fn compare(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= versus.size) {
        return;
    }
    let a = textureLoad(first, id.xy, 0);
    let b = textureLoad(second, id.xy, 0);
    var shown = select(b, a, f32(id.x) + 0.5 < versus.wipe);
    if versus.gain >= 0.0 {
        shown = vec4<f32>(saturate(abs(a.xyz - b.xyz) * versus.gain), 1.0);
    }
    textureStore(picture, id.xy, shown);
}
