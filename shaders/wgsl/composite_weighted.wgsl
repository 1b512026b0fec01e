// The mean colour of a pixel's fragments, as opaque as so many of their mean alpha are (Bavoil and Myers 2008).
#import lorelei::raster_frame::{raster}
#import lorelei::fragment::{band, unfixed, unfixed_colour}

@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;
@group(0) @binding(auto) var<storage, read> sums: array<u32>;

@compute @workgroup_size(64)
fn composite(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let place = id.x + id.y * n_groups.x * 64u;
    let width = raster.view.size.x;
    if place >= band.n_rows * width {
        return;
    }
    let pixel = vec2<u32>(place % width, band.first_row + place / width);
    let at = 5u * place;
    let n = f32(sums[at + 4u]);
    if n == 0.0 {
        return;
    }
    let alpha = unfixed(sums[at + 3u]);
    let colour = unfixed_colour(vec3<u32>(sums[at], sums[at + 1u], sums[at + 2u])) / max(alpha, 1e-6);
    let stopped = 1.0 - pow(1.0 - min(alpha / n, 1.0), n);
    textureStore(hair, pixel, stopped * vec4<f32>(colour, 1.0));
}
