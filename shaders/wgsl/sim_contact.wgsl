// What hair keeps out of. Twin of sim/src/contact.rs.
#define_import_path lorelei::sim_contact

#import lorelei::sim_pose::{Pose, rotate, pose_apply, pose_apply_inverse, after_inverse_of, normalize_or_zero}

struct ContactParams {
    field_min: vec3<f32>,
    field_cell: f32,
    // Nodes of the head's distance field; x is 0 where there is none.
    field_n: vec3<u32>,
    n_spheres: u32,
    margin: f32,
    friction: f32,
}

// A vertex after a contact, and where it was a step before.
struct Contacted {
    x: vec3<f32>,
    prev: vec3<f32>,
}

@group(0) @binding(auto) var<uniform> contact: ContactParams;
@group(0) @binding(auto) var<storage, read> field_values: array<f32>;
// Centre and radius.
@group(0) @binding(auto) var<storage, read> spheres: array<vec4<f32>>;

const NOTHING_NEAR: f32 = 1e9;

fn field_value(node: vec3<u32>) -> f32 {
    return field_values[node.x + contact.field_n.x * (node.y + contact.field_n.y * node.z)];
}

// Gradient (xyz) and trilinear distance (w) of the head's field.
fn field_sample(p: vec3<f32>) -> vec4<f32> {
    let in_cells = (p - contact.field_min) / contact.field_cell;
    let inside = clamp(in_cells, vec3<f32>(0.0), vec3<f32>(contact.field_n - 1u));
    let corner = min(vec3<u32>(inside), contact.field_n - 2u);
    let t = inside - vec3<f32>(corner);
    let outside = length(in_cells - inside) * contact.field_cell;
    let c0 = field_value(corner);
    let c1 = field_value(corner + vec3<u32>(1u, 0u, 0u));
    let c2 = field_value(corner + vec3<u32>(0u, 1u, 0u));
    let c3 = field_value(corner + vec3<u32>(1u, 1u, 0u));
    let c4 = field_value(corner + vec3<u32>(0u, 0u, 1u));
    let c5 = field_value(corner + vec3<u32>(1u, 0u, 1u));
    let c6 = field_value(corner + vec3<u32>(0u, 1u, 1u));
    let c7 = field_value(corner + vec3<u32>(1u, 1u, 1u));
    let y0 = mix(mix(c0, c1, t.x), mix(c2, c3, t.x), t.y);
    let y1 = mix(mix(c4, c5, t.x), mix(c6, c7, t.x), t.y);
    let dx = mix(mix(c1 - c0, c3 - c2, t.y), mix(c5 - c4, c7 - c6, t.y), t.z);
    let dy = mix(mix(c2 - c0, c3 - c1, t.x), mix(c6 - c4, c7 - c5, t.x), t.z);
    let dz = mix(mix(c4 - c0, c5 - c1, t.x), mix(c6 - c2, c7 - c3, t.x), t.y);
    return vec4<f32>(vec3<f32>(dx, dy, dz) / contact.field_cell, mix(y0, y1, t.z) + outside);
}

// Direction away from the nearest obstacle (xyz, unit or zero) and the distance to it (w).
fn normal_and_distance(p: vec3<f32>) -> vec4<f32> {
    var nearest = vec4<f32>(0.0, 1.0, 0.0, NOTHING_NEAR);
    if contact.field_n.x > 0u {
        let sampled = field_sample(p);
        nearest = vec4<f32>(normalize_or_zero(sampled.xyz), min(sampled.w, NOTHING_NEAR));
    }
    for (var i = 0u; i < contact.n_spheres; i++) {
        let from_centre = p - spheres[i].xyz;
        let l = length(from_centre);
        if l - spheres[i].w < nearest.w {
            var normal = vec3<f32>(0.0, 1.0, 0.0);
            if l > 1e-9 {
                normal = from_centre / l;
            }
            nearest = vec4<f32>(normal, l - spheres[i].w);
        }
    }
    return nearest;
}

// Push a vertex out to the margin, or to where it rests if that is nearer.
fn contact_collide(x: vec3<f32>, prev: vec3<f32>, rest_distance: f32, before: Pose, after: Pose) -> Contacted {
    let nearest = normal_and_distance(pose_apply_inverse(after, x));
    let push = min(contact.margin, rest_distance) - nearest.w;
    if push <= 0.0 {
        return Contacted(x, prev);
    }
    let carry = after_inverse_of(after, before);
    let normal = rotate(after.rotation, nearest.xyz);
    let pushed = x + push * normal;
    let slid = pushed - pose_apply(carry, prev);
    let along = slid - dot(slid, normal) * normal;
    let hold_back = min(contact.friction * push / max(length(along), 1e-9), 1.0);
    return Contacted(pushed - hold_back * along, prev + dot(slid, normal) * normal);
}
