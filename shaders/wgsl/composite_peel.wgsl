// The layer that was peeled under those before it; then what the next layer needs.
#import lorelei::raster_frame::{raster}
#import lorelei::fragment::{band, depth_of, unfixed, unfixed_colour}

@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;
@group(0) @binding(auto) var<storage, read_write> nearest: array<u32>;
@group(0) @binding(auto) var<storage, read_write> peeled: array<f32>;
@group(0) @binding(auto) var<storage, read_write> sums: array<u32>;
// Premultiplied, of the layers so far.
@group(0) @binding(auto) var<storage, read_write> gathered: array<vec4<f32>>;
// Pixels in which this layer has something, and what the next layer's passes are dispatched with.
@group(0) @binding(auto) var<storage, read_write> n_peeled: atomic<u32>;

// Where so much is stopped, nothing behind it is seen.
const OPAQUE: f32 = 0.9995;
const NOTHING_BEHIND: f32 = 3e38;

@compute @workgroup_size(64)
fn composite(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let place = id.x + id.y * n_groups.x * 64u;
    let width = raster.view.size.x;
    if place >= band.n_rows * width {
        return;
    }
    let pixel = vec2<u32>(place % width, band.first_row + place / width);
    if nearest[place] == 0u {
        return;
    }
    let at = 4u * place;
    let alpha = unfixed(sums[at + 3u]);
    let colour = unfixed_colour(vec3<u32>(sums[at], sums[at + 1u], sums[at + 2u]));
    let before = gathered[place];
    let shown = (1.0 - before.w) / max(alpha, 1.0);
    let after = before + shown * vec4<f32>(colour, alpha);
    gathered[place] = after;
    textureStore(hair, pixel, after);
    peeled[place] = select(depth_of(nearest[place]), NOTHING_BEHIND, after.w > OPAQUE);
    nearest[place] = 0u;
    for (var k = 0u; k < 4u; k++) {
        sums[at + k] = 0u;
    }
    atomicAdd(&n_peeled, 1u);
}
