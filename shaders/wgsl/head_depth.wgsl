// The head's depth, from four samples to one value a pixel, and the depth behind which a whole tile is head.
#import lorelei::camera::{View}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var head_samples: texture_depth_multisampled_2d;
// Mean view depth of the samples that hit the head, cm; NO_HEAD elsewhere.
@group(0) @binding(auto) var head_depth: texture_storage_2d<r32float, write>;
// Bits of the farthest depth in each tile of 8 x 8 pixels, 0 before the frame.
@group(0) @binding(auto) var<storage, read_write> tile_backs: array<atomic<u32>>;

const NO_HEAD: f32 = 1e30;

@compute @workgroup_size(8, 8)
fn resolve_depth(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    if any(id.xy >= view.size) {
        return;
    }
    var sum = 0.0;
    var n = 0.0;
    for (var k = 0; k < 4; k++) {
        let sample = textureLoad(head_samples, id.xy, k);
        if sample < 1.0 {
            // The inverse of a perspective with depth 0 at `near` and 1 at `far`.
            sum += view.near * view.far / (view.far - sample * (view.far - view.near));
            n += 1.0;
        }
    }
    let depth = select(NO_HEAD, sum / max(n, 1.0), n > 0.0);
    textureStore(head_depth, id.xy, vec4<f32>(depth));
    let back = select(NO_HEAD, depth, n == 4.0);
    atomicMax(&tile_backs[group.y * n_groups.x + group.x], bitcast<u32>(back));
}
