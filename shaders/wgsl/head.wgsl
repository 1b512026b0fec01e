// The head's outline: its normals, four samples a pixel. head_shade.wgsl lights what is seen of it.
#import lorelei::camera::{View}

struct HeadLook {
    world_from_head: mat4x4<f32>,
    albedo: vec3<f32>,
    gloss: f32,
    softness: f32,
    roots: f32,
    // How many times a painted map's texels are scaled up to be shown; 0: none is shown.
    overlay: f32,
    pad: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> head_look: HeadLook;
// Three numbers a vertex each, head space.
@group(0) @binding(auto) var<storage, read> head_positions: array<f32>;
@group(0) @binding(auto) var<storage, read> head_normals: array<f32>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;
// 0 on skin, 1 on the scalp away from the hairline.
@group(0) @binding(auto) var<storage, read> head_scalp: array<f32>;

// Three numbers a vertex: its place in a painted map, and 1 where maps are painted.
@group(0) @binding(auto) var<storage, read> head_map_places: array<f32>;
// A painted map; row 0 at v = 1.
@group(0) @binding(auto) var head_overlay: texture_2d<f32>;

struct Corner {
    @builtin(position) clip: vec4<f32>,
    @location(0) normal: vec3<f32>,
    @location(1) scalp: f32,
    @location(2) map_place: vec3<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) corner_idx: u32) -> Corner {
    let vertex_idx = head_indices[corner_idx];
    let at = 3u * vertex_idx;
    let position = vec3<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u]);
    let normal = vec3<f32>(head_normals[at], head_normals[at + 1u], head_normals[at + 2u]);
    let world = head_look.world_from_head * vec4<f32>(position, 1.0);
    let turned = (head_look.world_from_head * vec4<f32>(normal, 0.0)).xyz;
    let map_place = vec3<f32>(head_map_places[at], head_map_places[at + 1u], head_map_places[at + 2u]);
    return Corner(view.clip_from_world * world, turned, head_scalp[vertex_idx], map_place);
}

fn overlay_texel(at: vec2<i32>) -> f32 {
    let last = vec2<i32>(textureDimensions(head_overlay)) - 1;
    return textureLoad(head_overlay, clamp(at, vec2<i32>(0), last), 0).x;
}

// Bilinear, as ScalpMap::sample.
fn overlay_at(uv: vec2<f32>) -> f32 {
    let at = vec2<f32>(uv.x, 1.0 - uv.y) * vec2<f32>(textureDimensions(head_overlay)) - 0.5;
    let low = vec2<i32>(floor(at));
    let f = at - floor(at);
    let top = mix(overlay_texel(low), overlay_texel(low + vec2<i32>(1, 0)), f.x);
    let bottom = mix(overlay_texel(low + vec2<i32>(0, 1)), overlay_texel(low + vec2<i32>(1, 1)), f.x);
    return mix(top, bottom, f.y);
}

// World normal, and how much of the pixel is scalp. Where a map is shown: 0 off the scalp, 1 to 2 with its value.
@fragment
fn fragment(corner: Corner) -> @location(0) vec4<f32> {
    var scalp = corner.scalp;
    if head_look.overlay > 0.0 {
        let value = saturate(head_look.overlay * overlay_at(corner.map_place.xy));
        scalp = select(0.0, 1.0 + value, corner.map_place.z > 0.999);
    }
    return vec4<f32>(normalize(corner.normal), scalp);
}
