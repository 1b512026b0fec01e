// Slot `blend`: the nearest strand that touches a pixel covers all of it.
// slot: blend
#define_import_path lorelei::blend_opaque

struct Blend {
    colour: vec4<f32>,
    // 1 / depth of the nearest fragment; 0: none.
    nearness: f32,
    is_done: f32,
}

// Less than this share of the pixel is a graze, not a hair.
const GRAZE: f32 = 0.001;

fn blend_add(blend: ptr<function, Blend>, coverage: f32, open: f32, depth: f32, colour: vec3<f32>) {
    if coverage > GRAZE && open > 0.5 && 1.0 / depth > (*blend).nearness {
        (*blend).colour = vec4<f32>(colour, 1.0);
        (*blend).nearness = 1.0 / depth;
    }
}

fn blend_close(blend: ptr<function, Blend>) {
    (*blend).is_done = (*blend).colour.w;
}

fn blend_is_done(blend: Blend) -> bool {
    return blend.is_done > 0.0;
}

fn blend_colour(blend: Blend) -> vec4<f32> {
    return blend.colour;
}
