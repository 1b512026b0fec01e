// The frontmost strand near a pixel: first the least depth, then which strand has it. Twin of render/src/inspect.rs.
#import lorelei::camera::{View, project}
#import lorelei::inspect_result::{inspected, PLACE, TANGENT, STRAND, HAIR, BODY, DISPLAY}

struct InspectLayer {
    first_vertex: u32,
    // Index of the layer in `fibres`.
    layer: u32,
    n_strands: u32,
    vertices_per_strand: u32,
    pixel: vec2<u32>,
    // Pixels beyond a strand's edge that still count as near.
    reach: f32,
    pad: f32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> inspect_layer: InspectLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Bits of the least view depth, which order as the depths do.
@group(0) @binding(auto) var<storage, read_write> nearest: atomic<u32>;
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;
@group(0) @binding(auto) var hair: texture_2d<f32>;
@group(0) @binding(auto) var shown: texture_2d<f32>;

struct Near {
    is_near: bool,
    // Share of the segment, pixels from the pixel's middle, view depth.
    along: f32,
    distance: f32,
    depth: f32,
}

fn nearness(a: u32) -> Near {
    let pa = project(view, vertices[a].xyz);
    let pb = project(view, vertices[a + 1u].xyz);
    let at = vec2<f32>(inspect_layer.pixel) + 0.5;
    let step = pb.xy - pa.xy;
    var near: Near;
    near.along = saturate(dot(at - pa.xy, step) / max(dot(step, step), 1e-9));
    near.distance = distance(at, pa.xy + near.along * step);
    near.depth = mix(pa.z, pb.z, near.along);
    let half_width = mix(vertices[a].w, vertices[a + 1u].w, near.along) * view.pixels_per_tangent / near.depth;
    let head = textureLoad(head_depth, inspect_layer.pixel, 0);
    let hidden = near.depth > head.x && head.y > 0.5;
    let in_front = pa.z > view.near && pb.z > view.near;
    near.is_near = in_front && !hidden && near.distance <= half_width + inspect_layer.reach;
    return near;
}

fn segment_of(id: vec3<u32>, n_groups: vec3<u32>) -> u32 {
    return id.x + id.y * n_groups.x * 64u;
}

fn first_of(segment: u32) -> u32 {
    let per_strand = inspect_layer.vertices_per_strand - 1u;
    return inspect_layer.first_vertex + segment / per_strand * inspect_layer.vertices_per_strand + segment % per_strand;
}

// As the kernel `shade` has it, of the strand's vertex `at`.
fn tangent_at(vertex: u32, at: u32) -> vec3<f32> {
    let last = inspect_layer.vertices_per_strand - 1u;
    let along = vertices[vertex + min(last - at, 1u)].xyz - vertices[vertex - min(at, 1u)].xyz;
    return along * inverseSqrt(max(dot(along, along), 1e-12));
}

@compute @workgroup_size(64)
fn find_depth(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let segment = segment_of(id, n_groups);
    if segment >= inspect_layer.n_strands * (inspect_layer.vertices_per_strand - 1u) {
        return;
    }
    let near = nearness(first_of(segment));
    if near.is_near {
        atomicMin(&nearest, bitcast<u32>(near.depth));
    }
}

@compute @workgroup_size(64)
fn find_strand(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let segment = segment_of(id, n_groups);
    if segment >= inspect_layer.n_strands * (inspect_layer.vertices_per_strand - 1u) {
        return;
    }
    let a = first_of(segment);
    let near = nearness(a);
    if !near.is_near || bitcast<u32>(near.depth) != atomicLoad(&nearest) {
        return;
    }
    let per_strand = inspect_layer.vertices_per_strand - 1u;
    let at = segment % per_strand;
    let along = mix(tangent_at(a, at), tangent_at(a + 1u, at + 1u), near.along);
    let place = mix(vertices[a], vertices[a + 1u], near.along);
    let t = (f32(at) + near.along) / f32(per_strand);
    inspected[PLACE] = vec4<f32>(place.xyz, near.depth);
    inspected[TANGENT] = vec4<f32>(along * inverseSqrt(max(dot(along, along), 1e-12)), t);
    inspected[STRAND] =
        vec4<f32>(bitcast<f32>(inspect_layer.layer), bitcast<f32>(segment / per_strand), near.distance, place.w);
}

@compute @workgroup_size(1)
fn read_pixel() {
    inspected[HAIR] = textureLoad(hair, inspect_layer.pixel, 0);
    inspected[BODY] = textureLoad(head_colour, inspect_layer.pixel, 0);
    inspected[DISPLAY] = textureLoad(shown, inspect_layer.pixel, 0);
}
