// Both vertices of a slice's segments in false colours that depend on what the slices before have left of the light.
#import lorelei::half_angle::{half_angle_slice}
#import lorelei::strands::{vertices}
#import lorelei::view_colour::{colour}
#import lorelei::view_ramp::{light_of}

@group(0) @binding(auto) var<storage, read> order: array<u32>;
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn paint(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= 2u * half_angle_slice.n_segments {
        return;
    }
    let first = order[half_angle_slice.first_segment + item / 2u];
    let vertex = first + item % 2u;
    // Which strand it is and which way it runs, no such colour asks.
    let light = light_of(colour(0u, vertices[vertex].xyz, vec3<f32>(0.0)));
    radiance[vertex] = vec2<u32>(pack2x16float(light.xy), pack2x16float(vec2<f32>(light.z, 1.0)));
}
