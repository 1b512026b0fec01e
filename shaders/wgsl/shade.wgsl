// Outgoing radiance of every strand vertex, averaged over the fibre's width. Twin of render/src/shade.rs.
//
// Per vertex and not per pixel: a vertex is shaded once for all the pixels and lights that see it, and the
// rasteriser interpolates. 002 and 000 (line 776) say that it does not show where vertices are close.
#import lorelei::scatter_tables::{set_footprint}
#import lorelei::shade_layers::{fibres}
#import lorelei::shade_point::{NO_OFFSET, shade_point}
#import lorelei::shade_lights::{scene}

struct ShadeLayer {
    // Index in `fibres`.
    layer: u32,
}

@group(0) @binding(auto) var<uniform> shade_layer: ShadeLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> seeds: array<u32>;
// Four half floats: linear radiance, and the fibre's opacity.
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    let layer = shade_layer.layer;
    let vertices_per_strand = fibres[layer].vertices_per_strand;
    let strand = item / vertices_per_strand;
    if strand >= fibres[layer].n_strands {
        return;
    }
    let along = item % vertices_per_strand;
    let vertex = fibres[layer].first_vertex + item;
    let position = vertices[vertex].xyz;
    let before = vertices[vertex - min(along, 1u)].xyz;
    let after = vertices[vertex + min(vertices_per_strand - 1u - along, 1u)].xyz;
    let along_strand = after - before;
    let tangent = along_strand * inverseSqrt(max(dot(along_strand, along_strand), 1e-12));

    // What turns within a vertex' share of the strand is averaged: half of the angle between its two segments.
    let turn = cross(position - before, after - position);
    let lengths = length(position - before) * length(after - position);
    set_footprint(0.5 * length(turn) / max(lengths, 1e-12));

    let t = f32(along) / f32(vertices_per_strand - 1u);
    let seed = seeds[fibres[layer].first_strand + strand];
    let l = shade_point(fibres[layer].fibre, seed, t, position, tangent, NO_OFFSET);

    // Half floats end at 65,504.
    let clipped = min(l, vec3<f32>(60000.0));
    radiance[vertex] = vec2<u32>(pack2x16float(clipped.xy), pack2x16float(vec2<f32>(clipped.z, scene.opacity)));
}
