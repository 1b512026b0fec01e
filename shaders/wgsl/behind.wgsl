// What a background is asked for.
#define_import_path lorelei::behind

struct Behind {
    // Of the picture, 0-1 from its upper left.
    place: vec2<f32>,
    // World, from the eye through that place, unit length.
    ray: vec3<f32>,
    // Display value of the middle.
    grey: f32,
    // Radians about the vertical, and scale of its light.
    turn: f32,
    gain: f32,
    // Exposure and white balance.
    picture_from_scene: mat3x3<f32>,
}
