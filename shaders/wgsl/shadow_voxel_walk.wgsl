// Hair into a grid that serves every light: each piece of a strand adds its area to the cell that it lies in, as the
// tensor of its direction t: w t t^T with w = 2 r length. A light from omega then meets about sqrt(w (w - o.T.o)) of it.
#import lorelei::shadow_map::{shadow_params}
#import lorelei::shadow_voxel_grid::{N_NUMBERS, AREA_FIXED_POINT}

struct ShadowLayer {
    first_vertex: u32,
    n_segments: u32,
    vertices_per_strand: u32,
    width_scale: f32,
}

@group(0) @binding(auto) var<uniform> shadow_layer: ShadowLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// xx, yy, zz, xy, xz, yz of each cell.
@group(0) @binding(auto) var<storage, read_write> shadow_tensors: array<atomic<i32>>;

// Longest piece, in cells.
const PIECE: f32 = 0.5;

@compute @workgroup_size(64)
fn build(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let segment = id.x + id.y * n_groups.x * 64u;
    if segment >= shadow_layer.n_segments {
        return;
    }
    let n_per_strand = shadow_layer.vertices_per_strand - 1u;
    let strand = segment / n_per_strand;
    let vertex = shadow_layer.first_vertex + strand * shadow_layer.vertices_per_strand + segment % n_per_strand;
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    let along = tip.xyz - root.xyz;
    let length2 = dot(along, along);
    if !(length2 > 1e-12) {
        return;
    }
    let length = sqrt(length2);
    let t = along / length;
    let n_pieces = u32(ceil(length * shadow_params.voxels_per_cm / PIECE));
    let corner_to_root = (root.xyz - shadow_params.voxel_corner) * shadow_params.voxels_per_cm;
    let step = along * (shadow_params.voxels_per_cm / f32(n_pieces));
    let area = 2.0 * shadow_layer.width_scale * length / f32(n_pieces) * AREA_FIXED_POINT;
    for (var k = 0u; k < n_pieces; k++) {
        let share = (f32(k) + 0.5) / f32(n_pieces);
        let cell = vec3<i32>(floor(corner_to_root + (f32(k) + 0.5) * step));
        if any(cell < vec3<i32>(0)) || any(cell >= vec3<i32>(i32(shadow_params.n_voxels))) {
            continue;
        }
        let n = i32(shadow_params.n_voxels);
        let at = u32((cell.z * n + cell.y) * n + cell.x) * N_NUMBERS;
        let w = area * mix(root.w, tip.w, share);
        let diagonal = vec3<i32>(round(w * t * t));
        let mixed = vec3<i32>(round(w * t.xxy * t.yzz));
        atomicAdd(&shadow_tensors[at], diagonal.x);
        atomicAdd(&shadow_tensors[at + 1u], diagonal.y);
        atomicAdd(&shadow_tensors[at + 2u], diagonal.z);
        atomicAdd(&shadow_tensors[at + 3u], mixed.x);
        atomicAdd(&shadow_tensors[at + 4u], mixed.y);
        atomicAdd(&shadow_tensors[at + 5u], mixed.z);
    }
}
