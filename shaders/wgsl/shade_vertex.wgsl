// Outgoing radiance of a strand's vertex, averaged over the fibre's width, as a buffer holds it.
#define_import_path lorelei::shade_vertex
#import lorelei::scatter_tables::{set_footprint}
#import lorelei::shade_layers::{fibres}
#import lorelei::shade_point::{NO_OFFSET, shade_point}
#import lorelei::shade_lights::{scene}
#import lorelei::strands::{vertices, seeds}

// `item` counts the layer's vertices. Four half floats: linear radiance, and the fibre's opacity.
fn shaded_vertex(layer: u32, item: u32) -> vec2<u32> {
    let vertices_per_strand = fibres[layer].vertices_per_strand;
    let strand = item / vertices_per_strand;
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
    return vec2<u32>(pack2x16float(clipped.xy), pack2x16float(vec2<f32>(clipped.z, scene.opacity)));
}
