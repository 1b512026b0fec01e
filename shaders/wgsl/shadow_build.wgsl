// Deep opacity maps (Yuksel and Keyser 2008) in compute: one thread a segment and light, stepping along the
// segment's longer axis. Pass 0 finds the front of the hair, pass 1 sums opacity behind it into layers.
#import lorelei::shadow_map::{ShadowLight, ShadowParams, FIXED_POINT, map_place, layer_of}

struct ShadowLayer {
    first_vertex: u32,
    n_segments: u32,
    vertices_per_strand: u32,
    // Width scale where only a share of the strands is drawn.
    width_scale: f32,
}

// 0: the front. 1: opacities.
override PASS: u32 = 0u;

@group(0) @binding(auto) var<uniform> shadow_params: ShadowParams;
@group(0) @binding(auto) var<uniform> shadow_layer: ShadowLayer;
@group(0) @binding(auto) var<storage, read> shadow_lights: array<ShadowLight>;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// Bits of the front's depth, inverted, so that 0 is empty and the nearest is the largest.
@group(0) @binding(auto) var<storage, read_write> shadow_front: array<atomic<u32>>;
// Opacity of each layer alone, fixed point; the layers of a texel side by side.
@group(0) @binding(auto) var<storage, read_write> shadow_opacity: array<atomic<u32>>;
// What of the head each light sees.
@group(0) @binding(auto) var shadow_head: texture_depth_2d_array;

// Centimetres behind the head's front from which hair is on the far side, and not lying on the skin.
const FAR_SIDE: f32 = 1.0;

fn deposit(light_idx: u32, texel: vec2<i32>, depth: f32, opacity: f32) {
    let resolution = i32(shadow_params.resolution);
    if any(texel < vec2<i32>(0)) || any(texel >= vec2<i32>(resolution)) {
        return;
    }
    // Hair that the head hides from the light casts nothing that the head does not, but it would fall into the last
    // layer and darken skin that lies in front of it.
    let head = mix(shadow_lights[light_idx].near, shadow_lights[light_idx].far, textureLoad(shadow_head, texel, light_idx, 0));
    if depth > head + FAR_SIDE && head < shadow_lights[light_idx].far {
        return;
    }
    let at = light_idx * shadow_params.resolution * shadow_params.resolution + u32(texel.y * resolution + texel.x);
    if PASS == 0u {
        atomicMax(&shadow_front[at], ~bitcast<u32>(max(depth, 0.0)));
    } else {
        let front = bitcast<f32>(~atomicLoad(&shadow_front[at]));
        let layer = layer_of(depth - front, shadow_params.layer_size, shadow_params.n_layers);
        let k = min(u32(layer), shadow_params.n_layers - 1u);
        atomicAdd(&shadow_opacity[at * shadow_params.n_layers + k], u32(opacity * FIXED_POINT + 0.5));
    }
}

fn rasterise(light_idx: u32, light: ShadowLight, root: vec4<f32>, tip: vec4<f32>) {
    let map_root = map_place(light, root.xyz);
    let map_tip = map_place(light, tip.xyz);
    if map_root.w <= 0.0 || map_tip.w <= 0.0 {
        return;
    }
    // Texel coordinates with the longer axis as x; .z is depth; width in texels beside it.
    var a = map_root.xyz;
    var b = map_tip.xyz;
    let width_scale = 2.0 * shadow_layer.width_scale * light.texels_per_cm;
    var width_a = width_scale * root.w / map_root.w;
    var width_b = width_scale * tip.w / map_tip.w;
    let is_steep = abs(b.y - a.y) > abs(b.x - a.x);
    if is_steep {
        a = a.yxz;
        b = b.yxz;
    }
    if a.x > b.x {
        let c = a;
        a = b;
        b = c;
        let width = width_a;
        width_a = width_b;
        width_b = width;
    }
    let run = b.x - a.x;
    if !(run > 1e-4) {
        return;
    }
    let slope = (b.y - a.y) / run;
    let length_per_column = sqrt(1.0 + slope * slope);
    let first = max(floor(a.x), 0.0);
    let last = min(floor(b.x), f32(shadow_params.resolution) - 1.0);
    for (var column = first; column <= last; column += 1.0) {
        let from_x = max(a.x, column);
        let covered = min(b.x, column + 1.0) - from_x;
        let t = (from_x + 0.5 * covered - a.x) / run;
        let y = floor(mix(a.y, b.y, t));
        let opacity = covered * length_per_column * mix(width_a, width_b, t);
        var texel = vec2<i32>(i32(column), i32(y));
        if is_steep {
            texel = texel.yx;
        }
        deposit(light_idx, texel, mix(a.z, b.z, t), opacity);
    }
}

@compute @workgroup_size(64)
fn build(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let segment = id.x + id.y * n_groups.x * 64u;
    if segment >= shadow_layer.n_segments {
        return;
    }
    let n_per_strand = shadow_layer.vertices_per_strand - 1u;
    let strand = segment / n_per_strand;
    let vertex = shadow_layer.first_vertex + strand * shadow_layer.vertices_per_strand + segment % n_per_strand;
    let root = vertices[vertex];
    let tip = vertices[vertex + 1u];
    for (var light_idx = 0u; light_idx < shadow_params.n_lights; light_idx++) {
        if shadow_lights[light_idx].casts != 0u {
            rasterise(light_idx, shadow_lights[light_idx], root, tip);
        }
    }
}
