// The scene's lights and what arrives from them; binds nothing but the scene. Twin of render/src/shade.rs.
#define_import_path lorelei::shade_lights

struct SceneLight {
    // w 0: unit vector to a light at infinity. w 1: its place, cm.
    place: vec4<f32>,
    // Irradiance of a surface that faces the light; of a light with a place: at 1 cm, along its axis if it has one.
    irradiance: vec3<f32>,
    // 1: emits as a flat surface, by the cosine to `axis`. 0: evenly.
    is_flat: f32,
    axis: vec3<f32>,
    // Of a disc that emits as this does, cm (at infinity: tangent); for the softness of shadows.
    radius: f32,
}

struct Scene {
    eye: vec3<f32>,
    n_lights: u32,
    // Radiance from every direction, 0 where the environment is off.
    environment: vec3<f32>,
    // Of a fibre itself.
    opacity: f32,
    // Lights after the others that shine on nothing: where they are hidden from, the environment is.
    n_probes: u32,
    // Of the picture of what is all around: radiance as harmonics, tapered so that it does not ring, and irradiance over pi.
    // See environment_harmonics.wgsl.
    around: array<vec4<f32>, 16>,
    around_irradiance: array<vec4<f32>, 9>,
}

@group(0) @binding(auto) var<uniform> scene: Scene;
@group(0) @binding(auto) var<storage, read> scene_lights: array<SceneLight>;

struct Arriving {
    to_light: vec3<f32>,
    // Of a surface that faces the light, nothing in between.
    irradiance: vec3<f32>,
}

fn arriving(light_idx: u32, position: vec3<f32>) -> Arriving {
    let light = scene_lights[light_idx];
    var sample: Arriving;
    if light.place.w == 0.0 {
        sample.to_light = light.place.xyz;
        sample.irradiance = light.irradiance;
        return sample;
    }
    let towards = light.place.xyz - position;
    let distance2 = max(dot(towards, towards), 1.0);
    sample.to_light = towards * inverseSqrt(distance2);
    let emitted = mix(1.0, max(-dot(sample.to_light, light.axis), 0.0), light.is_flat);
    sample.irradiance = light.irradiance * (emitted / distance2);
    return sample;
}
