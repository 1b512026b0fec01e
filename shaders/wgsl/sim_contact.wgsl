// What hair keeps out of. Twin of sim/src/contact.rs, which says why each is as it is.
#define_import_path lorelei::sim_contact

#import lorelei::sim_pose::{Pose, rotate, pose_apply, pose_apply_inverse, after_inverse_of, normalize_or_zero}

struct ContactParams {
    field_min: vec3<f32>,
    field_cell: f32,
    // Nodes of the head's distance field; x is 0 where there is none.
    field_n: vec3<u32>,
    n_capsules: u32,
    margin: f32,
    friction: f32,
    // Radius of hair at the tip.
    pearl: f32,
    // Shortest way in a step that is marched.
    march_from: f32,
    // Farthest way of a collider in a frame.
    capsule_way: f32,
    // Colliders are thin that keep hair no farther than this from their axis.
    thin_below: f32,
}

struct Capsule {
    a: vec3<f32>,
    radius_a: f32,
    b: vec3<f32>,
    radius_b: f32,
    // Where it was a frame before.
    a_before: vec3<f32>,
    // 1: in head space.
    on_head: u32,
    b_before: vec3<f32>,
    // 1: hair that rests inside stays.
    keeps_rest: u32,
}

// A vertex after a contact, where it was a step before, and how far it is from a contact.
struct Contacted {
    x: vec3<f32>,
    prev: vec3<f32>,
    room: f32,
}

// What a vertex lies on, or is about to.
struct Barrier {
    normal: vec3<f32>,
    push: f32,
    goes: vec3<f32>,
}

struct Touch {
    push: f32,
    normal: vec3<f32>,
    on_head: bool,
    shift: vec3<f32>,
}

@group(0) @binding(auto) var<uniform> contact: ContactParams;
// Of every node its value and those of the next along x, along y, and along both.
@group(0) @binding(auto) var<storage, read> field_faces: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read> capsules: array<Capsule>;

const NOTHING_NEAR: f32 = 1e9;
const MARCH_STEPS: u32 = 16u;
const NEAR: f32 = 1.0;
const ARRIVED: f32 = 0.01;
const STEEPEST: f32 = 1.8;

// The step's beginning and end as shares of its frame.
var<private> moments: vec2<f32> = vec2<f32>(1.0, 1.0);

// Obstacles as they are in one of a frame's steps.
fn contact_step(step: u32, n_steps: u32) {
    moments = vec2<f32>(f32(step), f32(step + 1u)) / f32(max(n_steps, 1u));
}

// Gradient (xyz) and trilinear distance (w) of the head's field.
fn field_sample(p: vec3<f32>) -> vec4<f32> {
    let in_cells = (p - contact.field_min) / contact.field_cell;
    let inside = clamp(in_cells, vec3<f32>(0.0), vec3<f32>(contact.field_n - 1u));
    let corner = min(vec3<u32>(inside), contact.field_n - 2u);
    let t = inside - vec3<f32>(corner);
    let outside = length(in_cells - inside) * contact.field_cell;
    let at = corner.x + contact.field_n.x * (corner.y + contact.field_n.y * corner.z);
    let low = field_faces[at];
    let high = field_faces[at + contact.field_n.x * contact.field_n.y];
    let y0 = mix(mix(low.x, low.y, t.x), mix(low.z, low.w, t.x), t.y);
    let y1 = mix(mix(high.x, high.y, t.x), mix(high.z, high.w, t.x), t.y);
    let dx = mix(mix(low.y - low.x, low.w - low.z, t.y), mix(high.y - high.x, high.w - high.z, t.y), t.z);
    let dy = mix(mix(low.z - low.x, low.w - low.y, t.x), mix(high.z - high.x, high.w - high.y, t.x), t.z);
    let dz = mix(mix(high.x - low.x, high.y - low.y, t.x), mix(high.z - low.z, high.w - low.w, t.x), t.y);
    return vec4<f32>(vec3<f32>(dx, dy, dz) / contact.field_cell, mix(y0, y1, t.z) + outside);
}

