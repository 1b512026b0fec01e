// False colours in place of the radiance of every strand vertex. Twin of render/src/false_colour.rs.
#import lorelei::view_colour::{colour}
#import lorelei::view_ramp::{light_of}

struct ViewLayer {
    first_vertex: u32,
    first_strand: u32,
    n_strands: u32,
    vertices_per_strand: u32,
}

@group(0) @binding(auto) var<uniform> view_layer: ViewLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Four half floats, as `shade` writes them.
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn paint(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    let strand = item / view_layer.vertices_per_strand;
    if strand >= view_layer.n_strands {
        return;
    }
    let along = item % view_layer.vertices_per_strand;
    let vertex = view_layer.first_vertex + item;
    let position = vertices[vertex].xyz;
    let before = vertices[vertex - min(along, 1u)].xyz;
    let after = vertices[vertex + min(view_layer.vertices_per_strand - 1u - along, 1u)].xyz;
    let along_strand = after - before;
    let tangent = along_strand * inverseSqrt(max(dot(along_strand, along_strand), 1e-12));
    let light = light_of(colour(view_layer.first_strand + strand, position, tangent));
    radiance[vertex] = vec2<u32>(pack2x16float(light.xy), pack2x16float(vec2<f32>(light.z, 1.0)));
}
