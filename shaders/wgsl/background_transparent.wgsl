// Slot `background`: nothing.
// slot: background
#define_import_path lorelei::background_transparent

fn background(place: vec2<f32>, grey: f32) -> vec4<f32> {
    return vec4<f32>(0.0);
}
