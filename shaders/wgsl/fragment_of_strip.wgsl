// A fragment from a segment and the pixel that it touches, whoever found the pixel.
#define_import_path lorelei::fragment_of_strip
#import lorelei::fragment::{Fragment, band}
#import lorelei::raster_frame::{raster, raster_layers}
#import lorelei::radiance::{segment_radiance, fibre_radiance}
#import lorelei::cover_of::{Cover}
#import lorelei::strands::{seeds}

// View depth in centimetres of the head, and the share of the pixel that it covers.
@group(0) @binding(auto) var head_depth: texture_2d<f32>;

// Whose vertex it is: the strand's index among all, and the vertex's in the strand.
fn owner_of(vertex: u32) -> vec2<u32> {
    for (var layer_idx = 0u; layer_idx < raster.n_layers; layer_idx++) {
        let layer = raster_layers[layer_idx];
        let idx = vertex - layer.first_vertex;
        if vertex >= layer.first_vertex && idx < layer.n_strands * layer.vertices_per_strand {
            return vec2<u32>(layer.first_strand + idx / layer.vertices_per_strand, idx % layer.vertices_per_strand);
        }
    }
    return vec2<u32>(0u);
}

// `t` along the segment, `across` its fibre (see strands.wgsl), `segment_cm` its length; alpha is 0 where the head hides it.
fn fragment_of(vertex: u32, t: f32, across: f32, segment_cm: f32, pixel: vec2<u32>, depth: f32, cover: Cover) -> Fragment {
    let fibre = fibre_radiance(segment_radiance(vertex), t, across);
    let surface = pixel / raster.supersampling;
    let head = textureLoad(head_depth, surface, 0);
    let open = select(1.0, 1.0 - head.y, depth > head.x);
    let owner = owner_of(vertex);
    var fragment: Fragment;
    fragment.place = (pixel.y - band.first_row) * raster.view.size.x + pixel.x;
    fragment.pixel = pixel;
    fragment.depth = depth;
    fragment.alpha = saturate(cover.area * fibre.w) * open;
    fragment.mask = cover.mask;
    fragment.colour = fibre.xyz;
    fragment.vertex = vertex;
    fragment.seed = seeds[owner.x].x;
    fragment.along = (f32(owner.y) + t) * segment_cm;
    return fragment;
}
