// Slot `background`: one flat grey.
// slot: background
#define_import_path lorelei::background_plain

fn background(place: vec2<f32>, grey: f32) -> vec4<f32> {
    return vec4<f32>(vec3<f32>(grey), 1.0);
}
