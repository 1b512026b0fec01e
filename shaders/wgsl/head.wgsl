// The head's outline: its normals, four samples a pixel. head_shade.wgsl lights what is seen of it.
#import lorelei::camera::{View}

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
    @location(0) normal: vec3<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) corner_idx: u32) -> Corner {
    let at = 3u * head_indices[corner_idx];
    let position = vec3<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u]);
    let normal = vec3<f32>(head_normals[at], head_normals[at + 1u], head_normals[at + 2u]);
    let world = head_look.world_from_head * vec4<f32>(position, 1.0);
    return Corner(view.clip_from_world * world, (head_look.world_from_head * vec4<f32>(normal, 0.0)).xyz);
}

// World normal; the alpha of the resolved pixel is the share of it that the head covers.
@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    return vec4<f32>(normalize(corner.normal), 1.0);
}
