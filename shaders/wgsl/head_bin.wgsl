// The head's triangles into lists of the tiles that they touch, one thread a triangle.
#import lorelei::tile::{TILE}
#import lorelei::triangle::{Triangle, box_of, triangle_of, shares_at}
#import lorelei::head_frame::{view, head_look, n_head_tiles}

// Three a vertex: see head_surface.wgsl.
@group(0) @binding(auto) var<storage, read> head_vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;
@group(0) @binding(auto) var<storage, read_write> head_triangles: array<Triangle>;
// Entries in use; then for each tile its first entry + 1 (0: none), and 1 where one more found no room.
@group(0) @binding(auto) var<storage, read_write> head_lists: array<atomic<u32>>;
// A triangle, and the entry after it + 1.
@group(0) @binding(auto) var<storage, read_write> head_entries: array<vec2<u32>>;

// Homogeneous pixel coordinates of a corner.
fn corner_at(corner: u32) -> vec3<f32> {
    let position = head_vertices[3u * head_indices[corner]].xyz;
    let seen = view.view_from_world * (head_look.world_from_head * vec4<f32>(position, 1.0));
    let depth = -seen.z;
    return vec3<f32>(vec2<f32>(seen.x, -seen.y) * view.pixels_per_tangent + 0.5 * vec2<f32>(view.size) * depth, depth);
}

@compute @workgroup_size(64)
fn bin(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let triangle_idx = id.x + id.y * n_groups.x * 64u;
    if triangle_idx >= head_look.n_triangles {
        return;
    }
    let p = corner_at(3u * triangle_idx);
    let q = corner_at(3u * triangle_idx + 1u);
    let r = corner_at(3u * triangle_idx + 2u);
    let touched = box_of(p, q, r, view.near, vec2<f32>(view.size));
    let triangle = triangle_of(p, q, r, touched.origin);
    head_triangles[triangle_idx] = triangle;
    if any(touched.low >= touched.high) {
        return;
    }
    let n_tiles = n_head_tiles(TILE);
    let first = vec2<u32>(touched.low / TILE);
    let last = min(vec2<u32>(touched.high / TILE), n_tiles - 1u);
    let slack = (0.5 * TILE + 0.5) * vec3<f32>(
        abs(triangle.a.x) + abs(triangle.a.y),
        abs(triangle.b.x) + abs(triangle.b.y),
        abs(triangle.c.x) + abs(triangle.c.y),
    );
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            // No corner of the tile is on the inner side of one of its edges.
            let middle = shares_at(triangle, (vec2<f32>(f32(column), f32(row)) + 0.5) * TILE);
            if any(middle + slack < vec3<f32>(0.0)) {
                continue;
            }
            let list = 1u + 2u * (row * n_tiles.x + column);
            let entry = atomicAdd(&head_lists[0], 1u);
            if entry >= head_look.n_entries {
                atomicStore(&head_lists[list + 1u], 1u);
            } else {
                head_entries[entry] = vec2<u32>(triangle_idx, atomicExchange(&head_lists[list], entry + 1u));
            }
        }
    }
}
