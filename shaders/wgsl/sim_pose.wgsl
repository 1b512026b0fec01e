// Rotations and rigid poses of the strand solvers. Twin of sim/src/pose.rs.
#define_import_path lorelei::sim_pose

struct Pose {
    rotation: vec4<f32>,
    translation: vec4<f32>,
}

fn normalize_or_zero(v: vec3<f32>) -> vec3<f32> {
    let l = length(v);
    if l > 1e-9 {
        return v / l;
    }
    return vec3<f32>(0.0);
}

// Quaternions are (x, y, z, w), unit length.
fn rotate(q: vec4<f32>, v: vec3<f32>) -> vec3<f32> {
    let t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

fn conjugate(q: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(-q.xyz, q.w);
}

// First b, then a.
fn multiply(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4<f32>(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

fn pose_apply(pose: Pose, p: vec3<f32>) -> vec3<f32> {
    return rotate(pose.rotation, p) + pose.translation.xyz;
}

fn pose_apply_inverse(pose: Pose, p: vec3<f32>) -> vec3<f32> {
    return rotate(conjugate(pose.rotation), p - pose.translation.xyz);
}

// First the inverse of `before`, then `after`.
fn after_inverse_of(after: Pose, before: Pose) -> Pose {
    let rotation = normalize(multiply(after.rotation, conjugate(before.rotation)));
    let translation = after.translation.xyz - rotate(rotation, before.translation.xyz);
    return Pose(rotation, vec4<f32>(translation, 0.0));
}

// The smallest rotation that takes the direction of `a` to that of `b`.
fn shortest_turn(a: vec3<f32>, b: vec3<f32>) -> vec4<f32> {
    let scale = sqrt(dot(a, a) * dot(b, b));
    if scale < 1e-12 {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let w = scale + dot(a, b);
    if w < 1e-5 * scale {
        var across = vec3<f32>(0.0, 1.0, 0.0);
        if abs(a.x) < max(abs(a.y), abs(a.z)) {
            across = vec3<f32>(1.0, 0.0, 0.0);
        }
        return vec4<f32>(normalize_or_zero(cross(a, across)), 0.0);
    }
    let axis = cross(a, b);
    return vec4<f32>(axis, w) / sqrt(dot(axis, axis) + w * w);
}

// One over the length of `v`; zero where it has none.
fn inverse_length(v: vec3<f32>) -> f32 {
    let squared = dot(v, v);
    return select(0.0, inverseSqrt(squared), squared > 1e-18);
}

// What the smallest rotation that takes the direction of `a` to that of `b` makes of `v`. `by_a`: one over the length of `a`, 0 where
// it has none; `along_a`: how far `v` goes along the direction of `a`.
fn turned_as(a: vec3<f32>, by_a: f32, along_a: f32, b: vec3<f32>, v: vec3<f32>) -> vec3<f32> {
    let by_b = inverse_length(b);
    let a_unit = a * by_a;
    let b_unit = b * by_b;
    let w = 1.0 + dot(a_unit, b_unit);
    if w < 1e-5 || by_a * by_b == 0.0 {
        return rotate(shortest_turn(a, b), v);
    }
    let share = (along_a + dot(b_unit, v)) / w;
    return v - share * a_unit + (2.0 * along_a - share) * b_unit;
}
