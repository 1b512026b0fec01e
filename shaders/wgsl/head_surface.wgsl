// What of the head each pixel sees: four samples, so that its outline is smooth. A group of threads draws a tile from its
// list of triangles; where the list found no room it goes through all of them.
#import lorelei::tile::{TILE}
#import lorelei::triangle::{Triangle, SEAM, shares_at}
#import lorelei::head_frame::{view, head_look, n_head_tiles}

// Three a vertex, head space: position, and 0 on skin to 1 on the scalp away from the hairline; normal, and 1 where maps
// are painted; place in a painted map.
@group(0) @binding(auto) var<storage, read> head_vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> head_indices: array<u32>;
@group(0) @binding(auto) var<storage, read> head_triangles: array<Triangle>;
@group(0) @binding(auto) var<storage, read> head_lists: array<u32>;
@group(0) @binding(auto) var<storage, read> head_entries: array<vec2<u32>>;
// A painted map; row 0 at v = 1.
@group(0) @binding(auto) var head_overlay: texture_2d<f32>;
// Mean view depth of the samples that hit the head, cm (NO_HEAD elsewhere); the share of them that do.
@group(0) @binding(auto) var head_depth: texture_storage_2d<rg32float, write>;
// World normal, and how much of the pixel is scalp; where a map is shown 0 off the scalp, 1 to 2 with its value. All four
// weighted with the share of the pixel.
@group(0) @binding(auto) var head_normal: texture_storage_2d<rgba16float, write>;
// Bits of the farthest depth in each of the rasteriser's tiles, 0 before the frame.
@group(0) @binding(auto) var<storage, read_write> tile_backs: array<atomic<u32>>;

const NO_HEAD: f32 = 1e30;
// The places that graphics pipelines take four samples of a pixel at, from its middle.
const SAMPLES_X: vec4<f32> = vec4<f32>(-0.125, 0.375, -0.375, 0.125);
const SAMPLES_Y: vec4<f32> = vec4<f32>(-0.375, -0.125, 0.125, 0.375);
const NONE: u32 = 0xFFFFFFFFu;

struct Hits {
    // 1 / depth of the nearest triangle at each sample, and which it is.
    per_depth: vec4<f32>,
    owners: vec4<u32>,
}

fn add_triangle(hits: ptr<function, Hits>, triangle_idx: u32, place: vec2<f32>) {
    let triangle = head_triangles[triangle_idx];
    let middle = shares_at(triangle, place);
    let a = middle.x + triangle.a.x * SAMPLES_X + triangle.a.y * SAMPLES_Y;
    let b = middle.y + triangle.b.x * SAMPLES_X + triangle.b.y * SAMPLES_Y;
    let c = middle.z + triangle.c.x * SAMPLES_X + triangle.c.y * SAMPLES_Y;
    let per_depth = a + b + c;
    // Where two are equally near the first one is seen, in whatever order they come.
    let is_nearer = (per_depth > (*hits).per_depth)
        | ((per_depth == (*hits).per_depth) & (vec4<u32>(triangle_idx) < (*hits).owners));
    let is_inside = min(min(a, b), c) >= -SEAM * per_depth;
    let is_hit = is_nearer & is_inside & (per_depth > vec4<f32>(0.0)) & (per_depth <= vec4<f32>(1.0 / view.near));
    (*hits).per_depth = select((*hits).per_depth, per_depth, is_hit);
    (*hits).owners = select((*hits).owners, vec4<u32>(triangle_idx), is_hit);
}

fn overlay_texel(at: vec2<i32>) -> f32 {
    let last = vec2<i32>(textureDimensions(head_overlay)) - 1;
    return textureLoad(head_overlay, clamp(at, vec2<i32>(0), last), 0).x;
}

