// The head, lit once a pixel: matte skin under the same lights as the hair. And its depth, from four samples to one
// value a pixel, with the depth behind which a whole tile is head.
//
// Lit here and not where triangles are drawn: a GPU made for computing has few units that can draw, and the lookups
// of three lights' shadows took 4.6 ms there on an H200.
#import lorelei::camera::{View}
#import lorelei::tile::{TILE}
#import lorelei::shade_lights::{scene, arriving}
#import lorelei::shadow::{light_visibility}

struct HeadLook {
    world_from_head: mat4x4<f32>,
    albedo: vec3<f32>,
    pad: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> head_look: HeadLook;
@group(0) @binding(auto) var head_samples: texture_depth_multisampled_2d;
@group(0) @binding(auto) var head_normal: texture_2d<f32>;
// Mean view depth of the samples that hit the head, cm; NO_HEAD elsewhere.
@group(0) @binding(auto) var head_depth: texture_storage_2d<r32float, write>;
@group(0) @binding(auto) var head_colour: texture_storage_2d<rgba16float, write>;
// Bits of the farthest depth in each of the rasteriser's tiles, 0 before the frame.
@group(0) @binding(auto) var<storage, read_write> tile_backs: array<atomic<u32>>;

const NO_HEAD: f32 = 1e30;
const INV_PI: f32 = 0.31830988618379067;
// Light that enters skin leaves it some millimetres away: the border of a lamp's light is soft by about this cosine.
const WRAP: f32 = 0.12;

fn skin(position: vec3<f32>, surface_normal: vec3<f32>) -> vec3<f32> {
    // Open meshes (a neck cut off) show their inside.
    let is_inside = dot(surface_normal, normalize(scene.eye - position)) < -0.2;
    let normal = select(surface_normal, -surface_normal, is_inside);
    var irradiance = vec3<f32>(0.0);
    for (var light_idx = 0u; light_idx < scene.n_lights; light_idx++) {
        let light = arriving(light_idx, position);
        let cosine = (dot(normal, light.to_light) + WRAP) / (1.0 + WRAP);
        if cosine > 0.0 {
            irradiance += cosine * light.irradiance * light_visibility(light_idx, position);
        }
    }
    // Skin below sees the floor and the chest instead of the sky: a little less from all around.
    let ambient = scene.environment * (0.75 + 0.25 * normal.y);
    return head_look.albedo * (INV_PI * irradiance + ambient);
}

@compute @workgroup_size(8, 8)
fn shade_head(
    @builtin(global_invocation_id) id: vec3<u32>,
) {
    if any(id.xy >= view.size) {
        return;
    }
    var sum = 0.0;
    var n = 0.0;
    for (var k = 0; k < 4; k++) {
        let sample = textureLoad(head_samples, id.xy, k);
        if sample < 1.0 {
            // The inverse of a perspective with depth 0 at `near` and 1 at `far`.
            sum += view.near * view.far / (view.far - sample * (view.far - view.near));
            n += 1.0;
        }
    }
    let depth = select(NO_HEAD, sum / max(n, 1.0), n > 0.0);
    textureStore(head_depth, id.xy, vec4<f32>(depth));
    let back = bitcast<u32>(select(NO_HEAD, depth, n == 4.0));
    let tile = id.xy / u32(TILE);
    let tile_idx = tile.y * ((view.size.x + u32(TILE) - 1u) / u32(TILE)) + tile.x;
    if back > atomicLoad(&tile_backs[tile_idx]) {
        atomicMax(&tile_backs[tile_idx], back);
    }
    if n == 0.0 {
        textureStore(head_colour, id.xy, vec4<f32>(0.0));
        return;
    }
    // Compute the world position on the ray through the pixel: the rows of the view's rotation are its axes.
    let off = (vec2<f32>(id.xy) + 0.5 - 0.5 * vec2<f32>(view.size)) / view.pixels_per_tangent;
    let rotation = transpose(mat3x3<f32>(view.view_from_world[0].xyz, view.view_from_world[1].xyz, view.view_from_world[2].xyz));
    let position = view.eye + depth * (rotation * vec3<f32>(off.x, -off.y, -1.0));
    let resolved = textureLoad(head_normal, id.xy, 0);
    let coverage = 0.25 * n;
    let normal = resolved.xyz * inverseSqrt(max(dot(resolved.xyz, resolved.xyz), 1e-12));
    textureStore(head_colour, id.xy, coverage * vec4<f32>(skin(position, normal), 1.0));
}
