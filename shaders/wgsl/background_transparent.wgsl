// Slot `background`: nothing.
// slot: background
#define_import_path lorelei::background_transparent
#import lorelei::behind::{Behind}

fn background(behind: Behind) -> vec4<f32> {
    return vec4<f32>(0.0);
}
