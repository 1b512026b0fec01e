// Guides that follow moved curves: on them, or beside them. Twin of sim/src/follow.rs.

#import lorelei::sim_pose::rotate

struct FollowParams {
    // The head's, as the picture shows it.
    rotation: vec4<f32>,
    // Vertices of a guide, and of the curve that it follows.
    n_guide: u32,
    n_curve: u32,
    n_items: u32,
    // 1: guides lie beside their curve.
    is_beside: u32,
}

struct Row {
    vertices: vec4<u32>,
    weights: vec4<f32>,
    slopes: vec4<f32>,
}

@group(0) @binding(auto) var<uniform> follow: FollowParams;
// Per guide: its curve, and its first row.
@group(0) @binding(auto) var<storage, read> leads: array<vec2<u32>>;
@group(0) @binding(auto) var<storage, read> rows: array<Row>;
// Per guide vertex: from its place on the curve, and the curve's direction there; at rest, head space.
@group(0) @binding(auto) var<storage, read> offsets: array<vec4<f32>>;
// What the picture shows of the curves, and of the guides.
@group(0) @binding(auto) var<storage, read> curves: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> followed: array<vec4<f32>>;

fn row_sum(vertices: vec4<u32>, weights: vec4<f32>, first: u32) -> vec3<f32> {
    var p = weights.x * curves[first + vertices.x].xyz;
    p += weights.y * curves[first + vertices.y].xyz;
    p += weights.z * curves[first + vertices.z].xyz;
    p += weights.w * curves[first + vertices.w].xyz;
    return p;
}

// By the shortest way that takes direction `before` to direction `after`.
fn turned(v: vec3<f32>, before: vec3<f32>, after: vec3<f32>) -> vec3<f32> {
    let lengths = length(before) * length(after);
    if !(lengths > 1e-12) {
        return v;
    }
    let cosine = dot(before, after) / lengths;
    if cosine < -0.999 {
        return v;
    }
    let axis = cross(before, after) / lengths;
    return v + cross(axis, v) + cross(axis, cross(axis, v)) / (1.0 + cosine);
}

@compute @workgroup_size(64)
fn follow_curves(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let item = id.x + id.y * groups.x * 64u;
    if item >= follow.n_items {
        return;
    }
    let lead = leads[item / follow.n_guide];
    let row = rows[lead.y + item % follow.n_guide];
    let first = lead.x * follow.n_curve;
    var p = row_sum(row.vertices, row.weights, first);
    if follow.is_beside != 0u {
        let offset = rotate(follow.rotation, offsets[2u * item].xyz);
        let tangent = rotate(follow.rotation, offsets[2u * item + 1u].xyz);
        p += turned(offset, tangent, row_sum(row.vertices, row.slopes, first));
    }
    followed[item] = vec4<f32>(p, 0.0);
}
