// The nearest few fragments one by one, and the tail behind them.
#import lorelei::raster_frame::{raster}
#import lorelei::fragment::{band, unfixed, unfixed_colour, unpack_colour}

@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;
#import lorelei::slabs::{N_SLABS}
@group(0) @binding(auto) var<storage, read> kept: array<u32>;
@group(0) @binding(auto) var<storage, read> slabs: array<u32>;
@group(0) @binding(auto) var<storage, read> sums: array<u32>;

@compute @workgroup_size(64)
fn composite(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let place = id.x + id.y * n_groups.x * 64u;
    let width = raster.view.size.x;
    if place >= band.n_rows * width {
        return;
    }
    let pixel = vec2<u32>(place % width, band.first_row + place / width);
    var seen = vec4<f32>(0.0);
    for (var k = 0u; k < band.n_nearest; k++) {
        let at = 2u * (place * band.n_nearest + k);
        let alpha = min(unfixed(kept[at]), 1.0);
        seen += (1.0 - seen.w) * alpha * vec4<f32>(unpack_colour(kept[at + 1u]), 1.0);
    }
    var optical = 0.0;
    for (var k = 0u; k < N_SLABS; k++) {
        optical += unfixed(slabs[place * N_SLABS + k]);
    }
    let at = 4u * place;
    let weight = unfixed(sums[at + 3u]);
    if weight > 0.0 {
        let colour = unfixed_colour(vec3<u32>(sums[at], sums[at + 1u], sums[at + 2u])) / weight;
        seen += (1.0 - seen.w) * (1.0 - exp(-optical)) * vec4<f32>(colour, 1.0);
    }
    if seen.w > 0.0 {
        textureStore(hair, pixel, seen);
    }
}
