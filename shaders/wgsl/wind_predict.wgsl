// The air of the next frame but for its pressure: carried along, stirred, stopped by hair and head, driven by sources.
// Twin of sim/src/wind/predict.rs, function by function; that file says why each step is as it is.
#import lorelei::sim_pose::{pose_apply, pose_apply_inverse}
#import lorelei::sim_contact::{contact, capsules, field_sample, capsule_nearest}
#import lorelei::wind_grid::{grid, entry, item_cell, step_of, unit, MAX_SPEED}
#import lorelei::wind_free::{free, free_air, body, blown_through}

// Speeds through the lower faces, as the last frame left them.
@group(0) @binding(auto) var<storage, read> faces: array<vec4<f32>>;
// Velocity in the middle of every cell, of the last frame.
@group(0) @binding(auto) var<storage, read> air: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> hair_cells: array<i32>;
// Rotation of the air (xyz) and its size (w).
@group(0) @binding(auto) var<storage, read_write> curls: array<vec4<f32>>;
// Speeds through the lower faces before the pressure; w how open the cell is.
@group(0) @binding(auto) var<storage, read_write> predicted: array<vec4<f32>>;
// What a difference of pressure does to the speed through each lower face.
@group(0) @binding(auto) var<storage, read_write> openness: array<vec4<f32>>;

// Rate at which the air in a source's body takes up its speed, 1/s.
const DRIVE = 3000.0;
const IN_LOSS = 2.0;
const CALM_CURL = 20.0;
const FASTEST_HEAD = 1000.0;
const LEAST_OPEN = 0.02;

// Velocity in the last frame at a place; beyond the box that at its boundary.
fn air_before(p: vec3<f32>) -> vec3<f32> {
    let g = (p - grid.min_before) / grid.cell;
    let last = f32(grid.n);
    let inside = clamp(g - 0.5, vec3<f32>(0.0), vec3<f32>(last - 1.0));
    let corner = min(vec3<u32>(inside), vec3<u32>(grid.n - 2u));
    let t = inside - vec3<f32>(corner);
    let at = entry(corner);
    let row = grid.n + 1u;
    let slab = row * row;
    let y0 = mix(mix(air[at].xyz, air[at + 1u].xyz, t.x), mix(air[at + row].xyz, air[at + row + 1u].xyz, t.x), t.y);
    let z = at + slab;
    let y1 = mix(mix(air[z].xyz, air[z + 1u].xyz, t.x), mix(air[z + row].xyz, air[z + row + 1u].xyz, t.x), t.y);
    return mix(y0, y1, t.z);
}

// Speed along an axis in the last frame at a place, from the faces.
fn face_before(p: vec3<f32>, axis: u32) -> f32 {
    let g = (p - grid.min_before) / grid.cell;
    let last = f32(grid.n);
    if !(all(g >= vec3<f32>(0.0)) && all(g <= vec3<f32>(last))) {
        return free_air(p)[axis];
    }
    let along = unit(axis);
    let inside = clamp(g - 0.5 * (1.0 - along), vec3<f32>(0.0), vec3<f32>(last - 1.0) + along);
    let corner = min(vec3<u32>(inside), vec3<u32>(grid.n - 2u) + step_of(axis));
    let t = inside - vec3<f32>(corner);
    let at = entry(corner);
    let row = grid.n + 1u;
    let z = at + row * row;
    let y0 = mix(
        mix(faces[at][axis], faces[at + 1u][axis], t.x),
        mix(faces[at + row][axis], faces[at + row + 1u][axis], t.x),
        t.y,
    );
    let y1 = mix(
        mix(faces[z][axis], faces[z + 1u][axis], t.x),
        mix(faces[z + row][axis], faces[z + row + 1u][axis], t.x),
        t.y,
    );
    return mix(y0, y1, t.z);
}