// Bilinear, as ScalpMap::sample.
fn overlay_at(uv: vec2<f32>) -> f32 {
    let at = vec2<f32>(uv.x, 1.0 - uv.y) * vec2<f32>(textureDimensions(head_overlay)) - 0.5;
    let low = vec2<i32>(floor(at));
    let f = at - floor(at);
    let top = mix(overlay_texel(low), overlay_texel(low + vec2<i32>(1, 0)), f.x);
    let bottom = mix(overlay_texel(low + vec2<i32>(0, 1)), overlay_texel(low + vec2<i32>(1, 1)), f.x);
    return mix(top, bottom, f.y);
}

// World normal and scalp of a triangle at a place in pixels.
fn surface_at(triangle_idx: u32, place: vec2<f32>) -> vec4<f32> {
    var shares = shares_at(head_triangles[triangle_idx], place);
    shares = shares / (shares.x + shares.y + shares.z);
    let p = 3u * head_indices[3u * triangle_idx];
    let q = 3u * head_indices[3u * triangle_idx + 1u];
    let r = 3u * head_indices[3u * triangle_idx + 2u];
    let of_normal = shares.x * head_vertices[p + 1u] + shares.y * head_vertices[q + 1u] + shares.z * head_vertices[r + 1u];
    let normal = normalize((head_look.world_from_head * vec4<f32>(of_normal.xyz, 0.0)).xyz);
    if head_look.overlay > 0.0 {
        let map = shares.x * head_vertices[p + 2u] + shares.y * head_vertices[q + 2u] + shares.z * head_vertices[r + 2u];
        let value = saturate(head_look.overlay * overlay_at(map.xy));
        return vec4<f32>(normal, select(0.0, 1.0 + value, of_normal.w > 0.999));
    }
    return vec4<f32>(normal, shares.x * head_vertices[p].w + shares.y * head_vertices[q].w + shares.z * head_vertices[r].w);
}

@compute @workgroup_size(8, 8)
fn surface(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) tile: vec3<u32>) {
    let place = vec2<f32>(id.xy) + 0.5;
    var hits = Hits(vec4<f32>(0.0), vec4<u32>(NONE));
    if head_look.n_triangles > 0u {
        let list = 1u + 2u * (tile.y * n_head_tiles(TILE).x + tile.x);
        if head_lists[list + 1u] == 0u {
            var next = head_lists[list];
            while next > 0u {
                let entry = head_entries[next - 1u];
                add_triangle(&hits, entry.x, place);
                next = entry.y;
            }
        } else {
            for (var k = 0u; k < head_look.n_triangles; k++) {
                add_triangle(&hits, k, place);
            }
        }
    }
    if any(id.xy >= view.size) {
        return;
    }
    var depth = 0.0;
    var n_hit = 0.0;
    var sum = vec4<f32>(0.0);
    for (var k = 0u; k < 4u; k++) {
        if hits.owners[k] != NONE {
            depth += 1.0 / hits.per_depth[k];
            n_hit += 1.0;
            sum += surface_at(hits.owners[k], place + vec2<f32>(SAMPLES_X[k], SAMPLES_Y[k]));
        }
    }
    depth = select(NO_HEAD, depth / max(n_hit, 1.0), n_hit > 0.0);
    textureStore(head_depth, id.xy, vec4<f32>(depth, 0.25 * n_hit, 0.0, 0.0));
    textureStore(head_normal, id.xy, 0.25 * sum);
    let back = bitcast<u32>(select(NO_HEAD, depth, n_hit == 4.0));
    let n = head_look.supersampling;
    let n_columns = (view.size.x * n + u32(TILE) - 1u) / u32(TILE);
    let first = id.xy * n / u32(TILE);
    let last = (id.xy * n + n - 1u) / u32(TILE);
    for (var row = first.y; row <= last.y; row++) {
        for (var column = first.x; column <= last.x; column++) {
            let tile_idx = row * n_columns + column;
            if back > atomicLoad(&tile_backs[tile_idx]) {
                atomicMax(&tile_backs[tile_idx], back);
            }
        }
    }
}
