// The weighted fragments of a pixel, as opaque together as they must be. 001, section 3.4.
//
// The paper's text multiplies by alpha over the exact sum; it is the other way round that makes the sums agree.
#import lorelei::raster_frame::{raster}
#import lorelei::fragment::{band, unfixed, unfixed_colour}

@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;
@group(0) @binding(auto) var<storage, read> occupied: array<u32>;
@group(0) @binding(auto) var<storage, read> sums: array<u32>;

@compute @workgroup_size(64)
fn composite(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let place = id.x + id.y * n_groups.x * 64u;
    let width = raster.view.size.x;
    if place >= band.n_rows * width {
        return;
    }
    let pixel = vec2<u32>(place % width, band.first_row + place / width);
    let at = 4u * place;
    let weight = unfixed(sums[at + 3u]);
    if weight == 0.0 {
        return;
    }
    let stopped = 1.0 - exp(-unfixed(occupied[9u * place + 8u]));
    let colour = unfixed_colour(vec3<u32>(sums[at], sums[at + 1u], sums[at + 2u])) / weight;
    textureStore(hair, pixel, stopped * vec4<f32>(colour, 1.0));
}
