// Slot `lane_blend`: the nearest strand that touches a pixel covers all of it.
// slot: lane_blend
#define_import_path lorelei::lane_blend_opaque

struct Blend {
    colour: vec4<f32>,
    // 1 / depth of the nearest fragment; 0: none.
    nearness: f32,
    is_done: bool,
}

// Less than this share of the pixel is a graze, not a hair.
const GRAZE: f32 = 0.001;

fn blend_add(before: Blend, coverage: f32, open: f32, depth: f32, is_next: bool, colour: vec3<f32>) -> Blend {
    let is_nearest = coverage > GRAZE && open > 0.5 && 1.0 / depth > before.nearness;
    var blend = before;
    blend.colour = select(before.colour, vec4<f32>(colour, 1.0), is_nearest);
    blend.nearness = select(before.nearness, 1.0 / depth, is_nearest);
    return blend;
}

// What is listed later is behind `closed_depth`.
fn blend_close(before: Blend, closed_depth: f32) -> Blend {
    var blend = before;
    blend.is_done = before.nearness * closed_depth > 1.0;
    return blend;
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.is_done;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour;
}
