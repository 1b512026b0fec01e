// The head as a light sees it: depth only, linear in centimetres.
#import lorelei::shadow_map::{shadow_params, shadow_lights, map_place}

struct HeadCaster {
    world_from_head: mat4x4<f32>,
    light_idx: u32,
}

@group(0) @binding(auto) var<uniform> head_caster: HeadCaster;
// Three numbers a vertex, centimetres in head space.
@group(0) @binding(auto) var<storage, read> head_positions: array<f32>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;

@vertex
fn vertex(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    let at = 3u * head_indices[corner];
    let in_head = vec3<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u]);
    let light = shadow_lights[head_caster.light_idx];
    let place = map_place(light, (head_caster.world_from_head * vec4<f32>(in_head, 1.0)).xyz);
    let ndc = 2.0 * place.xy / f32(shadow_params.resolution) - 1.0;
    let depth = (place.z - light.near) / (light.far - light.near);
    return vec4<f32>(vec3<f32>(ndc.x, -ndc.y, depth) * place.w, place.w);
}