// Speed along an axis of the air that arrives at a place: back along the path by the midpoint rule. What has come through a
// fan on its way has the fan's speed.
fn carried(p: vec3<f32>, axis: u32) -> f32 {
    let halfway = p - 0.5 * grid.dt_secs * air_before(p);
    let came_from = p - grid.dt_secs * air_before(halfway);
    var v = face_before(came_from, axis);
    for (var source_idx = 0u; source_idx < free.n_sources; source_idx++) {
        let blown = blown_through(source_idx, came_from, p, grid.cell);
        v += blown.w * (blown[axis] - v);
    }
    return v;
}

fn air_in(c: vec3<i32>) -> vec3<f32> {
    return air[entry(vec3<u32>(clamp(c, vec3<i32>(0), vec3<i32>(i32(grid.n) - 1))))].xyz;
}

// How the air of the last frame turns in a cell.
fn curl(c: vec3<i32>) -> vec3<f32> {
    let dx = air_in(c + vec3<i32>(1, 0, 0)) - air_in(c - vec3<i32>(1, 0, 0));
    let dy = air_in(c + vec3<i32>(0, 1, 0)) - air_in(c - vec3<i32>(0, 1, 0));
    let dz = air_in(c + vec3<i32>(0, 0, 1)) - air_in(c - vec3<i32>(0, 0, 1));
    return vec3<f32>(dy.z - dz.y, dz.x - dx.z, dx.y - dy.x) / (2.0 * grid.cell);
}

fn curl_size(c: vec3<i32>) -> f32 {
    return curls[entry(vec3<u32>(clamp(c, vec3<i32>(0), vec3<i32>(i32(grid.n) - 1))))].w;
}

// Acceleration that drives eddies in a cell, cm/s2.
fn confinement(c: vec3<i32>) -> vec3<f32> {
    let at = clamp(c, vec3<i32>(0), vec3<i32>(i32(grid.n) - 1));
    let uphill = vec3<f32>(
        curl_size(at + vec3<i32>(1, 0, 0)) - curl_size(at - vec3<i32>(1, 0, 0)),
        curl_size(at + vec3<i32>(0, 1, 0)) - curl_size(at - vec3<i32>(0, 1, 0)),
        curl_size(at + vec3<i32>(0, 0, 1)) - curl_size(at - vec3<i32>(0, 0, 1)),
    );
    let steep = length(uphill);
    if steep < 1e-6 {
        return vec3<f32>(0.0);
    }
    let omega = curls[entry(vec3<u32>(at))];
    let rate = grid.vorticity * omega.w / (omega.w + CALM_CURL);
    return rate * grid.cell * cross(uphill / steep, omega.xyz);
}

// How open a place of the size of a cell is: 0 in the head, 1 outside.
fn open_at(p: vec3<f32>) -> f32 {
    if grid.obstacle == 0u {
        return 1.0;
    }
    let in_head = pose_apply_inverse(grid.world_from_head, p);
    var distance = 1e9;
    if contact.field_n.x > 0u {
        distance = field_sample(in_head).w;
    }
    for (var i = 0u; i < contact.n_capsules; i++) {
        let capsule = capsules[i];
        let at = select(p, in_head, capsule.on_head == 1u);
        let h = capsule_nearest(capsule.a, capsule.radius_a, capsule.b, capsule.radius_b, at);
        let to_middle = length(at - mix(capsule.a, capsule.b, h));
        distance = min(distance, to_middle - mix(capsule.radius_a, capsule.radius_b, h));
    }
    let open = clamp(0.5 + distance / grid.cell, 0.0, 1.0);
    return select(open, 0.0, open < LEAST_OPEN);
}

// Velocity of the head at a place.
fn head_velocity(p: vec3<f32>) -> vec3<f32> {
    let before = pose_apply(grid.world_from_head_before, pose_apply_inverse(grid.world_from_head, p));
    return clamp((p - before) / grid.dt_secs, vec3<f32>(-FASTEST_HEAD), vec3<f32>(FASTEST_HEAD));
}

// Hair in a cell, in units of mass (x) and of momentum along an axis (y).
fn hair_in(c: vec3<i32>, axis: u32) -> vec2<f32> {
    if any(c < vec3<i32>(0)) || any(c >= vec3<i32>(i32(grid.n))) {
        return vec2<f32>(0.0);
    }
    let at = 4u * entry(vec3<u32>(c));
    return vec2<f32>(f32(hair_cells[at]), f32(hair_cells[at + 1u + axis]));
}

