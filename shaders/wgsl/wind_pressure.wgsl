// The pressure that leaves the air without divergence: multigrid. Twin of sim/src/wind/pressure.rs, function by
// function; that file says why.
#import lorelei::wind_grid::{grid, entry, item_cell, step_of}

struct Levels {
    // Cells along a side, and the first entry, of every level; the finest first.
    table: array<vec4<u32>, 8>,
    // The level of this dispatch.
    level: u32,
    n_levels: u32,
}

@group(0) @binding(auto) var<uniform> levels: Levels;
// What a difference of pressure does to the speed through each lower face, level after level.
@group(0) @binding(auto) var<storage, read_write> openness: array<vec4<f32>>;
// Right side (x) and the inverse of the diagonal (y, 0 where no air is), level after level.
@group(0) @binding(auto) var<storage, read_write> equations: array<vec2<f32>>;
// cm/s: times the step over density and cell it would be one.
@group(0) @binding(auto) var<storage, read_write> pressure: array<f32>;
@group(0) @binding(auto) var<storage, read_write> predicted: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> faces: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> air: array<vec4<f32>>;

const LEAST_DIAGONAL = 1e-5;
const N_COARSE_SWEEPS = 2u;
const N_COARSEST_SWEEPS = 8u;
// Threads of the workgroup that solves all coarse levels.
#ifdef LARGE_WORKGROUPS
const N_THREADS = 1024u;
#else
const N_THREADS = 256u;
#endif

override COLOUR: u32 = 0u;

// Of each thread that takes an eighth of a coarse cell: what is left of a fine cell's equation, how open a face is.
var<workgroup> left_of: array<f32, N_THREADS>;
var<workgroup> open_of: array<f32, N_THREADS>;

fn n_of(level: u32) -> u32 {
    return levels.table[level].x;
}

fn at_level(level: u32, c: vec3<u32>) -> u32 {
    let side = n_of(level) + 1u;
    return levels.table[level].y + c.x + side * (c.y + side * c.z);
}

// The neighbours' pressures, each times how open the face between is. Outside there is none.
fn pull_of_neighbours(level: u32, c: vec3<u32>) -> f32 {
    let n = n_of(level);
    let row = n + 1u;
    let slab = row * row;
    let at = at_level(level, c);
    let low = openness[at];
    var sum = 0.0;
    if c.x > 0u {
        sum += low.x * pressure[at - 1u];
    }
    if c.x + 1u < n {
        sum += openness[at + 1u].x * pressure[at + 1u];
    }
    if c.y > 0u {
        sum += low.y * pressure[at - row];
    }
    if c.y + 1u < n {
        sum += openness[at + row].y * pressure[at + row];
    }
    if c.z > 0u {
        sum += low.z * pressure[at - slab];
    }
    if c.z + 1u < n {
        sum += openness[at + slab].z * pressure[at + slab];
    }
    return sum;
}

fn inverse_diagonal(low: vec3<f32>, high: vec3<f32>) -> f32 {
    let diagonal = low.x + high.x + low.y + high.y + low.z + high.z;
    if diagonal < LEAST_DIAGONAL {
        return 0.0;
    }
    return 1.0 / diagonal;
}

// One step of Gauss and Seidel.
fn relax(level: u32, c: vec3<u32>) {
    let at = at_level(level, c);
    let equation = equations[at];
    pressure[at] = (equation.x + pull_of_neighbours(level, c)) * equation.y;
}

fn residual(level: u32, c: vec3<u32>) -> f32 {
    let at = at_level(level, c);
    let equation = equations[at];
    if equation.y == 0.0 {
        return 0.0;
    }
    return equation.x + pull_of_neighbours(level, c) - pressure[at] / equation.y;
}

fn mean_openness(level: u32, c: vec3<u32>, axis: u32) -> f32 {
    let side = n_of(level) + 1u;
    var a = side;
    var b = side * side;
    if axis == 1u {
        a = 1u;
    }
    if axis == 2u {
        a = 1u;
        b = side;
    }
    let at = at_level(level, c);
    let mean =
        0.25 * (openness[at][axis] + openness[at + a][axis] + openness[at + b][axis] + openness[at + a + b][axis]);
    let is_outer = c[axis] == 0u || c[axis] == n_of(level);
    return select(mean, 2.0 * mean / (1.0 + 0.5 * mean), is_outer);
}

