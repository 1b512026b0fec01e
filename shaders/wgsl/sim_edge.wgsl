// Edges of strands against colliders so thin that they would slip between two vertices. Twin of sim/src/edge.rs,
// which says why each is as it is.
#define_import_path lorelei::sim_edge

#import lorelei::sim_pose::{Pose, rotate, pose_apply_inverse, normalize_or_zero}
#import lorelei::sim_contact::{
    Capsule, Contacted, Touch, contact, capsules, capsule_nearest, carried, moments, ARRIVED, MARCH_STEPS,
}

const EDGE_PUSHES: u32 = 4u;
const LEAST_LEVER: f32 = 0.1;

// Two ends: the other one and the free one.
struct Ends {
    held: vec3<f32>,
    free: vec3<f32>,
}

struct NearestOnEdge {
    distance: f32,
    normal: vec3<f32>,
    on_edge: f32,
    on_axis: f32,
    radius: f32,
}

// Keep the free end of an edge where the edge goes through no thin collider on its way.
fn collide_edge(
    start: Ends,
    end: Ends,
    prev: vec3<f32>,
    along: f32,
    before: Pose,
    after: Pose,
) -> Contacted {
    var contacted = Contacted(end.free, prev, 0.0);
    for (var i = 0u; i < contact.n_capsules; i++) {
        let capsule = capsules[i];
        if !is_thin(capsule) {
            continue;
        }
        let touched = touch_edge(capsule, start, Ends(end.held, contacted.x), along, before, after);
        if touched.push <= 0.0 {
            continue;
        }
        let pushed = contacted.x + touched.push * touched.normal;
        let slid = pushed - carried(touched, prev, before, after);
        let along_surface = slid - dot(slid, touched.normal) * touched.normal;
        let hold_back = min(contact.friction * touched.push / max(length(along_surface), 1e-9), 1.0);
        contacted.x = pushed - hold_back * along_surface;
        contacted.prev += dot(slid, touched.normal) * touched.normal;
    }
    return contacted;
}

// The same of an edge that a correction takes from `start` to `end` at the end of a step.
fn keep_edge_out(start: Ends, end: Ends, along: f32, after: Pose) -> vec3<f32> {
    let of_step = moments;
    moments = vec2<f32>(of_step.y);
    var x = end.free;
    for (var i = 0u; i < contact.n_capsules; i++) {
        let capsule = capsules[i];
        if is_thin(capsule) {
            let touched = touch_edge(capsule, start, Ends(end.held, x), along, after, after);
            x += touched.push * touched.normal;
        }
    }
    moments = of_step;
    return x;
}

// How far the free end of an edge has to be pushed that goes from `start` to `end`.
fn touch_edge(capsule: Capsule, start: Ends, end: Ends, along: f32, before: Pose, after: Pose) -> Touch {
    let on_head = capsule.on_head == 1u;
    var at_start = start;
    var at_end = end;
    if on_head {
        at_start = Ends(pose_apply_inverse(before, start.held), pose_apply_inverse(before, start.free));
        at_end = Ends(pose_apply_inverse(after, end.held), pose_apply_inverse(after, end.free));
    }
    let wanted = contact.margin + contact.pearl * along;
    let way_a = capsule.a - capsule.a_before;
    let way_b = capsule.b - capsule.b_before;
    let by_itself = (moments.y - moments.x) * max(length(way_a), length(way_b));
    let way = max(distance(at_start.held, at_end.held), distance(at_start.free, at_end.free)) + by_itself;
    var nearest = nearest_on_edge(capsule, at_start, moments.x);
    var t = 0.0;
    for (var i = 0u; i < MARCH_STEPS; i++) {
        let room = nearest.distance - wanted;
        if room < ARRIVED {
            break;
        }
        t += room / max(way, 1e-9);
        if t >= 1.0 {
            return Touch(0.0, vec3<f32>(0.0, 1.0, 0.0), on_head, vec3<f32>(0.0));
        }
        let there = Ends(mix(at_start.held, at_end.held, t), mix(at_start.free, at_end.free, t));
        nearest = nearest_on_edge(capsule, there, moments.x + t * (moments.y - moments.x));
    }
    var side = nearest.normal;
    var free = at_end.free;
    for (var i = 0u; i < EDGE_PUSHES; i++) {
        nearest = nearest_on_edge(capsule, Ends(at_end.held, free), moments.y);
        // Gone through, it is nearest the other way round.
        let turned = select(1.0, -1.0, dot(nearest.normal, side) < 0.0);
        let far = nearest.distance + nearest.radius;
        let deep = wanted + nearest.radius - turned * far;
        if deep <= 0.0 {
            break;
        }
        side = turned * nearest.normal;
        free += deep / max(nearest.on_edge, LEAST_LEVER) * side;
    }
    let pushed = free - at_end.free;
    var normal = normalize_or_zero(pushed);
    var shift = way_a + nearest.on_axis * (way_b - way_a);
    if on_head {
        normal = rotate(after.rotation, normal);
        shift = rotate(after.rotation, shift);
    }
    return Touch(length(pushed), normal, on_head, shift);
}

// The place of an edge that is nearest to a capsule as that is at a share of the frame.
fn nearest_on_edge(capsule: Capsule, edge: Ends, moment: f32) -> NearestOnEdge {
    let a = capsule.a_before + moment * (capsule.a - capsule.a_before);
    let b = capsule.b_before + moment * (capsule.b - capsule.b_before);
    let on_edge = nearest_on(edge.held, edge.free - edge.held, a, b);
    let place = edge.held + on_edge * (edge.free - edge.held);
    let on_axis = capsule_nearest(a, capsule.radius_a, b, capsule.radius_b, place);
    let from_axis = place - a - on_axis * (b - a);
    let far = length(from_axis);
    var normal = vec3<f32>(0.0, 1.0, 0.0);
    if far > 1e-9 {
        normal = from_axis / far;
    }
    let radius = capsule.radius_a + on_axis * (capsule.radius_b - capsule.radius_a);
    return NearestOnEdge(far - radius, normal, on_edge, on_axis, radius);
}

// An edge between two vertices that it keeps out could cut through it.
fn is_thin(capsule: Capsule) -> bool {
    return capsule.keeps_rest == 0u && min(capsule.radius_a, capsule.radius_b) + contact.margin < contact.thin_below;
}

// Where on the way from `p` by `way`, 0 to 1, the place is that is nearest to the line from `a` to `b`.
fn nearest_on(p: vec3<f32>, way: vec3<f32>, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let axis = b - a;
    let from_a = p - a;
    let way_squared = dot(way, way);
    let axis_squared = dot(axis, axis);
    let along_axis = dot(axis, from_a);
    let along_way = dot(way, from_a);
    let both = dot(way, axis);
    let across = way_squared * axis_squared - both * both;
    var s = 0.0;
    if across > 1e-6 * way_squared * axis_squared {
        s = clamp((both * along_axis - along_way * axis_squared) / across, 0.0, 1.0);
    }
    // Beyond an end of the line, the place that is nearest to that end.
    let on_line = both * s + along_axis;
    if on_line <= 0.0 || on_line >= axis_squared {
        let to_end = select(both - along_way, -along_way, on_line <= 0.0);
        s = clamp(to_end / max(way_squared, 1e-12), 0.0, 1.0);
    }
    return s;
}
