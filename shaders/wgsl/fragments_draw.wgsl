// Every fragment of every strand to a sink: found by the graphics pipeline, as strips or as lines.
#import lorelei::raster_frame::{raster, segment_of, NO_VERTEX}
#import lorelei::cover::{N_SAMPLES, sample_offset, settled, samples_of}
#import lorelei::fragment::{band}
#import lorelei::fragment_of_strip::{fragment_of, dither_of, owner_of}
#import lorelei::raster_frame::{raster_layers}
#import lorelei::ribbon_strip::{Corner, strip_corner, line_end}
#import lorelei::strands::{vertices, offset_of}
#import lorelei::sink::{sink}

fn nowhere() -> Corner {
    var out: Corner;
    out.position = vec4<f32>(2.0, 2.0, 2.0, 1.0);
    return out;
}

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

// A strip's share of a box as wide as a pixel, across it.
fn strip_area(across: f32, half_width: f32) -> f32 {
    return clamp(min(across + 0.5, half_width) - max(across - 0.5, -half_width), 0.0, 1.0);
}

@fragment
fn strip_fragment(in: Corner) {
    let slope = vec2<f32>(dpdx(in.across), dpdy(in.across));
    let pixel = vec2<u32>(in.position.xy);
    var area = 0.0;
    var mask = 0u;
    if N_SAMPLES == 0u {
        area = settled(strip_area(in.across, in.half_width), dither_of(pixel));
        mask = samples_of(area);
    } else {
        for (var k = 0u; k < N_SAMPLES; k++) {
            let sampled = in.across + dot(slope, sample_offset(k));
            mask |= select(0u, 1u << k, abs(sampled) <= in.half_width);
        }
        area = f32(countOneBits(mask)) / f32(max(N_SAMPLES, 1u));
    }
    give(in, pixel, area, mask);
}

@fragment
fn line_fragment(in: Corner) {
    let pixel = vec2<u32>(in.position.xy);
    // A line has no edges to sample: its width is its alpha.
    let area = settled(saturate(2.0 * in.half_width), dither_of(pixel));
    let mask = select(samples_of(area), (1u << max(N_SAMPLES, 1u)) - 1u, N_SAMPLES > 0u);
    give(in, pixel, area, mask);
}

fn give(in: Corner, pixel: vec2<u32>, area: f32, mask: u32) {
    if mask == 0u || pixel.y < band.first_row || pixel.y >= band.first_row + band.n_rows {
        return;
    }
    let segment_cm = distance(vertices[in.vertex].xyz, vertices[in.vertex + 1u].xyz);
    let h = offset_of(in.across, in.half_width);
    let fragment = fragment_of(in.vertex, in.t, h, segment_cm, pixel, in.depth, area, mask);
    if fragment.alpha > 0.0 {
        sink(fragment);
    }
}
