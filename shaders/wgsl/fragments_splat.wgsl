// Every fragment of every strand to a sink: a thread walks the pixels of a segment.
//
// For techniques that need all fragments, several times over, in any order. (raster_fine.wgsl, which stops where nothing
// shines through, is faster for what it does.)
#import lorelei::camera::{project}
#import lorelei::raster_frame::{raster, segment_of, NO_VERTEX}
#import lorelei::coverage::{strip_of}
#import lorelei::cover_of::{cover_of_strip}
#import lorelei::fragment::{band}
#import lorelei::fragment_of_strip::{fragment_of}
#import lorelei::sink::{sink}
#import lorelei::strands::{vertices, offset_of}

@compute @workgroup_size(64)
fn splat(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let vertex = segment_of(id.x + id.y * n_groups.x * 64u);
    if vertex == NO_VERTEX {
        return;
    }
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    let a = project(raster.view, root.xyz);
    let b = project(raster.view, tip.xyz);
    let offset = b.xy - a.xy;
    let length2 = dot(offset, offset);
    if min(a.z, b.z) <= raster.view.near || length2 < 1e-12 {
        return;
    }
    let u = offset * inverseSqrt(length2);
    let half_widths = vec2<f32>(root.w / a.z, tip.w / b.z) * raster.view.pixels_per_tangent;
    let strip = strip_of(u, sqrt(length2), half_widths);
    let segment_cm = distance(root.xyz, tip.xyz);

    // Compute the columns along the longer axis ("columns" are rows where it is steep) and the rows of each.
    let is_steep = abs(u.y) > abs(u.x);
    let v = select(u, u.yx, is_steep);
    let origin = select(a.xy, a.yx, is_steep);
    let low = select(vec2<i32>(0, i32(band.first_row)), vec2<i32>(i32(band.first_row), 0), is_steep);
    let size = vec2<i32>(i32(raster.view.size.x), i32(band.first_row + band.n_rows)) - 1;
    let high = select(size, size.yx, is_steep);
    let across = strip.half_width + strip.reach;
    let end = 0.5 * strip.a;
    let ends = v.x * vec2<f32>(-end, strip.length + end);
    let slack = across * abs(v.y);
    let first_column = max(i32(ceil(origin.x + min(ends.x, ends.y) - slack - 0.5)), low.x);
    let last_column = min(i32(floor(origin.x + max(ends.x, ends.y) + slack - 0.5)), high.x);
    let slope = v.y / v.x;
    let half_height = across / strip.a;
    for (var column = first_column; column <= last_column; column++) {
        let x = f32(column) + 0.5 - origin.x;
        let middle = origin.y + x * slope - 0.5;
        let first_row = max(i32(ceil(middle - half_height)), low.y);
        let last_row = min(i32(floor(middle + half_height)), high.y);
        for (var row = first_row; row <= last_row; row++) {
            let at = select(vec2<i32>(column, row), vec2<i32>(row, column), is_steep);
            let pixel = vec2<u32>(at);
            let offset_px = vec2<f32>(at) + 0.5 - a.xy;
            let place = vec2<f32>(dot(offset_px, u), offset_px.y * u.x - offset_px.x * u.y);
            let t = saturate(place.x * strip.per_length);
            let cover = cover_of_strip(strip, place, t, u, pixel);
            if cover.mask != 0u {
                let half_width = mix(strip.half_widths.x, strip.half_widths.y, t);
                let h = offset_of(place.y, half_width);
                let fragment = fragment_of(vertex, t, h, segment_cm, pixel, mix(a.z, b.z, t), cover);
                if fragment.alpha > 0.0 {
                    sink(fragment);
                }
            }
        }
    }
}
