// The mean of a pixel's samples, batch after batch.
#import lorelei::raster_frame::{raster}
#import lorelei::fragment::{band, unpack_colour}

@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;
@group(0) @binding(auto) var<storage, read_write> nearest: array<u32>;
@group(0) @binding(auto) var<storage, read_write> visible: array<u32>;
// Premultiplied, of the batches before.
@group(0) @binding(auto) var<storage, read_write> gathered: array<vec4<f32>>;

@compute @workgroup_size(64)
fn composite(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let place = id.x + id.y * n_groups.x * 64u;
    let width = raster.view.size.x;
    if place >= band.n_rows * width {
        return;
    }
    let pixel = vec2<u32>(place % width, band.first_row + place / width);
    var sum = gathered[place];
    for (var k = 0u; k < band.n_samples; k++) {
        let at = place * band.n_samples + k;
        if nearest[at] != 0u {
            sum += vec4<f32>(unpack_colour(visible[at]), 1.0);
        }
        // For the next batch.
        nearest[at] = 0u;
        visible[at] = 0u;
    }
    gathered[place] = sum;
    textureStore(hair, pixel, sum / f32(min(band.first_sample + band.n_samples, band.n_all_samples)));
}