// What is left of the equations of `level`, as those of a coarser cell: eight threads that follow each other take an item, one
// fine cell each and six of them a face. All threads of a workgroup come here together.
fn restrict_to(level: u32, item: u32, thread: u32) {
    let n = n_of(level + 1u);
    let c = item_cell(item, n);
    let is_here = c.z < n;
    let part = thread % 8u;
    if is_here {
        let fine = 2u * c;
        left_of[thread] = residual(level, fine + vec3<u32>(part & 1u, (part >> 1u) & 1u, part >> 2u));
        let axis = part % 3u;
        let is_high = part >= 3u;
        if part < 6u {
            let open = mean_openness(level, fine + select(0u, 2u, is_high) * step_of(axis), axis);
            open_of[thread] = open;
            let next = c + step_of(axis);
            if is_high && next[axis] == n {
                openness[at_level(level + 1u, next)][axis] = open;
            }
        }
    }
    workgroupBarrier();
    if is_here && part == 0u {
        var left = 0.0;
        for (var i = 0u; i < 8u; i++) {
            left += left_of[thread + i];
        }
        let low = vec3<f32>(open_of[thread], open_of[thread + 1u], open_of[thread + 2u]);
        let high = vec3<f32>(open_of[thread + 3u], open_of[thread + 4u], open_of[thread + 5u]);
        let at = at_level(level + 1u, c);
        openness[at] = vec4<f32>(low, 0.0);
        equations[at] = vec2<f32>(0.5 * left, inverse_diagonal(low, high));
        pressure[at] = 0.0;
    }
    workgroupBarrier();
}

// Add the coarser level's pressure, interpolated from where there is air.
fn prolong(level: u32, c: vec3<u32>) {
    let at = at_level(level, c);
    if equations[at].y == 0.0 {
        return;
    }
    let n = i32(n_of(level + 1u));
    let near = vec3<i32>(c / 2u);
    let towards = vec3<i32>(c % 2u) * 2 - 1;
    var sum = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < 8u; i++) {
        let offset = vec3<i32>(i32(i & 1u), i32((i >> 1u) & 1u), i32(i >> 2u));
        let neighbour = near + offset * towards;
        let share = mix(vec3<f32>(0.75), vec3<f32>(0.25), vec3<f32>(offset));
        var weight = share.x * share.y * share.z;
        let inside = clamp(neighbour, vec3<i32>(0), vec3<i32>(n - 1));
        let from_cell = at_level(level + 1u, vec3<u32>(inside));
        if equations[from_cell].y > 0.0 {
            weights += weight;
            // Beyond the boundary the pressure goes on through 0 where it is open, and as it is where it is closed.
            for (var axis = 0u; axis < 3u; axis++) {
                if neighbour[axis] < 0 {
                    weight *= 1.0 - openness[from_cell][axis];
                }
                if neighbour[axis] >= n {
                    let last = at_level(level + 1u, vec3<u32>(inside) + step_of(axis));
                    weight *= 1.0 - openness[last][axis];
                }
            }
            sum += weight * pressure[from_cell];
        }
    }
    if weights > 0.0 {
        pressure[at] += sum / weights;
    }
}

// Of one colour of a level: item of n * n * ceil(n / 2).
fn item_coloured(item: u32, n: u32, colour: u32) -> vec3<u32> {
    let pairs = (n + 1u) / 2u;
    let y = (item / pairs) % n;
    let z = item / (pairs * n);
    return vec3<u32>(2u * (item % pairs) + ((y + z + colour) & 1u), y, z);
}

