// Hair against hair. Twin of sim/src/volume/mod.rs, which says why each is as it is.

#import lorelei::sim_pose::{Pose, rotate, pose_apply_inverse}

struct VolumeParams {
    // World from head.
    rotation: vec4<f32>,
    translation: vec4<f32>,
    // First node, head space.
    low: vec3<f32>,
    cell: f32,
    n: vec3<u32>,
    n_vertices: u32,
    // Vertices of a guide.
    per_guide: u32,
    // Numbers of four that a vertex's state has.
    stride: u32,
    tolerance: f32,
    push: f32,
    blend: f32,
    // Guides whose vertices lie side by side.
    lanes: u32,
}

struct Crowd {
    // Centimetres of hair.
    hair: f32,
    // Density where it rests.
    rest_density: f32,
}

@group(0) @binding(auto) var<uniform> volume: VolumeParams;
// Side by side like the state.
@group(0) @binding(auto) var<storage, read> crowds: array<Crowd>;
// Of every vertex its place, where it was a step ago, and what else its law keeps; in the order of sim/src/lanes.rs.
@group(0) @binding(auto) var<storage, read_write> s: array<vec4<f32>>;
// Hair and its way in a step: four for every cell, x fastest.
@group(0) @binding(auto) var<storage, read_write> counts: array<atomic<i32>>;
// The counts blurred, in centimetres.
@group(0) @binding(auto) var<storage, read_write> blurred: array<vec4<f32>>;

const N_PINNED = 2u;
const SCALE = 4096.0;
const MOST_CROWDED = 3.0;
const SPARSE = 0.05;

struct Sampled {
    here: vec4<f32>,
    gradient: vec3<f32>,
}

fn pose_of() -> Pose {
    return Pose(volume.rotation, volume.translation);
}

// Of what the thread with number `idx` takes: threads go in the order in which the state lies, so that neighbours read side by
// side. The last group of guides may not be full.
fn is_vertex(idx: u32) -> bool {
    let guide_idx = idx / (volume.lanes * volume.per_guide) * volume.lanes + idx % volume.lanes;
    return guide_idx * volume.per_guide < volume.n_vertices;
}

fn place_on_guide(idx: u32) -> u32 {
    return idx / volume.lanes % volume.per_guide;
}

// Where the first of what is kept of a vertex is; the next is as many places on as there are lanes.
fn state_at(idx: u32) -> u32 {
    return idx / volume.lanes * volume.lanes * volume.stride + idx % volume.lanes;
}

fn index(cell: vec3<i32>) -> u32 {
    let at = vec3<u32>(cell);
    return at.x + volume.n.x * (at.y + volume.n.y * at.z);
}

fn is_inside(at: vec3<f32>) -> bool {
    return all(at >= vec3<f32>(0.0)) && all(at < vec3<f32>(volume.n - 1u));
}

// Corner i of a cell, and its share along each axis at the place t in it.
fn offset_of(i: i32) -> vec3<i32> {
    return vec3<i32>(i & 1, (i >> 1u) & 1, i >> 2u);
}

fn share_of(offset: vec3<f32>, t: vec3<f32>) -> vec3<f32> {
    return (1.0 - offset) + (2.0 * offset - 1.0) * t;
}

// Count a vertex: eight cells.
@compute @workgroup_size(64)
fn splat(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let idx = id.x + id.y * n_groups.x * 64u;
    if !is_vertex(idx) {
        return;
    }
    let first = state_at(idx);
    let x = s[first].xyz;
    let at = (pose_apply_inverse(pose_of(), x) - volume.low) / volume.cell;
    if !is_inside(at) {
        return;
    }
    let corner = floor(at);
    let t = at - corner;
    let way = x - s[first + volume.lanes].xyz;
    for (var i = 0; i < 8; i++) {
        let offset = offset_of(i);
        let share = share_of(vec3<f32>(offset), t);
        let hair = crowds[idx].hair * (share.x * share.y * share.z) * SCALE;
        let cell = 4u * index(vec3<i32>(corner) + offset);
        atomicAdd(&counts[cell], i32(floor(hair + 0.5)));
        atomicAdd(&counts[cell + 1u], i32(floor(hair * way.x + 0.5)));
        atomicAdd(&counts[cell + 2u], i32(floor(hair * way.y + 0.5)));
        atomicAdd(&counts[cell + 3u], i32(floor(hair * way.z + 0.5)));
    }
}

// Binomial weights over 27 cells.
@compute @workgroup_size(64)
fn blur(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let idx = id.x + id.y * n_groups.x * 64u;
    if idx >= volume.n.x * volume.n.y * volume.n.z {
        return;
    }
    let cell = vec3<i32>(vec3<u32>(idx % volume.n.x, idx / volume.n.x % volume.n.y, idx / (volume.n.x * volume.n.y)));
    var sum = vec4<f32>(0.0);
    for (var i = 0; i < 27; i++) {
        let step = vec3<i32>(i % 3, i / 3 % 3, i / 9) - 1;
        let place = cell + step;
        if all(place >= vec3<i32>(0)) && all(place < vec3<i32>(volume.n)) {
            let away = abs(step);
            let weight = 1.0 / f32(8 << u32(away.x + away.y + away.z));
            let at = 4u * index(place);
            let count = vec4<f32>(
                f32(atomicLoad(&counts[at])),
                f32(atomicLoad(&counts[at + 1u])),
                f32(atomicLoad(&counts[at + 2u])),
                f32(atomicLoad(&counts[at + 3u])),
            );
            sum += weight * count;
        }
    }
    blurred[idx] = sum / SCALE;
}

// The field and the gradient of the density (per centimetre) at a place in head space; zero outside.
fn sample(p: vec3<f32>) -> Sampled {
    var sampled = Sampled(vec4<f32>(0.0), vec3<f32>(0.0));
    let at = (p - volume.low) / volume.cell;
    if !is_inside(at) {
        return sampled;
    }
    let corner = floor(at);
    let t = at - corner;
    for (var i = 0; i < 8; i++) {
        let offset = offset_of(i);
        let share = share_of(vec3<f32>(offset), t);
        let value = blurred[index(vec3<i32>(corner) + offset)];
        sampled.here += share.x * share.y * share.z * value;
        let side = 2.0 * vec3<f32>(offset) - 1.0;
        sampled.gradient += value.x * side * vec3<f32>(share.y * share.z, share.x * share.z, share.x * share.y);
    }
    sampled.gradient /= volume.cell;
    return sampled;
}

// Drive a vertex out of the crowd, and along with it.
@compute @workgroup_size(64)
fn push(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n_groups: vec3<u32>) {
    let idx = id.x + id.y * n_groups.x * 64u;
    if !is_vertex(idx) || place_on_guide(idx) < N_PINNED {
        return;
    }
    let first = state_at(idx);
    let x = s[first].xyz;
    let prev = s[first + volume.lanes].xyz;
    let sampled = sample(pose_apply_inverse(pose_of(), x));
    let here = sampled.here;
    var added = vec3<f32>(0.0);
    let let_be = crowds[idx].rest_density * (1.0 + volume.tolerance) + SPARSE;
    let steep = length(sampled.gradient);
    if here.x > let_be && steep > 1e-6 {
        let crowded = min((here.x - let_be) / let_be, MOST_CROWDED);
        added = rotate(volume.rotation, sampled.gradient) * (-volume.push * crowded / steep);
    }
    if volume.blend > 0.0 && here.x > SPARSE {
        added += volume.blend * (here.yzw / here.x - (x - prev));
    }
    s[first + volume.lanes] = vec4<f32>(prev - added, s[first + volume.lanes].w);
}
