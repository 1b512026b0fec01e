// The geometry pass that all shadow maps are built by: one thread a segment, for each light stepping along the segment's
// longer axis over the texels of its map. What is done to a texel is the slot `shadow_sink`.
#import lorelei::shadow_map::{ShadowLight, shadow_params, shadow_lights, map_place, texel_index, front_depth}
#import lorelei::shadow_sink::{sink}

struct ShadowLayer {
    first_vertex: u32,
    n_segments: u32,
    vertices_per_strand: u32,
    // Width scale where only a share of the strands is drawn.
    width_scale: f32,
}

@group(0) @binding(auto) var<uniform> shadow_layer: ShadowLayer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
// What of the head each light sees.
@group(0) @binding(auto) var<storage, read> shadow_head: array<u32>;

// Centimetres behind the head's front from which hair is on the far side, and not lying on the skin.
const FAR_SIDE: f32 = 1.0;
// Texels.
const LONG: f32 = 32.0;

// Hair that the head hides from the light casts nothing that the head does not, but it would fall into the last layer and
// darken skin that lies in front of it.
fn is_hidden(at: u32, depth: f32) -> bool {
    return depth > front_depth(shadow_head[at]) + FAR_SIDE;
}

fn is_hidden_at(light_idx: u32, place: vec3<f32>) -> bool {
    return is_hidden(texel_index(light_idx, vec2<i32>(place.xy)), place.z);
}

fn deposit(light_idx: u32, texel: vec2<i32>, depth: f32, opacity: f32, may_be_hidden: bool) {
    let resolution = i32(shadow_params.resolution);
    if any(texel < vec2<i32>(0)) || any(texel >= vec2<i32>(resolution)) {
        return;
    }
    let at = texel_index(light_idx, texel);
    if may_be_hidden && is_hidden(at, depth) {
        return;
    }
    sink(light_idx, at, depth, opacity);
}

fn rasterise(light_idx: u32, light: ShadowLight, root: vec4<f32>, tip: vec4<f32>) {
    let map_root = map_place(light, root.xyz);
    let map_tip = map_place(light, tip.xyz);
    if map_root.w <= 0.0 || map_tip.w <= 0.0 {
        return;
    }
    // Most segments are hidden as a whole or not at all: their ends tell. The others ask for each texel, and so do long ones.
    let is_root_hidden = is_hidden_at(light_idx, map_root.xyz);
    let is_tip_hidden = is_hidden_at(light_idx, map_tip.xyz);
    if is_root_hidden && is_tip_hidden {
        return;
    }
    let may_be_hidden = is_root_hidden || is_tip_hidden || distance(map_root.xy, map_tip.xy) > LONG;
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
        deposit(light_idx, texel, mix(a.z, b.z, t), opacity, may_be_hidden);
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
