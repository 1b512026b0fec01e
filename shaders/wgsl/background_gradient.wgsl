// Slot `background`: neutral grey, lighter in the middle.
// slot: background
#define_import_path lorelei::background_gradient

// Display value and alpha at a place of the picture, 0-1 from its upper left.
fn background(place: vec2<f32>, grey: f32) -> vec4<f32> {
    let off = place - vec2<f32>(0.5, 0.45);
    let fall = 1.0 - 0.55 * smoothstep(0.0, 0.85, length(off));
    return vec4<f32>(vec3<f32>(grey * fall), 1.0);
}
