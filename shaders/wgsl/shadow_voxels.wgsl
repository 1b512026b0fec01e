// Slot `shadow`: one grid of hair for all lights, marched from a place towards each of them. Steps grow with the distance:
// what is near matters more, and most of the way out is empty.
// slot: shadow
// slot: shadow_others
#define_import_path lorelei::shadow_voxels
#import lorelei::shadow_map::{ShadowLight, shadow_params, shadow_lights, map_place}
#import lorelei::shadow_past_head::{is_unmapped, head_front, past_head_at, past_head_of, N_TAPS, disc_tap, blur_of}
#import lorelei::shadow_jitter::{place_hash}
#import lorelei::hash::{unit}
#import lorelei::shadow_voxel_grid::{N_WORDS}

@group(0) @binding(auto) var<storage, read> shadow_voxels: array<u32>;

// Where a cell's words begin; cells beyond the border are the border's, which is empty.
fn words_of(cell: vec3<i32>) -> u32 {
    let n = i32(shadow_params.n_voxels);
    let inside = clamp(cell, vec3<i32>(0), vec3<i32>(n - 1));
    return u32((inside.z * n + inside.y) * n + inside.x) * N_WORDS;
}

// What a centimetre of hair holds back of light along `direction`, at a place in cells, between eight of them. Strands
// with w of area, w sin^2 of it across the light, hold back sqrt(w w sin^2): exact where they are parallel, 4 % too much
// where they point anywhere.
fn extinction(at: vec3<f32>, direction: vec3<f32>) -> f32 {
    let corner = floor(at - 0.5);
    let f = at - 0.5 - corner;
    let cell = vec3<i32>(corner);
    var diagonal = vec3<f32>(0.0);
    var mixed = vec3<f32>(0.0);
    for (var z = 0; z < 2; z++) {
        for (var y = 0; y < 2; y++) {
            for (var x = 0; x < 2; x++) {
                let at_cell = words_of(cell + vec3<i32>(x, y, z));
                let a = unpack2x16float(shadow_voxels[at_cell]);
                let b = unpack2x16float(shadow_voxels[at_cell + 1u]);
                let c = unpack2x16float(shadow_voxels[at_cell + 2u]);
                let weight = select(1.0 - f.x, f.x, x == 1) * select(1.0 - f.y, f.y, y == 1) * select(1.0 - f.z, f.z, z == 1);
                diagonal += weight * vec3<f32>(a, b.x);
                mixed += weight * vec3<f32>(b.y, c);
            }
        }
    }
    let w = diagonal.x + diagonal.y + diagonal.z;
    let along = dot(direction * direction, diagonal) + 2.0 * dot(direction.xxy * direction.yzz, mixed);
    return sqrt(max(w * (w - along), 0.0));
}

// Optical depth from a place towards a light.
fn march(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = shadow_lights[light_idx].place;
    let towards = place.xyz - position * place.w;
    let distance = length(towards);
    let direction = towards / max(distance, 1e-6);
    // Out of the grid, in cells.
    let begin = (position - shadow_params.voxel_corner) * shadow_params.voxels_per_cm;
    let side = f32(shadow_params.n_voxels);
    let safe = select(direction, vec3<f32>(1e-6), abs(direction) < vec3<f32>(1e-6));
    let out = max((vec3<f32>(0.0) - begin) / safe, (vec3<f32>(side) - begin) / safe);
    var way = min(out.x, min(out.y, out.z));
    if place.w > 0.0 {
        way = min(way, distance * shadow_params.voxels_per_cm);
    }
    // What lies within half a cell is mostly the strand itself and its lock.
    let start = 0.5;
    way -= start;
    if way <= 0.0 {
        return 0.0;
    }
    let n = f32(shadow_params.n_steps);
    let thrown = shadow_params.jitter * (unit(place_hash(position, light_idx)) - 0.5);
    var tau = 0.0;
    for (var k = 0u; k < shadow_params.n_steps; k++) {
        // t = way u^2, dt = 2 way u du
        let u = (f32(k) + 0.5 + thrown) / n;
        let t = start + way * u * u;
        tau += extinction(begin + t * direction, direction) * 2.0 * way * u / n;
    }
    return shadow_params.density * tau / shadow_params.voxels_per_cm;
}

fn hair_depth(light_idx: u32, position: vec3<f32>) -> f32 {
    if shadow_lights[light_idx].casts == 0u {
        return 0.0;
    }
    return march(light_idx, position);
}

fn head_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    return past_head_of(light_idx, position);
}

// The grid's cells are softer than a light's edge: one march is enough.
fn light_visibility(light_idx: u32, position: vec3<f32>) -> f32 {
    let place = map_place(shadow_lights[light_idx], position);
    if is_unmapped(light_idx, place) {
        return 1.0;
    }
    let blur = blur_of(light_idx, place, head_front(light_idx, vec2<i32>(place.xy)));
    var past = 0.0;
    for (var tap = 0u; tap < N_TAPS; tap++) {
        past += past_head_at(light_idx, place.xy + blur * disc_tap(tap), place.z);
    }
    return exp(-march(light_idx, position)) * past / f32(N_TAPS);
}
