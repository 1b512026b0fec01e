// Outgoing radiance of every strand vertex, averaged over the fibre's width. Twin of render/src/shade.rs.
//
// Per vertex and not per pixel: a vertex is shaded once for all the pixels and lights that see it, and the
// rasteriser interpolates. 002 and 000 (line 776) say that it does not show where vertices are close.
#import lorelei::shade_layers::{fibres}
#import lorelei::shade_vertex::{shaded_vertex}

struct ShadeLayer {
    // Index in `fibres`.
    layer: u32,
}

@group(0) @binding(auto) var<uniform> shade_layer: ShadeLayer;
// Four half floats: linear radiance, and the fibre's opacity.
@group(0) @binding(auto) var<storage, read_write> radiance: array<vec2<u32>>;

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    let layer = shade_layer.layer;
    if item / fibres[layer].vertices_per_strand >= fibres[layer].n_strands {
        return;
    }
    radiance[fibres[layer].first_vertex + item] = shaded_vertex(layer, item);
}
