// Hair as what slows the air: its mass and its momentum in every cell. Twin of sim/src/wind/hair.rs.
//
// One thread takes one vertex of a guide and gives the hair that it stands for to the eight cells around it, in whole
// numbers, so that the sums do not depend on the order.
#import lorelei::wind_grid::{grid, entry}

struct Hair {
    n_vertices: u32,
    // Guides that are taken: every `stride`-th.
    n_taken: u32,
    stride: u32,
    // Guides that a taken one stands for.
    each: f32,
    // 1 over the seconds since the positions before; 0 where there are none.
    per_sec: f32,
}

@group(0) @binding(auto) var<uniform> hair: Hair;
// Mass at each vertex of which the wind takes hold, g.
@group(0) @binding(auto) var<storage, read> windage: array<f32>;
@group(0) @binding(auto) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> positions_before: array<vec4<f32>>;
// Four a cell: mass, then momentum along x, y and z.
@group(0) @binding(auto) var<storage, read_write> hair_cells: array<atomic<i32>>;

const FASTEST = 2000.0;

fn is_sane(p: vec3<f32>) -> bool {
    return abs(p.x) < 1e5 && abs(p.y) < 1e5 && abs(p.z) < 1e5;
}

@compute @workgroup_size(64)
fn splat(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    if item >= hair.n_taken * hair.n_vertices {
        return;
    }
    let idx = item / hair.n_vertices * hair.stride * hair.n_vertices + item % hair.n_vertices;
    let p = positions[idx].xyz;
    let before = positions_before[idx].xyz;
    positions_before[idx] = vec4<f32>(p, 0.0);
    if !is_sane(p) {
        return;
    }
    var v = vec3<f32>(0.0);
    if is_sane(before) {
        v = clamp((p - before) * hair.per_sec, vec3<f32>(-FASTEST), vec3<f32>(FASTEST));
    }
    let mass_here = hair.each * windage[idx];
    let in_cells = (p - grid.min) / grid.cell - 0.5;
    let corner = floor(in_cells);
    let t = in_cells - corner;
    for (var i = 0u; i < 8u; i++) {
        let offset = vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u);
        let at = vec3<i32>(corner) + vec3<i32>(offset);
        if any(at < vec3<i32>(0)) || any(at >= vec3<i32>(i32(grid.n))) {
            continue;
        }
        let share = mix(1.0 - t, t, vec3<f32>(offset));
        let here = mass_here * share.x * share.y * share.z;
        let cell = 4u * entry(vec3<u32>(at));
        atomicAdd(&hair_cells[cell], i32(round(here * grid.mass_unit)));
        let momentum = vec3<i32>(round(here * v * grid.momentum_unit));
        atomicAdd(&hair_cells[cell + 1u], momentum.x);
        atomicAdd(&hair_cells[cell + 2u], momentum.y);
        atomicAdd(&hair_cells[cell + 3u], momentum.z);
    }
}