// Keep a vertex out, `along` its strand; with the head it would have gone to `carried_prev`.
fn contact_collide(
    moved: vec3<f32>,
    prev: vec3<f32>,
    rest_distance: f32,
    along: f32,
    before: Pose,
    carried_prev: vec3<f32>,
    after: Pose,
) -> Contacted {
    if contact.field_n.x == 0u && contact.n_capsules == 0u {
        return Contacted(moved, prev, NOTHING_NEAR);
    }
    var x = moved;
    if contact_way(moved, prev, carried_prev) > contact.march_from {
        x = march(moved, prev, rest_distance, along, before, after);
    }
    let in_head = pose_apply_inverse(after, x);
    let touched = touch(x, in_head, after.rotation, moments.y, rest_distance, along, 0.0);
    if touched.push <= 0.0 {
        return Contacted(x, prev, -touched.push);
    }
    let origin = carried(touched, prev, before, after);
    let pushed = x + touched.push * touched.normal;
    let slid = pushed - origin;
    let along_surface = slid - dot(slid, touched.normal) * touched.normal;
    let hold_back = min(contact.friction * touched.push / max(length(along_surface), 1e-9), 1.0);
    return Contacted(pushed - hold_back * along_surface, prev + dot(slid, touched.normal) * touched.normal, 0.0);
}

// What a vertex is nearest to or deepest in that would go with the head from `prev` to `carried_prev`; its normal is known where
// it is nearer than `near`.
fn contact_barrier(
    prev: vec3<f32>,
    carried_prev: vec3<f32>,
    rest_distance: f32,
    along: f32,
    after: Pose,
    near: f32,
) -> Barrier {
    if contact.field_n.x == 0u && contact.n_capsules == 0u {
        return Barrier(vec3<f32>(0.0), -NOTHING_NEAR, vec3<f32>(0.0));
    }
    let in_head = pose_apply_inverse(after, carried_prev);
    let touched = touch(carried_prev, in_head, after.rotation, moments.y, rest_distance, along, near);
    let stays = select(prev - carried_prev, vec3<f32>(0.0), touched.on_head);
    return Barrier(touched.normal, touched.push, stays + (moments.y - moments.x) * touched.shift);
}

// How far a vertex goes in a step as any obstacle sees it; with the head it would have gone to `carried`.
fn contact_way(x: vec3<f32>, prev: vec3<f32>, carried: vec3<f32>) -> f32 {
    if contact.n_capsules == 0u {
        return distance(x, carried);
    }
    return max(distance(x, carried), distance(x, prev)) + contact.capsule_way * (moments.y - moments.x);
}

// Keep out a vertex that a correction takes from `start` to `x` at the end of a step.
fn contact_keep_out(start: vec3<f32>, moved: vec3<f32>, rest_distance: f32, along: f32, after: Pose) -> vec3<f32> {
    if contact.field_n.x == 0u && contact.n_capsules == 0u {
        return moved;
    }
    let of_step = moments;
    moments = vec2<f32>(of_step.y);
    let x = march(moved, start, rest_distance, along, after, after);
    moments = of_step;
    let touched = touch(x, pose_apply_inverse(after, x), after.rotation, moments.y, rest_distance, along, 0.0);
    if touched.push <= 0.0 {
        return x;
    }
    return x + touched.push * touched.normal;
}

