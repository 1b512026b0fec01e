// The mean of the pixels that were drawn for one.
#import lorelei::raster_frame::{raster}

@group(0) @binding(auto) var fine_hair: texture_2d<f32>;
@group(0) @binding(auto) var hair: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn downsample(@builtin(global_invocation_id) id: vec3<u32>) {
    let n = raster.supersampling;
    if any(id.xy >= raster.view.size / n) {
        return;
    }
    var sum = vec4<f32>(0.0);
    for (var y = 0u; y < n; y++) {
        for (var x = 0u; x < n; x++) {
            sum += textureLoad(fine_hair, id.xy * n + vec2<u32>(x, y), 0);
        }
    }
    textureStore(hair, id.xy, sum / f32(n * n));
}
