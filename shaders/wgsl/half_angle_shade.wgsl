// Both vertices of a slice's segments, shaded by the light that the slices before have left; each is shaded again where the
// segment before it lies in another slice.
#import lorelei::half_angle::{half_angle_slice}
#import lorelei::shade_layers::{fibres, layer_of_vertex}
#import lorelei::shade_vertex::{shaded_vertex}

@group(0) @binding(auto) var<storage, read> order: array<u32>;
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= 2u * half_angle_slice.n_segments {
        return;
    }
    let vertex = order[half_angle_slice.first_segment + item / 2u] + item % 2u;
    let layer = layer_of_vertex(vertex);
    radiance[vertex] = shaded_vertex(layer, vertex - fibres[layer].first_vertex);
}
