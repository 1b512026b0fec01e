// What segments are sorted by: the farther the sooner, from the eye or, with `HALF_ANGLE` defined, along the half vector.
// Segments that are not there come last.
#ifdef HALF_ANGLE
#import lorelei::half_angle::{half_angle}
#else
#import lorelei::camera::{project}
#endif
#import lorelei::raster_frame::{raster, segment_of, NO_VERTEX}
#import lorelei::strands::{vertices}

@group(0) @binding(auto) var<storage, read_write> keys: array<u32>;
@group(0) @binding(auto) var<storage, read_write> values: array<u32>;

fn key_of(middle: vec3<f32>) -> u32 {
#ifdef HALF_ANGLE
    // Bits of numbers of either sign, made to grow as the numbers do.
    let bits = bitcast<u32>(-dot(middle, half_angle.half_vector));
    return select(bits | 0x80000000u, ~bits, (bits & 0x80000000u) != 0u);
#else
    // Bits of positive numbers are in the numbers' order.
    return ~bitcast<u32>(max(project(raster.view, middle).z, 1e-6));
#endif
}

@compute @workgroup_size(64)
fn write_keys(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= raster.n_items {
        return;
    }
    let vertex = segment_of(item);
    values[item] = vertex;
    if vertex == NO_VERTEX {
        keys[item] = 0xFFFFFFFFu;
        return;
    }
    keys[item] = key_of(0.5 * (vertices[vertex].xyz + vertices[vertex + 1u].xyz));
}
