// Strands that a solver has moved, put where they are drawn from: the splines through their vertices, as many vertices as
// the level of detail has. Their radii stay.

struct PlaceParams {
    first_vertex: u32,
    // Vertices of a strand as it is drawn, and as it was moved.
    n_vertices: u32,
    n_moved: u32,
    n_strands: u32,
}

@group(0) @binding(0) var<uniform> place: PlaceParams;
// World centimetres.
@group(0) @binding(1) var<storage, read> moved: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> vertices: array<vec4<f32>>;

// Catmull-Rom; beyond its ends the strand is mirrored in them. As `catmull_rom` of lorelei-core.
fn spline_at(first: u32, u: f32) -> vec3<f32> {
    let last = place.n_moved - 1u;
    let segment = min(u32(u), last - 1u);
    let x = u - f32(segment);
    let x2 = x * x;
    let x3 = x2 * x;
    let here = moved[first + segment].xyz;
    let next = moved[first + segment + 1u].xyz;
    var before = 2.0 * here - next;
    if segment > 0u {
        before = moved[first + segment - 1u].xyz;
    }
    var after = 2.0 * next - here;
    if segment + 2u <= last {
        after = moved[first + segment + 2u].xyz;
    }
    return 0.5 * ((-x + 2.0 * x2 - x3) * before + (2.0 - 5.0 * x2 + 3.0 * x3) * here
        + (x + 4.0 * x2 - 3.0 * x3) * next + (x3 - x2) * after);
}

@compute @workgroup_size(64)
fn place_strands(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let item = id.x + id.y * groups.x * 64u;
    if item >= place.n_strands * place.n_vertices {
        return;
    }
    let v = item % place.n_vertices;
    let first = (item / place.n_vertices) * place.n_moved;
    let u = f32(v) / f32(place.n_vertices - 1u) * f32(place.n_moved - 1u);
    let at = place.first_vertex + item;
    vertices[at] = vec4<f32>(spline_at(first, u), vertices[at].w);
}
