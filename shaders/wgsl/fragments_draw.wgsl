// Every fragment of every strand to a sink: found by the graphics pipeline, as strips or as lines.
#import lorelei::raster_frame::{raster, segment_of, NO_VERTEX}
#import lorelei::cover_of::{Cover, cover_of_ribbon, cover_of_line}
#import lorelei::fragment::{band}
#import lorelei::fragment_of_strip::{fragment_of, owner_of}
#import lorelei::raster_frame::{raster_layers}
#import lorelei::ribbon_strip::{Corner, nowhere, strip_corner, line_end}
#import lorelei::strands::{vertices, offset_of}
#import lorelei::sink::{sink}

@vertex
fn strip(@builtin(vertex_index) vertex_idx: u32) -> Corner {
    let a = segment_of(vertex_idx / 6u);
    if a == NO_VERTEX {
        return nowhere();
    }
    let is_last = segment_of(vertex_idx / 6u + 1u) == NO_VERTEX;
    return strip_corner(raster.view, a, owner_of(a).y == 0u, is_last, vertex_idx % 6u);
}

@vertex
fn line(@builtin(vertex_index) vertex_idx: u32) -> Corner {
    let a = segment_of(vertex_idx / 2u);
    if a == NO_VERTEX {
        return nowhere();
    }
    return line_end(raster.view, a, vertex_idx % 2u);
}

@fragment
fn strip_fragment(in: Corner) {
    let pixel = vec2<u32>(in.position.xy);
    give(in, pixel, cover_of_ribbon(in.across, vec2<f32>(dpdx(in.across), dpdy(in.across)), in.half_width, pixel));
}

@fragment
fn line_fragment(in: Corner) {
    let pixel = vec2<u32>(in.position.xy);
    give(in, pixel, cover_of_line(in.half_width, pixel));
}

fn give(in: Corner, pixel: vec2<u32>, cover: Cover) {
    if cover.mask == 0u || pixel.y < band.first_row || pixel.y >= band.first_row + band.n_rows {
        return;
    }
    let segment_cm = distance(vertices[in.vertex].xyz, vertices[in.vertex + 1u].xyz);
    let h = offset_of(in.across, in.half_width);
    let fragment = fragment_of(in.vertex, in.t, h, segment_cm, pixel, in.depth, cover);
    if fragment.alpha > 0.0 {
        sink(fragment);
    }
}
