// From the opacity of each slice alone to the optical depth down to each slice's end: a prefix sum in place, once a texel.
// Kim and Neumann 2001 draw the hair once a slice; here it is drawn once in all.
#import lorelei::shadow_map::{shadow_params}

@group(0) @binding(auto) var<storage, read_write> shadow_slices: array<u32>;

@compute @workgroup_size(64)
fn sum_slices(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let at = id.x + id.y * n_groups.x * 64u;
    if at >= shadow_params.resolution * shadow_params.resolution * shadow_params.n_lights {
        return;
    }
    let n_words = shadow_params.n_parts / 2u;
    var above = 0u;
    for (var word = at * n_words; word < (at + 1u) * n_words; word++) {
        let two = shadow_slices[word];
        let near = min(above + (two & 0xffffu), 0xffffu);
        above = min(near + (two >> 16u), 0xffffu);
        shadow_slices[word] = near | (above << 16u);
    }
}
