// Between the rounds of k-means, once a texel: clusters begin evenly spread, their centres go to the mean of what they
// gathered, and in the end moments become means and widths.
#import lorelei::shadow_map::{shadow_params, front_depth}
#import lorelei::shadow_clusters::{N_CLUSTERS, N_MOMENTS, MOMENT_FIXED_POINT, extent}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
@group(0) @binding(auto) var<storage, read_write> shadow_centres: array<f32>;
@group(0) @binding(auto) var<storage, read_write> shadow_moments: array<u32>;

// Cluster of this thread; beyond the last one: none.
fn cluster_of(id: vec3<u32>, n_groups: vec3<u32>) -> u32 {
    return id.x + id.y * n_groups.x * 64u;
}

fn n_clusters() -> u32 {
    return N_CLUSTERS * shadow_params.resolution * shadow_params.resolution * shadow_params.n_lights;
}

@compute @workgroup_size(64)
fn begin(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let cluster = cluster_of(id, n_groups);
    if cluster < n_clusters() {
        shadow_centres[cluster] = (f32(cluster % N_CLUSTERS) + 0.5) / f32(N_CLUSTERS);
    }
}

@compute @workgroup_size(64)
fn recentre(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let cluster = cluster_of(id, n_groups);
    if cluster >= n_clusters() {
        return;
    }
    let at = cluster * N_MOMENTS;
    if shadow_moments[at] > 0u {
        shadow_centres[cluster] = f32(shadow_moments[at + 1u]) / f32(shadow_moments[at]);
    }
    for (var k = 0u; k < N_MOMENTS; k++) {
        shadow_moments[at + k] = 0u;
    }
}

@compute @workgroup_size(64)
fn finish(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let cluster = cluster_of(id, n_groups);
    if cluster >= n_clusters() {
        return;
    }
    let at = cluster * N_MOMENTS;
    let weight = f32(shadow_moments[at]);
    if weight == 0.0 {
        return;
    }
    let texel = cluster / N_CLUSTERS;
    let front = shadow_front[texel];
    let width = extent(front, shadow_back[texel]);
    let mean = f32(shadow_moments[at + 1u]) / weight;
    // The squares were taken about the centre and not the mean.
    let off = mean - shadow_centres[cluster];
    let variance = max(f32(shadow_moments[at + 2u]) / weight - off * off, 0.0);
    shadow_moments[at] = bitcast<u32>(weight / MOMENT_FIXED_POINT);
    shadow_moments[at + 1u] = bitcast<u32>(front_depth(front) + mean * width);
    shadow_moments[at + 2u] = bitcast<u32>(sqrt(3.0 * variance) * width);
}
