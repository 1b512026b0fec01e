//! Edges of strands against colliders so thin that they would slip between two vertices. Twin of `sim_edge.wgsl`: same names,
//! same order.
//!
//! An edge between two vertices that are kept out cuts through what is thinner than it is long. So after its vertices an
//! edge is asked about too: it is marched from where it was to where it is, both of its ends on the way, by the distance
//! between it and the collider's axis. Where they meet it stays on that side, however far the step goes on, and its free
//! end is pushed for it: the other one is where a sweep along the strand has left it.
//!
//! Only where some collider is thin: without, the kernels are made without it, and nothing is slower. The head is thick.
//!
//! Rejected: halves of the edges that go with a vertex as one rigid shape. Where a strand bends about a needle, both halves
//! touch it and the vertex cannot move, and hair is not pulled over the needle but through it.

use glam::Vec3;

use crate::contact::{ARRIVED, Capsule, ContactParams, Contacted, MARCH_STEPS, Obstacles, Touch, capsule_nearest};
use crate::pose::{Pose, normalize_or_zero, rotate};

/// Times that an edge is pushed until it is out: as it turns, another place of it is nearest.
const EDGE_PUSHES: u32 = 4;
/// What is nearest to an edge is no nearer to its other end, as a share, where the free one is pushed for it.
const LEAST_LEVER: f32 = 0.1;

/// Of an edge and a capsule.
struct NearestOnEdge {
    /// Between them; negative inside, cm.
    distance: f32,
    /// From the capsule to the edge.
    normal: Vec3,
    /// Where on the edge, and on the capsule, 0 to 1.
    s: f32,
    h: f32,
    /// Of the capsule there, cm.
    radius: f32,
}

impl Obstacles<'_> {
    /// As strands meet them whose longest edge is `edge`, cm.
    pub fn for_edges(mut self, edge: f32) -> Self {
        self.params.thin_below = edge;
        self
    }

    /// Whether some are so thin that edges are asked about too.
    pub fn has_thin(&self) -> bool {
        self.capsules.iter().any(|capsule| capsule.is_thin(&self.params))
    }

    /// Keep the free end of an edge where the edge goes through no thin collider on its way from `start` to `end`, each its other
    /// end and the free one; `prev` is the free one's place a step before. As [`Obstacles::collide`] for velocities.
    pub fn collide_edge(
        &self,
        start: [Vec3; 2],
        end: [Vec3; 2],
        prev: Vec3,
        along: f32,
        before: Pose,
        after: Pose,
    ) -> Contacted {
        let mut contacted = Contacted { x: end[1], prev, room: 0.0 };
        for capsule in self.capsules.iter().filter(|capsule| capsule.is_thin(&self.params)) {
            let touch = self.touch_edge(capsule, start, [end[0], contacted.x], along, before, after);
            if touch.push <= 0.0 {
                continue;
            }
            let pushed = contacted.x + touch.push * touch.normal;
            let slid = pushed - self.carried(touch, prev, before, after);
            let along_surface = slid - slid.dot(touch.normal) * touch.normal;
            let hold_back = (self.params.friction * touch.push / along_surface.length().max(1e-9)).min(1.0);
            contacted.x = pushed - hold_back * along_surface;
            contacted.prev += slid.dot(touch.normal) * touch.normal;
        }
        contacted
    }

    /// The same of an edge that a correction takes from `start` to `end` at the end of a step.
    pub fn keep_edge_out(&self, start: [Vec3; 2], end: [Vec3; 2], along: f32, after: Pose) -> Vec3 {
        let at_end = Self { moments: [self.moments[1]; 2], ..*self };
        let mut x = end[1];
        for capsule in self.capsules.iter().filter(|capsule| capsule.is_thin(&self.params)) {
            let touch = at_end.touch_edge(capsule, start, [end[0], x], along, after, after);
            x += touch.push * touch.normal;
        }
        x
    }

    /// How far the free end of an edge has to be pushed that goes from `start` to `end`. The edge is marched as a vertex
    /// is; from where it meets the collider it stays on that side.
    fn touch_edge(
        &self,
        capsule: &Capsule,
        start: [Vec3; 2],
        end: [Vec3; 2],
        along: f32,
        before: Pose,
        after: Pose,
    ) -> Touch {
        let on_head = capsule.on_head == 1;
        let place = |pose: Pose, p: Vec3| if on_head { pose.apply_inverse(p) } else { p };
        let (from, to) = (start.map(|p| place(before, p)), end.map(|p| place(after, p)));
        let wanted = self.params.margin + self.params.pearl * along;
        let to_now = |now: [f32; 3], before: [f32; 3]| Vec3::from_array(now) - Vec3::from_array(before);
        let (way_a, way_b) = (to_now(capsule.a, capsule.a_before), to_now(capsule.b, capsule.b_before));
        let by_itself = (self.moments[1] - self.moments[0]) * way_a.length().max(way_b.length());
        let way = from[0].distance(to[0]).max(from[1].distance(to[1])) + by_itself;
        let mut nearest = nearest_on_edge(capsule, from, self.moments[0]);
        let mut t = 0.0;
        for _ in 0..MARCH_STEPS {
            let room = nearest.distance - wanted;
            if room < ARRIVED {
                break;
            }
            t += room / way.max(1e-9);
            if t >= 1.0 {
                return Touch { push: 0.0, normal: Vec3::Y, on_head, shift: Vec3::ZERO };
            }
            let moment = self.moments[0] + t * (self.moments[1] - self.moments[0]);
            nearest = nearest_on_edge(capsule, [from[0].lerp(to[0], t), from[1].lerp(to[1], t)], moment);
        }
        let mut side = nearest.normal;
        let mut free = to[1];
        for _ in 0..EDGE_PUSHES {
            nearest = nearest_on_edge(capsule, [to[0], free], self.moments[1]);
            // Gone through, it is nearest the other way round.
            let signed = if nearest.normal.dot(side) < 0.0 { -1.0 } else { 1.0 };
            let far = nearest.distance + nearest.radius;
            let deep = wanted + nearest.radius - signed * far;
            if deep <= 0.0 {
                break;
            }
            side = signed * nearest.normal;
            free += deep / nearest.s.max(LEAST_LEVER) * side;
        }
        let pushed = free - to[1];
        let shift = way_a + nearest.h * (way_b - way_a);
        let world = |v: Vec3| if on_head { rotate(after.rotation, v) } else { v };
        let normal = world(normalize_or_zero(pushed));
        Touch { push: pushed.length(), normal, on_head, shift: world(shift) }
    }
}

