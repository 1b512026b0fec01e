// From the area of the strands in each cell to its density per centimetre, as half floats.
#import lorelei::shadow_map::{shadow_params}
#import lorelei::shadow_voxel_grid::{N_NUMBERS, N_WORDS, AREA_FIXED_POINT}

@group(0) @binding(auto) var<storage, read> shadow_tensors: array<i32>;
@group(0) @binding(auto) var<storage, read_write> shadow_voxels: array<u32>;

@compute @workgroup_size(64)
fn pack_voxels(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let voxel = id.x + id.y * n_groups.x * 64u;
    let n = shadow_params.n_voxels;
    if voxel >= n * n * n {
        return;
    }
    let per_cm = shadow_params.voxels_per_cm;
    let scale = per_cm * per_cm * per_cm / AREA_FIXED_POINT;
    for (var k = 0u; k < N_WORDS; k++) {
        let at = voxel * N_NUMBERS + 2u * k;
        let two = scale * vec2<f32>(f32(shadow_tensors[at]), f32(shadow_tensors[at + 1u]));
        shadow_voxels[voxel * N_WORDS + k] = pack2x16float(clamp(two, vec2<f32>(-6e4), vec2<f32>(6e4)));
    }
}
