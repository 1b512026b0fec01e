// A tile's pixels, front to back: one thread a pixel, no barriers. Every thread walks the tile's list and stops when
// its pixel is opaque; all threads of a tile read the same segments, so that they come from the cache.
#import lorelei::camera::View
#import lorelei::coverage::strip_coverage

struct Tiles {
    n: vec2<u32>,
    reach: f32,
    capacity: u32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> tiles: Tiles;
@group(0) @binding(auto) var<storage, read> projected: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> radiance: array<vec2<u32>>;
// Where each slab's list ends.
@group(0) @binding(auto) var<storage, read> slabs: array<u32>;
// Where each tile's list begins.
@group(0) @binding(auto) var<storage, read> starts: array<u32>;
@group(0) @binding(auto) var<storage, read> list: array<u32>;
@group(0) @binding(auto) var head_depth: texture_2d<f32>;
@group(0) @binding(auto) var head_colour: texture_2d<f32>;
@group(0) @binding(auto) var picture: texture_storage_2d<rgba16float, write>;

override N_BUCKETS: u32 = 64u;
// 64 threads: a tile of 8x8 pixels. Twin of `TILE` in raster/mod.rs.
const TILE: u32 = 8u;

// What is left of the light when a pixel counts as opaque: half a step of an 8-bit display.
const OPAQUE: f32 = 0.002;

// A pixel's picture so far: premultiplied radiance and alpha, and the share of the light that still comes through.
var<private> gathered: vec4<f32>;
var<private> transmittance: f32;
// Share of the pixel that the head leaves open to what is behind it.
var<private> open: f32;

// Fragments that wait (radiance and alpha; negative alpha: behind the head), nearest first, until one comes that is farther: they mend the order within a slab.
var<private> depth_0: f32;
var<private> depth_1: f32;
var<private> depth_2: f32;
var<private> depth_3: f32;
var<private> waiting_0: vec4<f32>;
var<private> waiting_1: vec4<f32>;
var<private> waiting_2: vec4<f32>;
var<private> waiting_3: vec4<f32>;

fn composite(fragment: vec4<f32>) {
    let alpha = abs(fragment.a);
    let seen = transmittance * alpha * select(1.0, open, fragment.a < 0.0);
    gathered += seen * vec4<f32>(fragment.rgb, 1.0);
    transmittance *= 1.0 - alpha;
}

fn push(depth: f32, fragment: vec4<f32>) {
    if depth < depth_0 {
        composite(fragment);
        return;
    }
    composite(waiting_0);
    let before_1 = depth < depth_1;
    let before_2 = depth < depth_2;
    let before_3 = depth < depth_3;
    waiting_0 = select(waiting_1, fragment, before_1);
    depth_0 = select(depth_1, depth, before_1);
    waiting_1 = select(select(waiting_2, fragment, before_2), waiting_1, before_1);
    depth_1 = select(select(depth_2, depth, before_2), depth_1, before_1);
    waiting_2 = select(select(waiting_3, fragment, before_3), waiting_2, before_2);
    depth_2 = select(select(depth_3, depth, before_3), depth_2, before_2);
    waiting_3 = select(fragment, waiting_3, before_3);
    depth_3 = select(depth, depth_3, before_3);
}

struct Hit {
    // 0: the segment does not touch the pixel.
    coverage: f32,
    t: f32,
    depth: f32,
}

// The strip's overlap with the pixel, for pixels whose foot is on this segment and on no other.
fn hit(a: vec4<f32>, b: vec4<f32>, pixel: vec2<f32>) -> Hit {
    let step = b.xy - a.xy;
    let offset = pixel - a.xy;
    let squared = max(dot(step, step), 1e-12);
    let t = dot(offset, step) / squared;
    let normal = vec2<f32>(step.y, -step.x) * inverseSqrt(squared);
    let across = dot(offset, normal);
    let half_width = mix(a.w, b.w, t);
    if t < 0.0 || t >= 1.0 || abs(across) >= half_width + 0.7072 {
        return Hit(0.0, 0.0, 0.0);
    }
    return Hit(strip_coverage(across, half_width, normal), t, mix(a.z, b.z, t));
}

fn radiance_at(vertex_idx: u32, t: f32) -> vec4<f32> {
    let a = radiance[vertex_idx];
    let b = radiance[vertex_idx + 1u];
    let from_a = vec4<f32>(unpack2x16float(a.x), unpack2x16float(a.y));
    let from_b = vec4<f32>(unpack2x16float(b.x), unpack2x16float(b.y));
    return mix(from_a, from_b, t);
}

fn pixel_of(group: u32, local: u32) -> vec2<u32> {
    let tile = vec2<u32>(group % tiles.n.x, group / tiles.n.x);
    return tile * TILE + vec2<u32>(local % TILE, local / TILE);
}

@compute @workgroup_size(64)
fn front_to_back(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let tile_idx = group.x + group.y * n.x;
    let pixel = pixel_of(tile_idx, local);
    if tile_idx >= tiles.n.x * tiles.n.y || any(pixel >= view.size) {
        return;
    }
    let centre = vec2<f32>(pixel) + 0.5;
    let surface = textureLoad(head_depth, vec2<i32>(pixel), 0).x;
    open = 1.0 - textureLoad(head_colour, vec2<i32>(pixel), 0).a;
    gathered = vec4<f32>(0.0);
    transmittance = 1.0;
    depth_0 = -1.0;
    depth_1 = -1.0;
    depth_2 = -1.0;
    depth_3 = -1.0;
    waiting_0 = vec4<f32>(0.0);
    waiting_1 = vec4<f32>(0.0);
    waiting_2 = vec4<f32>(0.0);
    waiting_3 = vec4<f32>(0.0);
    let end = min(slabs[tile_idx * N_BUCKETS + N_BUCKETS - 1u], tiles.capacity);
    for (var i = starts[tile_idx]; i < end; i++) {
        let vertex_idx = list[i];
        let found = hit(projected[vertex_idx], projected[vertex_idx + 1u], centre);
        if found.coverage > 0.0 {
            var fragment = radiance_at(vertex_idx, found.t);
            fragment.a *= found.coverage * select(1.0, -1.0, found.depth > surface);
            push(found.depth, fragment);
            if transmittance < OPAQUE {
                break;
            }
        }
    }
    composite(waiting_0);
    composite(waiting_1);
    composite(waiting_2);
    composite(waiting_3);
    textureStore(picture, vec2<i32>(pixel), gathered);
}

@compute @workgroup_size(64)
fn nearest_only(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let tile_idx = group.x + group.y * n.x;
    let pixel = pixel_of(tile_idx, local);
    if tile_idx >= tiles.n.x * tiles.n.y || any(pixel >= view.size) {
        return;
    }
    let centre = vec2<f32>(pixel) + 0.5;
    let covered = textureLoad(head_colour, vec2<i32>(pixel), 0).a >= 0.5;
    let surface = select(1e30, textureLoad(head_depth, vec2<i32>(pixel), 0).x, covered);
    var depth = 1e30;
    var colour = vec4<f32>(0.0);
    var begin = starts[tile_idx];
    for (var slab_idx = 0u; slab_idx < N_BUCKETS; slab_idx++) {
        let end = min(slabs[tile_idx * N_BUCKETS + slab_idx], tiles.capacity);
        // One slab more than the one with the first hit: a long segment is filed under its middle.
        let done = colour.a > 0.0 && end > begin;
        for (var i = begin; i < end; i++) {
            let vertex_idx = list[i];
            let a = projected[vertex_idx];
            let b = projected[vertex_idx + 1u];
            let wide_a = vec4<f32>(a.xyz, max(a.w, 0.5));
            let found = hit(wide_a, vec4<f32>(b.xyz, max(b.w, 0.5)), centre);
            if found.coverage >= 0.5 && found.depth < min(depth, surface) {
                depth = found.depth;
                colour = vec4<f32>(radiance_at(vertex_idx, found.t).rgb, 1.0);
            }
        }
        begin = end;
        if done {
            break;
        }
    }
    textureStore(picture, vec2<i32>(pixel), colour);
}
