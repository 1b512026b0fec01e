// Slot `sim_air`: the air of the grid. Twin of `AirGrid::air_velocity` in sim/src/wind/air.rs.
// slot: sim_air
#define_import_path lorelei::sim_air_grid

#import lorelei::wind_free::free_air

struct AirGrid {
    // Lower corner, world, cm.
    min: vec3<f32>,
    cell: f32,
    // Cells along a side; 0 where there is no grid.
    n: u32,
}

@group(0) @binding(auto) var<storage, read> air_grid: AirGrid;
// Velocity in the middle of every cell (n + 1 entries along each axis); w how open the cell is.
@group(0) @binding(auto) var<storage, read> air: array<vec4<f32>>;

// World, cm/s; outside of the grid the air that nothing stands in the way of.
fn air_velocity(p: vec3<f32>) -> vec3<f32> {
    let g = (p - air_grid.min) / air_grid.cell;
    let last = f32(air_grid.n);
    if air_grid.n == 0u || !(all(g >= vec3<f32>(0.0)) && all(g <= vec3<f32>(last))) {
        return free_air(p);
    }
    let inside = clamp(g - 0.5, vec3<f32>(0.0), vec3<f32>(last - 1.0));
    let corner = min(vec3<u32>(inside), vec3<u32>(air_grid.n - 2u));
    let t = inside - vec3<f32>(corner);
    let row = air_grid.n + 1u;
    let at = corner.x + row * (corner.y + row * corner.z);
    let z = at + row * row;
    let y0 = mix(mix(air[at].xyz, air[at + 1u].xyz, t.x), mix(air[at + row].xyz, air[at + row + 1u].xyz, t.x), t.y);
    let y1 = mix(mix(air[z].xyz, air[z + 1u].xyz, t.x), mix(air[z + row].xyz, air[z + row + 1u].xyz, t.x), t.y);
    return mix(y0, y1, t.z);
}
