// The head: matte skin under the same lights as the hair.
#import lorelei::camera::{View}
#import lorelei::shade_lights::{scene, arriving}
#import lorelei::shadow::{light_visibility}

struct HeadLook {
    world_from_head: mat4x4<f32>,
    albedo: vec3<f32>,
    pad: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> head_look: HeadLook;
// Three numbers a vertex each, head space.
@group(0) @binding(auto) var<storage, read> head_positions: array<f32>;
@group(0) @binding(auto) var<storage, read> head_normals: array<f32>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) position: vec3<f32>,
    @location(1) normal: vec3<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) corner_idx: u32) -> Corner {
    let at = 3u * head_indices[corner_idx];
    let position = vec3<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u]);
    let normal = vec3<f32>(head_normals[at], head_normals[at + 1u], head_normals[at + 2u]);
    let world = head_look.world_from_head * vec4<f32>(position, 1.0);
    return Corner(view.clip_from_world * world, world.xyz, (head_look.world_from_head * vec4<f32>(normal, 0.0)).xyz);
}

const INV_PI: f32 = 0.31830988618379067;
// Light that enters skin leaves it some millimetres away: the border of a lamp's light is soft by about this cosine.
const WRAP: f32 = 0.12;

@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    let to_eye = normalize(scene.eye - corner.position);
    var normal = normalize(corner.normal);
    // Open meshes (a neck cut off) show their inside.
    if dot(normal, to_eye) < -0.2 {
        normal = -normal;
    }
    var irradiance = vec3<f32>(0.0);
    for (var light_idx = 0u; light_idx < scene.n_lights; light_idx++) {
        let light = arriving(light_idx, corner.position);
        let cosine = (dot(normal, light.to_light) + WRAP) / (1.0 + WRAP);
        if cosine > 0.0 {
            irradiance += cosine * light.irradiance * light_visibility(light_idx, corner.position);
        }
    }
    // Skin below sees the floor and the chest instead of the sky: a little less from all around.
    let ambient = scene.environment * (0.75 + 0.25 * normal.y);
    return vec4<f32>(head_look.albedo * (INV_PI * irradiance + ambient), 1.0);
}