// Through a lower face: the speed before the pressure (x), and what a difference of pressure does to it (y).
fn predict_face(c: vec3<u32>, axis: u32) -> vec2<f32> {
    let p = grid.min + grid.cell * (vec3<f32>(c) + 0.5 * (1.0 - unit(axis)));
    let above = vec3<i32>(c);
    let below = above - vec3<i32>(step_of(axis));
    var v = carried(p, axis);
    if grid.vorticity > 0.0 {
        v += 0.5 * grid.dt_secs * (confinement(below)[axis] + confinement(above)[axis]);
    }
    // Compute what hair and sources make of it in a step, as if they pulled with the speed at its end.
    var pulled = v;
    var pull = 1.0;
    let hair = hair_in(below, axis) + hair_in(above, axis);
    if hair.x > 0.0 && grid.hair_drag > 0.0 {
        let density = 0.5 * hair.x / (grid.mass_unit * grid.cell * grid.cell * grid.cell);
        let hair_speed = (hair.y / grid.momentum_unit) / (hair.x / grid.mass_unit);
        let k = grid.dt_secs * grid.hair_drag * density;
        pulled += k * hair_speed;
        pull += k;
    }
    for (var source_idx = 0u; source_idx < free.n_sources; source_idx++) {
        let driven = body(source_idx, p, grid.cell);
        if driven.w > 0.0 {
            let k = grid.dt_secs * DRIVE * driven.w;
            pulled += k * driven[axis];
            pull += k;
        }
    }
    let inwards = select(0.0, 1.0, c[axis] == 0u) - select(0.0, 1.0, c[axis] == grid.n);
    var outside = vec3<f32>(0.0);
    if inwards != 0.0 {
        outside = clamp(free_air(p), vec3<f32>(-MAX_SPEED), vec3<f32>(MAX_SPEED));
        // Air that is drawn in faster than it blows outside loses the pressure that it took to draw it.
        let k = IN_LOSS * grid.dt_secs / grid.cell * max(inwards * (face_before(p, axis) - outside[axis]), 0.0);
        pulled += k * outside[axis];
        pull += k;
    }
    let open = open_at(p);
    var speed = open * pulled / pull;
    if open < 1.0 {
        speed += (1.0 - open) * head_velocity(p)[axis];
    }
    if !(abs(speed) <= MAX_SPEED) {
        speed = open * clamp(free.steady[axis], -MAX_SPEED, MAX_SPEED);
    }
    var push = open / pull;
    if inwards != 0.0 {
        // Outside there is no pressure, from the face on: half a cell away. Where wind comes in it is what it is.
        let held = clamp(2.0 * inwards * outside[axis] / max(length(outside), 1e-3), 0.0, 1.0);
        speed += open * held * (outside[axis] - speed);
        push *= 2.0 * (1.0 - held);
    }
    return vec2<f32>(speed, push);
}

@compute @workgroup_size(64)
fn turn(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let c = item_cell(id.x + id.y * n_groups.x * 64u, grid.n);
    if c.z >= grid.n {
        return;
    }
    let omega = curl(vec3<i32>(c));
    curls[entry(c)] = vec4<f32>(omega, length(omega));
}

// Four threads a cell: one for each of its lower faces, and one for how open it is.
@compute @workgroup_size(64)
fn predict(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let item = id.x + id.y * n_groups.x * 64u;
    let c = item_cell(item / 4u, grid.n + 1u);
    if c.z > grid.n {
        return;
    }
    let axis = item % 4u;
    if axis == 3u {
        predicted[entry(c)].w = open_at(grid.min + grid.cell * (vec3<f32>(c) + 0.5));
        openness[entry(c)].w = 0.0;
        return;
    }
    var face = vec2<f32>(0.0);
    // The other two axes end a cell earlier.
    if all(c < vec3<u32>(grid.n) + step_of(axis)) {
        face = predict_face(c, axis);
    }
    predicted[entry(c)][axis] = face.x;
    openness[entry(c)][axis] = face.y;
}
