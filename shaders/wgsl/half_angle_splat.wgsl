// The opacity of a slice's segments into the light buffer: each a row of points as far apart as a texel is wide, and each
// point's area over its texel's.
//
// Ikits et al. 2004 (GPU Gems, section 39.5.1) draw the slice from the light and blend. What is kept here is the optical
// depth, as all shadow techniques have it: a sum needs no order and no half float that rounds thin hair away.
#import lorelei::half_angle::{half_angle, half_angle_lights, half_angle_slice, DEPTH_ONE}
#import lorelei::shadow_map::{map_place}
#import lorelei::strands::{vertices}

@group(0) @binding(auto) var<storage, read> order: array<u32>;
@group(0) @binding(auto) var<storage, read_write> half_angle_map: array<atomic<u32>>;

@compute @workgroup_size(64)
fn splat(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= half_angle_slice.n_segments {
        return;
    }
    let vertex = order[half_angle_slice.first_segment + item];
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    let resolution = f32(half_angle.resolution);
    for (var k = 0u; k < half_angle.n_lights; k++) {
        let light = half_angle_lights[k];
        let a = map_place(light, root.xyz);
        let b = map_place(light, tip.xyz);
        let run = b.xy - a.xy;
        // Nothing of the map's size is longer than its diagonal.
        if a.w <= 0.0 || b.w <= 0.0 || !(dot(run, run) < 2.0 * resolution * resolution) {
            continue;
        }
        let n = max(ceil(length(run)), 1.0);
        let widths = 2.0 * light.texels_per_cm * vec2<f32>(root.w / a.w, tip.w / b.w);
        let base = k * half_angle.resolution * half_angle.resolution;
        for (var point = 0.5; point < n; point += 1.0) {
            let t = point / n;
            let at = a.xy + t * run;
            if any(at < vec2<f32>(0.0)) || any(at >= vec2<f32>(resolution)) {
                continue;
            }
            let area = length(run) / n * mix(widths.x, widths.y, t);
            let texel = vec2<u32>(at);
            atomicAdd(&half_angle_map[base + texel.y * half_angle.resolution + texel.x], u32(area * DEPTH_ONE + 0.5));
        }
    }
}
