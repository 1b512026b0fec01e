// What of the head each light sees: one thread a triangle and light.
#import lorelei::shadow_map::{shadow_params, shadow_lights, texel_index, front_bits}
#import lorelei::triangle::{SEAM, box_of, triangle_of, shares_at}

struct HeadCaster {
    world_from_head: mat4x4<f32>,
    n_triangles: u32,
}

@group(0) @binding(auto) var<uniform> head_caster: HeadCaster;
// Three numbers a vertex, centimetres in head space.
@group(0) @binding(auto) var<storage, read> head_positions: array<f32>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;
// `front_bits` of each texel of each light; 0 before the frame.
@group(0) @binding(auto) var<storage, read_write> shadow_head: array<atomic<u32>>;

// (texel x * w, texel y * w, depth in cm, w)
fn corner_at(light_idx: u32, corner: u32) -> vec4<f32> {
    let at = 3u * head_indices[corner];
    let in_head = vec4<f32>(head_positions[at], head_positions[at + 1u], head_positions[at + 2u], 1.0);
    return shadow_lights[light_idx].map_from_world * (head_caster.world_from_head * in_head);
}

@compute @workgroup_size(64)
fn draw_head(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let triangle_idx = id.x + id.y * n_groups.x * 64u;
    let light_idx = id.z;
    if triangle_idx >= head_caster.n_triangles || shadow_lights[light_idx].casts == 0u {
        return;
    }
    let p = corner_at(light_idx, 3u * triangle_idx);
    let q = corner_at(light_idx, 3u * triangle_idx + 1u);
    let r = corner_at(light_idx, 3u * triangle_idx + 2u);
    let touched = box_of(p.xyw, q.xyw, r.xyw, 0.0, vec2<f32>(f32(shadow_params.resolution)));
    if any(touched.low >= touched.high) {
        return;
    }
    let triangle = triangle_of(p.xyw, q.xyw, r.xyw, touched.origin);
    let first = vec2<i32>(touched.low);
    let last = min(vec2<i32>(touched.high), vec2<i32>(i32(shadow_params.resolution) - 1));
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            let texel = vec2<i32>(column, row);
            let shares = shares_at(triangle, vec2<f32>(texel) + 0.5);
            let per_w = shares.x + shares.y + shares.z;
            if per_w > 0.0 && min(min(shares.x, shares.y), shares.z) >= -SEAM * per_w {
                let depth = dot(shares, vec3<f32>(p.z, q.z, r.z)) / per_w;
                atomicMax(&shadow_head[texel_index(light_idx, texel)], front_bits(depth));
            }
        }
    }
}
