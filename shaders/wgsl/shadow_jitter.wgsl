// Throws that a place keeps as long as it stands still.
#define_import_path lorelei::shadow_jitter
#import lorelei::hash::{combine, unit}

// A random number of a place, for a purpose.
fn place_hash(position: vec3<f32>, purpose: u32) -> u32 {
    let bits = bitcast<vec3<u32>>(position);
    return combine(combine(combine(bits.x, bits.y), bits.z), purpose);
}

// Each coordinate -1 to 1.
fn aside(position: vec3<f32>) -> vec2<f32> {
    return 2.0 * vec2<f32>(unit(place_hash(position, 1u)), unit(place_hash(position, 2u))) - 1.0;
}
