// Guides that follow moved curves of fewer vertices. Twin of sim/src/follow.rs.

struct FollowParams {
    // Vertices of a guide, and of the curve that it follows.
    n_guide: u32,
    n_curve: u32,
    n_items: u32,
}

struct Row {
    vertices: vec4<u32>,
    weights: vec4<f32>,
}

@group(0) @binding(0) var<uniform> follow: FollowParams;
@group(0) @binding(1) var<storage, read> first_rows: array<u32>;
@group(0) @binding(2) var<storage, read> rows: array<Row>;
// What the picture shows of the curves, and of the guides.
@group(0) @binding(3) var<storage, read> curves: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> followed: array<vec4<f32>>;

fn row_sum(row: Row, first: u32) -> vec3<f32> {
    var p = row.weights.x * curves[first + row.vertices.x].xyz;
    p += row.weights.y * curves[first + row.vertices.y].xyz;
    p += row.weights.z * curves[first + row.vertices.z].xyz;
    p += row.weights.w * curves[first + row.vertices.w].xyz;
    return p;
}

@compute @workgroup_size(64)
fn follow_curves(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let item = id.x + id.y * groups.x * 64u;
    if item >= follow.n_items {
        return;
    }
    let guide = item / follow.n_guide;
    let row = rows[first_rows[guide] + item % follow.n_guide];
    followed[item] = vec4<f32>(row_sum(row, guide * follow.n_curve), 0.0);
}
