// Slot `background`: one flat grey.
// slot: background
#define_import_path lorelei::background_plain
#import lorelei::behind::{Behind}

fn background(behind: Behind) -> vec4<f32> {
    return vec4<f32>(vec3<f32>(behind.grey), 1.0);
}