// The equations of the finest level.
@compute @workgroup_size(64)
fn begin(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let c = item_cell(id.x + id.y * n_groups.x * 64u, grid.n);
    if c.z >= grid.n {
        return;
    }
    let row = grid.n + 1u;
    let at = entry(c);
    let low = predicted[at].xyz;
    let high = vec3<f32>(predicted[at + 1u].x, predicted[at + row].y, predicted[at + row * row].z);
    let open_low = openness[at].xyz;
    let open_high = vec3<f32>(openness[at + 1u].x, openness[at + row].y, openness[at + row * row].z);
    let divergence = high.x - low.x + high.y - low.y + high.z - low.z;
    equations[at] = vec2<f32>(-divergence, inverse_diagonal(open_low, open_high));
}

@compute @workgroup_size(64)
fn sweep(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let n = n_of(levels.level);
    let c = item_coloured(id.x + id.y * n_groups.x * 64u, n, COLOUR);
    if c.x < n && c.z < n {
        relax(levels.level, c);
    }
}

// To the level below this one.
@compute @workgroup_size(64)
fn coarsen(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) n_groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    restrict_to(levels.level, (id.x + id.y * n_groups.x * 64u) / 8u, thread);
}

// From the level below this one.
@compute @workgroup_size(64)
fn refine(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let n = n_of(levels.level);
    let c = item_cell(id.x + id.y * n_groups.x * 64u, n);
    if c.z < n {
        prolong(levels.level, c);
    }
}

fn sweep_together(level: u32, thread: u32) {
    let n = n_of(level);
    for (var colour = 0u; colour < 2u; colour++) {
        for (var item = thread; item < n * n * ((n + 1u) / 2u); item += N_THREADS) {
            let c = item_coloured(item, n, colour);
            if c.x < n {
                relax(level, c);
            }
        }
        storageBarrier();
    }
}

// One cycle over this level and all coarser ones, in one workgroup.
@compute @workgroup_size(N_THREADS)
fn coarse(@builtin(local_invocation_index) thread: u32) {
    let last = levels.n_levels - 1u;
    for (var level = levels.level; level < last; level++) {
        for (var i = 0u; i < N_COARSE_SWEEPS; i++) {
            sweep_together(level, thread);
        }
        let n = n_of(level + 1u);
        for (var first = 0u; first < 8u * n * n * n; first += N_THREADS) {
            restrict_to(level, (first + thread) / 8u, thread);
        }
        storageBarrier();
    }
    for (var i = 0u; i < N_COARSEST_SWEEPS; i++) {
        sweep_together(last, thread);
    }
    for (var up = levels.level; up < last; up++) {
        let level = last - 1u - (up - levels.level);
        let n = n_of(level);
        for (var item = thread; item < n * n * n; item += N_THREADS) {
            prolong(level, item_cell(item, n));
        }
        storageBarrier();
        for (var i = 0u; i < N_COARSE_SWEEPS; i++) {
            sweep_together(level, thread);
        }
    }
}

// Speed through a lower face once the pressure has pushed.
fn pushed(c: vec3<u32>, axis: u32) -> f32 {
    let at = entry(c);
    var difference = 0.0;
    if c[axis] < grid.n {
        difference += pressure[at];
    }
    if c[axis] > 0u {
        difference -= pressure[entry(c - step_of(axis))];
    }
    return predicted[at][axis] - openness[at][axis] * difference;
}

@compute @workgroup_size(64)
fn project(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let c = item_cell(id.x + id.y * n_groups.x * 64u, grid.n + 1u);
    if c.z > grid.n {
        return;
    }
    var low = vec3<f32>(0.0);
    var middle = vec3<f32>(0.0);
    for (var axis = 0u; axis < 3u; axis++) {
        let others = c * (1u - step_of(axis));
        if all(others < vec3<u32>(grid.n)) {
            low[axis] = pushed(c, axis);
            if c[axis] < grid.n {
                middle[axis] = 0.5 * (low[axis] + pushed(c + step_of(axis), axis));
            }
        }
    }
    faces[entry(c)] = vec4<f32>(low, 0.0);
    if all(c < vec3<u32>(grid.n)) {
        air[entry(c)] = vec4<f32>(middle, predicted[entry(c)].w);
    }
}
