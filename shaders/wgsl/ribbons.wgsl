// Strips or lines in the order of a list, blended over each other from back to front.
#import lorelei::raster_frame::{raster}
#import lorelei::cover_of::{Cover, cover_of_ribbon, cover_of_line}
#import lorelei::fragment_of_strip::{fragment_of, owner_of}
#import lorelei::raster_frame::{raster_layers}
#import lorelei::ribbon_strip::{Corner, nowhere, strip_corner, line_end}
#import lorelei::strands::{vertices, offset_of}

// First vertices of segments from back to front, NOTHING where there is none: see ribbons_keys.wgsl.
@group(0) @binding(auto) var<storage, read> order: array<u32>;

const NOTHING: u32 = 0xFFFFFFFFu;

fn is_tip(vertex: u32) -> bool {
    for (var layer_idx = 0u; layer_idx < raster.n_layers; layer_idx++) {
        let layer = raster_layers[layer_idx];
        let idx = vertex - layer.first_vertex;
        if vertex >= layer.first_vertex && idx < layer.n_strands * layer.vertices_per_strand {
            return idx % layer.vertices_per_strand == layer.vertices_per_strand - 1u;
        }
    }
    return true;
}

@vertex
fn strip(@builtin(vertex_index) vertex_idx: u32) -> Corner {
    let a = order[vertex_idx / 6u];
    if a == NOTHING {
        return nowhere();
    }
    return strip_corner(raster.view, a, owner_of(a).y == 0u, is_tip(a + 1u), vertex_idx % 6u);
}

@vertex
fn line(@builtin(vertex_index) vertex_idx: u32) -> Corner {
    let a = order[vertex_idx / 2u];
    if a == NOTHING {
        return nowhere();
    }
    return line_end(raster.view, a, vertex_idx % 2u);
}

fn blended(in: Corner, pixel: vec2<u32>, cover: Cover) -> vec4<f32> {
    let segment_cm = distance(vertices[in.vertex].xyz, vertices[in.vertex + 1u].xyz);
    let h = offset_of(in.across, in.half_width);
    let fragment = fragment_of(in.vertex, in.t, h, segment_cm, pixel, in.depth, cover);
    return fragment.alpha * vec4<f32>(fragment.colour, 1.0);
}

@fragment
fn strip_fragment(in: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(in.position.xy);
    let slope = vec2<f32>(dpdx(in.across), dpdy(in.across));
    return blended(in, pixel, cover_of_ribbon(in.across, slope, in.half_width, pixel));
}

@fragment
fn line_fragment(in: Corner) -> @location(0) vec4<f32> {
    let pixel = vec2<u32>(in.position.xy);
    return blended(in, pixel, cover_of_line(in.half_width, pixel));
}
