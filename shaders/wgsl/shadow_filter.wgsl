// From the layers of each texel to what a look-up wants: the front of the neighbourhood and, at each layer's end, the
// optical depth averaged over the neighbourhood. Filtering here costs a texel's work once; filtering in the look-up
// would cost it for every vertex and light.
#import lorelei::shadow_map::{shadow_params, FIXED_POINT, NO_HAIR, layer_start, texel_index}
#import lorelei::shadow_layers::{n_filtered}

@group(0) @binding(auto) var<storage, read> shadow_front: array<u32>;
@group(0) @binding(auto) var<storage, read> shadow_opacity: array<u32>;
#ifdef GROWS
// Bits of the farthest depth.
@group(0) @binding(auto) var<storage, read> shadow_back: array<u32>;
#endif
// See shadow_layers.wgsl.
@group(0) @binding(auto) var<storage, read_write> shadow_filtered: array<u32>;

// Known when the pipeline is made: loops over layers unroll, and what they index stays in registers.
override N_LAYERS: u32 = 4u;
#ifdef GROWS
const N_GROWN: u32 = 1u;
#else
const N_GROWN: u32 = 0u;
#endif
// Half floats end at 65,504.
const HALF_MOST: f32 = 60000.0;

@compute @workgroup_size(8, 8)
fn filter_map(@builtin(global_invocation_id) id: vec3<u32>) {
    let resolution = i32(shadow_params.resolution);
    if id.x >= shadow_params.resolution || id.y >= shadow_params.resolution {
        return;
    }
    let out = texel_index(id.z, vec2<i32>(id.xy)) * n_filtered();
    // A tap a whole radius and a half away has no weight.
    let reach = i32(ceil(shadow_params.filter_radius));
    let from_texel = max(vec2<i32>(id.xy) - reach, vec2<i32>(0));
    let to_texel = min(vec2<i32>(id.xy) + reach, vec2<i32>(resolution - 1));

    // 0 is empty and the nearest is the largest.
    var nearest = 0u;
    var farthest = 0u;
    for (var y = from_texel.y; y <= to_texel.y; y++) {
        for (var x = from_texel.x; x <= to_texel.x; x++) {
            let tap = texel_index(id.z, vec2<i32>(x, y));
            nearest = max(nearest, shadow_front[tap]);
#ifdef GROWS
            farthest = max(farthest, shadow_back[tap]);
#endif
        }
    }
    if nearest == 0u {
        shadow_filtered[out] = bitcast<u32>(NO_HAIR);
        for (var k = 1u; k < n_filtered(); k++) {
            shadow_filtered[out + k] = 0u;
        }
        return;
    }
    let front = bitcast<f32>(~nearest);

    var sums = array<f32, 18>();
    var weights = 0.0;
    let tent = 1.0 / (shadow_params.filter_radius + 0.5);
    for (var y = from_texel.y; y <= to_texel.y; y++) {
        for (var x = from_texel.x; x <= to_texel.x; x++) {
            let offset = abs(vec2<f32>(f32(x - i32(id.x)), f32(y - i32(id.y))));
            let weight = max(1.0 - offset.x * tent, 0.0) * max(1.0 - offset.y * tent, 0.0);
            weights += weight;
            let tap = texel_index(id.z, vec2<i32>(x, y));
            if shadow_front[tap] == 0u {
                continue;
            }
            // The neighbourhood's front is at or before the tap's own: a layer's end is there less deep, and may be in any
            // of the layers before.
            let step_back = bitcast<f32>(~shadow_front[tap]) - front;
            var above = 0.0;
            for (var k = 1u; k < N_LAYERS; k++) {
                let inside = f32(shadow_opacity[tap * N_LAYERS + k - 1u]) / FIXED_POINT;
                let share = 1.0 - step_back / (layer_start(k) - layer_start(k - 1u));
                sums[k] += weight * max(above + inside * share, 0.0);
                above += inside;
            }
            above += f32(shadow_opacity[tap * N_LAYERS + N_LAYERS - 1u]) / FIXED_POINT;
            sums[N_LAYERS] += weight * above;
        }
    }
    for (var k = 1u; k <= N_LAYERS; k++) {
        sums[k] = min(sums[k] / weights, HALF_MOST);
    }
#ifdef GROWS
    sums[N_LAYERS + 1u] = max(bitcast<f32>(farthest) - front, layer_start(N_LAYERS));
#endif
    shadow_filtered[out] = bitcast<u32>(front);
    for (var k = 1u; k <= N_LAYERS + N_GROWN; k += 2u) {
        shadow_filtered[out + (k + 1u) / 2u] = pack2x16float(vec2<f32>(sums[k], sums[k + 1u]));
    }
}
