// What the fibres of every drawn layer are made of, and which layer a vertex belongs to. Twin of render/src/shade.rs,
// `LayerFibre`.
#define_import_path lorelei::shade_layers
#import lorelei::scatter_fibre::{Fibre}

// Strand `s` of the layer has the vertices from `first_vertex + s * vertices_per_strand`, and its seed at
// `first_strand + s`.
struct LayerFibre {
    fibre: Fibre,
    first_vertex: u32,
    first_strand: u32,
    n_strands: u32,
    vertices_per_strand: u32,
}

// One for each drawn layer, in the order of their vertices.
@group(0) @binding(auto) var<storage, read> fibres: array<LayerFibre>;

// The drawn layer that a vertex belongs to, for kernels that span layers. A groom has few.
fn layer_of_vertex(vertex: u32) -> u32 {
    var layer = 0u;
    for (var next = 1u; next < arrayLength(&fibres) && fibres[next].first_vertex <= vertex; next++) {
        layer = next;
    }
    return layer;
}
