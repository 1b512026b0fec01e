// The grid of air and where its numbers lie: twin of sim/src/wind/grid.rs.
//
// Cells are cubes; speeds lie on their faces (Harlow and Welch 1965): of cell c, x, y and z of `faces` are the speeds
// through its three lower faces. Every buffer has n + 1 entries along each axis, so that the upper faces of the last
// cells have a place too.
#define_import_path lorelei::wind_grid

#import lorelei::sim_pose::Pose

struct Grid {
    // Lower corner now, world, cm.
    min: vec3<f32>,
    cell: f32,
    // Lower corner at the step before.
    min_before: vec3<f32>,
    dt_secs: f32,
    // Cells along a side.
    n: u32,
    // 1: the air goes around head and colliders.
    obstacle: u32,
    // Rate at which a gram of hair in a cubic centimetre of air slows it, cm3/(g s).
    hair_drag: f32,
    vorticity: f32,
    // Fixed-point units of a gram of hair, and of one times cm/s.
    mass_unit: f32,
    momentum_unit: f32,
    world_from_head: Pose,
    world_from_head_before: Pose,
}

@group(0) @binding(auto) var<uniform> grid: Grid;

// No air is faster, cm/s.
const MAX_SPEED: f32 = 10000.0;

// Of a cell, or of the faces below it.
fn entry(c: vec3<u32>) -> u32 {
    return c.x + (grid.n + 1u) * (c.y + (grid.n + 1u) * c.z);
}

fn unit(axis: u32) -> vec3<f32> {
    return select(vec3<f32>(0.0), vec3<f32>(1.0), vec3<u32>(0u, 1u, 2u) == vec3<u32>(axis));
}

fn step_of(axis: u32) -> vec3<u32> {
    return select(vec3<u32>(0u), vec3<u32>(1u), vec3<u32>(0u, 1u, 2u) == vec3<u32>(axis));
}

// Of item of side^3, x fastest.
fn item_cell(item: u32, side: u32) -> vec3<u32> {
    return vec3<u32>(item % side, (item / side) % side, item / (side * side));
}
