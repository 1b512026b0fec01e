// What of a light arrives at given places: for measurements and tests.
#import lorelei::shadow::{hair_depth, head_visibility, light_visibility}

// A place in world centimetres, and the index of a light.
@group(0) @binding(auto) var<storage, read> probe_places: array<vec4<f32>>;
// Optical depth of the hair, share of the light past the head, share of the light that a surface gets.
@group(0) @binding(auto) var<storage, read_write> probe_answers: array<vec4<f32>>;

@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let i = id.x + id.y * n_groups.x * 64u;
    if i >= arrayLength(&probe_places) {
        return;
    }
    let position = probe_places[i].xyz;
    let light_idx = u32(probe_places[i].w);
    let tau = hair_depth(light_idx, position);
    let past = head_visibility(light_idx, position);
    probe_answers[i] = vec4<f32>(tau, past, light_visibility(light_idx, position), 0.0);
}

// What a fragment asks, and no more: for times.
@compute @workgroup_size(64)
fn probe_hair(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let i = id.x + id.y * n_groups.x * 64u;
    if i >= arrayLength(&probe_places) {
        return;
    }
    probe_answers[i].x = hair_depth(u32(probe_places[i].w), probe_places[i].xyz);
}