impl Capsule {
    /// An edge between two vertices that it keeps out could cut through it. What rests in it could be an edge, and stays.
    fn is_thin(&self, params: &ContactParams) -> bool {
        self.keeps_rest == 0 && self.radius_a.min(self.radius_b) + params.margin < params.thin_below
    }
}

/// The place of an edge that is nearest to a capsule as that is at a share of the frame.
fn nearest_on_edge(capsule: &Capsule, [p, q]: [Vec3; 2], moment: f32) -> NearestOnEdge {
    let (a, b) = capsule.ends_at(moment);
    let s = nearest_on(p, q - p, a, b);
    let (distance, normal, h) = capsule_nearest(a, capsule.radius_a, b, capsule.radius_b, p + s * (q - p));
    NearestOnEdge { distance, normal, s, h, radius: capsule.radius_a + h * (capsule.radius_b - capsule.radius_a) }
}

/// Where on the way from `p` by `way`, 0 to 1, the place is that is nearest to the line from `a` to `b` (Ericson 2005,
/// 5.1.9).
fn nearest_on(p: Vec3, way: Vec3, a: Vec3, b: Vec3) -> f32 {
    let (axis, from_a) = (b - a, p - a);
    let (way_squared, axis_squared) = (way.length_squared(), axis.length_squared());
    let (along_axis, along_way, both) = (axis.dot(from_a), way.dot(from_a), way.dot(axis));
    let across = way_squared * axis_squared - both * both;
    let mut s = 0.0;
    if across > 1e-6 * way_squared * axis_squared {
        s = ((both * along_axis - along_way * axis_squared) / across).clamp(0.0, 1.0);
    }
    // Beyond an end of the line, the place that is nearest to that end.
    let on_axis = both * s + along_axis;
    if on_axis <= 0.0 || on_axis >= axis_squared {
        let to_end = if on_axis <= 0.0 { -along_way } else { both - along_way };
        s = (to_end / way_squared.max(1e-12)).clamp(0.0, 1.0);
    }
    s
}
