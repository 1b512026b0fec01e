// What the passes of all shadow techniques and their look-ups share. Twin of render/src/shadow/params.rs and camera.rs.
#define_import_path lorelei::shadow_map

struct ShadowLight {
    // World centimetres to (texel x * w, texel y * w, depth along the light's axis in cm, w); w is 1 for parallel light.
    map_from_world: mat4x4<f32>,
    // w 0: unit vector to a light at infinity. w 1: its place, cm.
    place: vec4<f32>,
    // Texels of one centimetre at w = 1.
    texels_per_cm: f32,
    // 0 where the light casts no shadow.
    casts: u32,
    // Depths between which everything lies, cm.
    near: f32,
    far: f32,
    // Radius of the blur of a shadow's edge for each centimetre between what casts and what receives it.
    softness: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

struct ShadowParams {
    // A multiple of 8.
    resolution: u32,
    n_lights: u32,
    // Parts of a texel's depth: layers, slices.
    n_parts: u32,
    // What becomes of hair behind the last layer: one of BEYOND_.
    beyond_last: u32,
    density: f32,
    filter_radius: f32,
    // Taps on a side of a look-up's window, and texels between them.
    n_taps: u32,
    tap_spacing: f32,
    // Texels or steps by which a look-up is thrown aside at most.
    jitter: f32,
    // cm
    bias: f32,
    // 1 / cm
    falloff: f32,
    // Share of the light.
    tolerance: f32,
    // Lower corner of the grid, cm.
    voxel_corner: vec3<f32>,
    voxels_per_cm: f32,
    n_voxels: u32,
    n_steps: u32,
    // Fragments that there is room for.
    n_fragments: u32,
    pad: u32,
    // Where the layers begin, cm behind the front: d_0 = 0, d_1, .. The last one's end is the one after it.
    layer_starts: array<vec4<f32>, 4>,
    // 1 / thickness of each.
    layer_rates: array<vec4<f32>, 4>,
}

const BEYOND_LAST_LAYER: u32 = 0u;
const BEYOND_IGNORE: u32 = 1u;
const BEYOND_GROW: u32 = 2u;

@group(0) @binding(auto) var<uniform> shadow_params: ShadowParams;
@group(0) @binding(auto) var<storage, read> shadow_lights: array<ShadowLight>;

// Optical depth 1 of a texel, where sums are atomic.
const FIXED_POINT: f32 = 65536.0;
// An optical depth that lets nothing through, of an occluder that is known to be one but not how dense it is.
const OPAQUE: f32 = 16.0;
// Depth of a front where there is no hair, cm.
const NO_HAIR: f32 = 1e30;

// (texel x, texel y, depth in cm, w)
fn map_place(light: ShadowLight, position: vec3<f32>) -> vec4<f32> {
    let q = light.map_from_world * vec4<f32>(position, 1.0);
    return vec4<f32>(q.xy / q.w, q.z, q.w);
}

// A texel's place in what holds one thing for each texel and light; beyond the border the border's. Squares of 8 x 8 texels
// lie together, and in them those of 2 x 2: strands run in all directions, and look-ups are between four texels.
fn texel_index(light_idx: u32, texel: vec2<i32>) -> u32 {
    let resolution = shadow_params.resolution;
    let at = vec2<u32>(clamp(texel, vec2<i32>(0), vec2<i32>(i32(resolution) - 1)));
    let square = (at.y / 8u) * (resolution / 8u) + at.x / 8u;
    let inside = (at.y % 8u / 2u) * 16u + (at.x % 8u / 2u) * 4u + (at.y % 2u) * 2u + at.x % 2u;
    return light_idx * resolution * resolution + square * 64u + inside;
}

// Bits of a front's depth: 0 is empty and the nearest is the largest.
fn front_bits(depth: f32) -> u32 {
    return ~bitcast<u32>(max(depth, 0.0));
}

fn front_depth(bits: u32) -> f32 {
    return select(bitcast<f32>(~bits), NO_HAIR, bits == 0u);
}

// Where layer k begins behind the front, cm; k may be the number of layers.
fn layer_start(k: u32) -> f32 {
    return shadow_params.layer_starts[k / 4u][k % 4u];
}

// Where a depth behind the front lies among the layers: k at the start of layer k, in between by depth, since there
// opacity grows with it; the number of layers at the end of the last one.
//
// All layers in turn and not a search: threads side by side then read the same numbers, and wait for none.
fn layer_of(behind: f32) -> f32 {
    var layer = 0.0;
    for (var k = 0u; k < shadow_params.n_parts; k++) {
        layer += saturate((behind - layer_start(k)) * shadow_params.layer_rates[k / 4u][k % 4u]);
    }
    return layer;
}
