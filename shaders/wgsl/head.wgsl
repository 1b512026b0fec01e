// The head's outline: its normals, four samples a pixel. head_shade.wgsl lights what is seen of it.
#import lorelei::camera::{View}

struct HeadLook {
    world_from_head: mat4x4<f32>,
    albedo: vec3<f32>,
    gloss: f32,
    softness: f32,
    roots: f32,
    pad0: f32,
    pad1: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> head_look: HeadLook;
// Three numbers a vertex each, head space.
@group(0) @binding(auto) var<storage, read> head_positions: array<f32>;
@group(0) @binding(auto) var<storage, read> head_normals: array<f32>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;
// 0 on skin, 1 on the scalp away from the hairline.
@group(0) @binding(auto) var<storage, read> head_scalp: array<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) scalp: f32,
}

@vertex
fn vertex(@builtin(vertex_index) corner_idx: u32) -> Corner {
    let vertex_idx = head_indices[corner_idx];
    let at = 3u * vertex_idx;
    let position = vec3<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u]);
    let normal = vec3<f32>(head_normals[at], head_normals[at + 1u], head_normals[at + 2u]);
    let world = head_look.world_from_head * vec4<f32>(position, 1.0);
    let turned = (head_look.world_from_head * vec4<f32>(normal, 0.0)).xyz;
    return Corner(view.clip_from_world * world, turned, head_scalp[vertex_idx]);
}

// World normal, and how much of the pixel is scalp.
@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(normalize(corner.normal), corner.scalp);
}