// Where `x` is once it went from `prev` without going through anything.
fn march(x: vec3<f32>, prev: vec3<f32>, rest_distance: f32, along: f32, before: Pose, after: Pose) -> vec3<f32> {
    let from_head = pose_apply_inverse(before, prev);
    let to_head = pose_apply_inverse(after, x);
    let by_itself = contact.capsule_way * (moments.y - moments.x);
    let way = max(distance(from_head, to_head), select(0.0, distance(x, prev), contact.n_capsules > 0u)) + by_itself;
    if way <= contact.march_from {
        return x;
    }
    var t = 0.0;
    for (var i = 0u; i < MARCH_STEPS; i++) {
        let moment = moments.x + t * (moments.y - moments.x);
        let at = prev + t * (x - prev);
        let in_head = from_head + t * (to_head - from_head);
        let touched = touch(at, in_head, after.rotation, moment, rest_distance, along, NEAR);
        if touched.push > -ARRIVED || i + 1u == MARCH_STEPS {
            // Seen from the obstacle: where it would be had it not moved, and what is left of the way.
            let origin = carried(touched, prev, before, after);
            let left = (1.0 - t) * (x - origin);
            let inwards = min(dot(left, touched.normal), 0.0);
            return origin + t * (x - origin) + left - inwards * touched.normal;
        }
        t -= touched.push / way;
        if t >= 1.0 {
            return x;
        }
    }
    return x;
}

// Where a place on what is touched has gone in the step.
fn carried(touched: Touch, place: vec3<f32>, before: Pose, after: Pose) -> vec3<f32> {
    var there = place;
    if touched.on_head {
        there = pose_apply(after_inverse_of(after, before), place);
    }
    return there + (moments.y - moments.x) * touched.shift;
}

// The obstacle that a vertex at `x` in the world, `in_head` in the head's space, is deepest in; the direction away from the
// head where it is nearer to a contact than `near`.
fn touch(
    x: vec3<f32>,
    in_head: vec3<f32>,
    rotation: vec4<f32>,
    moment: f32,
    rest_distance: f32,
    along: f32,
    near: f32,
) -> Touch {
    let wanted = contact.margin + contact.pearl * along;
    var deepest = Touch(-NOTHING_NEAR, vec3<f32>(0.0, 1.0, 0.0), true, vec3<f32>(0.0));
    if contact.field_n.x > 0u {
        let sampled = field_sample(in_head);
        deepest.push = min(wanted, rest_distance) - min(sampled.w, NOTHING_NEAR);
        if deepest.push > -near {
            deepest.normal = rotate(rotation, normalize_or_zero(sampled.xyz));
        }
    }
    for (var i = 0u; i < contact.n_capsules; i++) {
        let capsule = capsules[i];
        let on_head = capsule.on_head == 1u;
        let place = select(x, in_head, on_head);
        let way_a = capsule.a - capsule.a_before;
        let way_b = capsule.b - capsule.b_before;
        let a = capsule.a_before + moment * way_a;
        let b = capsule.b_before + moment * way_b;
        let h = capsule_nearest(a, capsule.radius_a, b, capsule.radius_b, place);
        let from_axis = place - a - h * (b - a);
        let far = length(from_axis);
        let distance = far - (capsule.radius_a + h * (capsule.radius_b - capsule.radius_a));
        let kept = select(wanted, min(wanted, rest_distance), capsule.keeps_rest == 1u);
        if kept - distance > deepest.push {
            var normal = vec3<f32>(0.0, 1.0, 0.0);
            if far > 1e-9 {
                normal = from_axis / far;
            }
            let shift = way_a + h * (way_b - way_a);
            deepest = Touch(kept - distance, normal, on_head, shift);
            if on_head {
                deepest.normal = rotate(rotation, normal);
                deepest.shift = rotate(rotation, shift);
            }
        }
    }
    return deepest;
}

// Where between its balls the one is whose surface is nearest, 0 to 1.
fn capsule_nearest(a: vec3<f32>, radius_a: f32, b: vec3<f32>, radius_b: f32, p: vec3<f32>) -> f32 {
    let axis = b - a;
    let squared = dot(axis, axis);
    let thinner = radius_a - radius_b;
    // Where one ball holds the other there is nothing between.
    var h = select(0.0, 1.0, thinner < 0.0);
    let slant = squared - thinner * thinner;
    if slant > 1e-10 {
        let l = sqrt(squared);
        let y = dot(p - a, axis) / l;
        let across = length(p - a - axis * (y / l));
        h = clamp((y - across * thinner / sqrt(slant)) / l, 0.0, 1.0);
    }
    return h;
}
