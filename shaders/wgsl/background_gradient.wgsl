// Slot `background`: neutral grey, lighter in the middle.
// slot: background
#define_import_path lorelei::background_gradient
#import lorelei::behind::{Behind}

// Display value and alpha.
fn background(behind: Behind) -> vec4<f32> {
    let off = behind.place - vec2<f32>(0.5, 0.45);
    let fall = 1.0 - 0.55 * smoothstep(0.0, 0.85, length(off));
    return vec4<f32>(vec3<f32>(behind.grey * fall), 1.0);
}
