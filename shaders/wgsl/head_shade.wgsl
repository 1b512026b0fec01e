// The head, lit once a pixel: skin under the same lights as the hair, softly glossy.
#import lorelei::head_frame::{view, head_look}
#import lorelei::shade_lights::{scene, arriving}
#import lorelei::shadow::{light_visibility}
#import lorelei::ambient::{ambient}

// See head_surface.wgsl.
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_normal: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_storage_2d<rgba16float, write>;

const INV_PI: f32 = 0.31830988618379067;
// Light that enters skin leaves it some millimetres away, red light the farthest: scattering distances of Caucasian
// skin are about 3.7, 1.4 and 0.7 mm (Jensen et al. 2001, table 1, as mean free paths of the reduced medium).
const CREEP: vec3<f32> = vec3<f32>(1.0, 0.45, 0.3);
// Skin reflects 2.8 % head-on, with a roughness of about a third (Weyrich et al. 2006 measured 0.2-0.4).
const F0: f32 = 0.028;
const ALPHA2: f32 = 0.03;
// What roots leave of red, green and blue: strands are brown between the shadows that they cast.
const ROOT_TINT: vec3<f32> = vec3<f32>(1.0, 0.85, 0.72);

// GGX with Kelemen and Szirmay-Kalos' visibility (2001): radiance for unit irradiance of a facing surface.
fn reflection(normal: vec3<f32>, to_light: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let half_way = normalize(to_light + to_eye);
    let cos_h = max(dot(normal, half_way), 0.0);
    let cos_d = max(dot(to_eye, half_way), 0.1);
    let base = cos_h * cos_h * (ALPHA2 - 1.0) + 1.0;
    let fresnel = F0 + (1.0 - F0) * pow(1.0 - cos_d, 5.0);
    return fresnel * ALPHA2 * INV_PI / (base * base) / (4.0 * cos_d * cos_d) * max(dot(normal, to_light), 0.0);
}

fn skin(position: vec3<f32>, surface_normal: vec3<f32>, scalp: f32) -> vec3<f32> {
    // Open meshes (a neck cut off) show their inside.
    let to_eye = normalize(scene.eye - position);
    let is_inside = dot(surface_normal, to_eye) < -0.2;
    let normal = select(surface_normal, -surface_normal, is_inside);
    let wrap = head_look.softness * CREEP;
    var irradiance = vec3<f32>(0.0);
    var reflected = vec3<f32>(0.0);
    for (var light_idx = 0u; light_idx < scene.n_lights; light_idx++) {
        let light = arriving(light_idx, position);
        let cosine = max((vec3<f32>(dot(normal, light.to_light)) + wrap) / (1.0 + wrap), vec3<f32>(0.0));
        if cosine.x > 0.0 {
            let arrived = light.irradiance * light_visibility(light_idx, position);
            irradiance += cosine * arrived;
            reflected += reflection(normal, light.to_light, to_eye) * arrived;
        }
    }
    let between_roots = mix(vec3<f32>(1.0), (1.0 - head_look.roots) * ROOT_TINT, scalp);
    let gloss = head_look.gloss * (1.0 - scalp);
    return between_roots * head_look.albedo * (INV_PI * irradiance + ambient(normal)) + gloss * reflected;
}

// Colours of a painted map's values from none to most, sRGB. Twin of RAMP in overlay.rs.
const RAMP: array<vec3<f32>, 5> = array<vec3<f32>, 5>(
    vec3<f32>(0.16, 0.12, 0.33),
    vec3<f32>(0.20, 0.36, 0.55),
    vec3<f32>(0.13, 0.57, 0.55),
    vec3<f32>(0.48, 0.78, 0.35),
    vec3<f32>(0.99, 0.90, 0.20),
);

// A map's value instead of skin: lit only as much as shows the shape, so that the colour tells the value.
fn overlay(value: f32, normal: vec3<f32>, to_eye: vec3<f32>) -> vec3<f32> {
    var ramp = RAMP;
    let x = 4.0 * saturate(value);
    let i = min(u32(x), 3u);
    let colour = mix(ramp[i], ramp[i + 1u], x - f32(i));
    return pow(colour, vec3<f32>(2.2)) * (0.45 + 0.55 * abs(dot(normal, to_eye)));
}

@compute @workgroup_size(8, 8)
fn shade_head(
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    if any(id.xy >= view.size) {
        return;
    }
    let surface = textureLoad(head_depth, id.xy, 0).xy;
    let coverage = surface.y;
    if coverage == 0.0 {
        textureStore(head_colour, id.xy, vec4<f32>(0.0));
        return;
    }
    // Compute the world position on the ray through the pixel: the rows of the view's rotation are its axes.
    let off = (vec2<f32>(id.xy) + 0.5 - 0.5 * vec2<f32>(view.size)) / view.pixels_per_tangent;
    let rotation = transpose(mat3x3<f32>(view.view_from_world[0].xyz, view.view_from_world[1].xyz, view.view_from_world[2].xyz));
    let position = view.eye + surface.x * (rotation * vec3<f32>(off.x, -off.y, -1.0));
    let resolved = textureLoad(head_normal, id.xy, 0);
    let normal = resolved.xyz * inverseSqrt(max(dot(resolved.xyz, resolved.xyz), 1e-12));
    let w = resolved.w / coverage;
    if head_look.overlay > 0.0 && w > 0.5 {
        let colour = overlay(w - 1.0, normal, normalize(view.eye - position));
        textureStore(head_colour, id.xy, coverage * vec4<f32>(colour, 1.0));
        return;
    }
    let scalp = select(saturate(w), 0.0, head_look.overlay > 0.0);
    textureStore(head_colour, id.xy, coverage * vec4<f32>(skin(position, normal, scalp), 1.0));
}
