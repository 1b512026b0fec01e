//! What hair keeps out of: the head as a distance field, and colliders. Twin of `sim_contact.wgsl`: same names, same order.
//!
//! **How far.** A vertex keeps `margin` away, and with pearls a radius more that grows along the strand, so that a lock
//! keeps its thickness and no collider slips between two vertices. From the head, and from colliders that leave
//! resting hair alone, it never keeps farther than it rests: a groom at rest stays at rest, roots and all.
//!
//! **Which.** Of all obstacles the one that it is deepest in pushes. Hair slides along it under Coulomb's law, against
//! the surface as that moves: with the head, or under the mouse that drags a collider.
//!
//! **How fast.** In a step of 1/240 s a shaken tip goes 12 cm, through a neck. A vertex whose way in a step, seen from
//! the obstacles, is longer than half of the thinnest of them is marched along it: the distance says how far it can go
//! without meeting anything. Where it meets something, the rest of the way goes along the surface. Smaller steps for
//! all were rejected: every strand would pay for the fastest.
//!
//! **How thin.** Colliders that would slip between two vertices: sim/src/edge.rs.

use glam::{Quat, Vec3};
use lorelei_core::collider::{Attachment, MOST_COLLIDERS};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::simulation::{Pearl, SimulationSettings};

use crate::bounded;
use crate::pose::{Pose, rotate};

/// Numbers of contacts. Layout of `ContactParams` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ContactParams {
    /// First node of the head's distance field, head space.
    pub field_min: [f32; 3],
    /// cm.
    pub field_cell: f32,
    /// Nodes of the field; 0 where there is none.
    pub field_n: [u32; 3],
    pub n_capsules: u32,
    /// Kept between hair and obstacles, cm.
    pub margin: f32,
    /// Coulomb coefficient.
    pub friction: f32,
    /// Radius of hair at the tip, cm; from the root it grows evenly.
    pub pearl: f32,
    /// Shortest way in a step that is marched, cm.
    pub march_from: f32,
    /// Farthest way of a collider in a frame, cm.
    pub capsule_way: f32,
    /// Colliders are thin that keep hair no farther than this from their axis, cm: the longest edge of a strand.
    pub thin_below: f32,
    pub pad: [u32; 2],
}

/// A collider that is on. Layout of `Capsule` in WGSL. Centimetres, head space or world.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Capsule {
    pub a: [f32; 3],
    pub radius_a: f32,
    pub b: [f32; 3],
    pub radius_b: f32,
    /// Where `a` was a frame before.
    pub a_before: [f32; 3],
    /// 1: in head space.
    pub on_head: u32,
    pub b_before: [f32; 3],
    /// 1: hair that rests inside stays.
    pub keeps_rest: u32,
}

/// The colliders that hair keeps out of, at rest.
pub fn capsules_of(settings: &SimulationSettings) -> Vec<Capsule> {
    let usable = settings.colliders.iter().filter(|collider| collider.is_usable()).take(MOST_COLLIDERS);
    usable
        .map(|collider| {
            let [a, b] = collider.ends.map(|end| end.to_array());
            let on_head = collider.attached == Attachment::Head;
            Capsule {
                a,
                radius_a: collider.radii[0],
                b,
                radius_b: collider.radii[1],
                a_before: a,
                on_head: u32::from(on_head),
                b_before: b,
                // What stands in the world has no hair that rests in it.
                keeps_rest: u32::from(on_head && collider.keeps_rest),
            }
        })
        .collect()
}

/// Let capsules come from where `before` are: what was dragged since then has moved. Where their number or what they
/// are on has changed, they appear.
pub fn come_from(capsules: &mut [Capsule], before: &[Capsule]) {
    let is_same = capsules.len() == before.len() && capsules.iter().zip(before).all(|(c, b)| c.on_head == b.on_head);
    for (idx, capsule) in capsules.iter_mut().enumerate() {
        (capsule.a_before, capsule.b_before) =
            if is_same { (before[idx].a_before, before[idx].b_before) } else { (capsule.a, capsule.b) };
    }
}

/// The frame has passed: nothing has moved since.
pub fn arrive(capsules: &mut [Capsule]) {
    for capsule in capsules {
        (capsule.a_before, capsule.b_before) = (capsule.a, capsule.b);
    }
}

/// A field as `field_sample` in WGSL reads it: of every node its value and those of the next along x, along y, and along both, so
/// that two reads give a cell. Beyond the last node that node's.
pub(crate) fn faces_of(field: &DistanceField) -> Vec<[f32; 4]> {
    let [nx, ny, nz] = field.n.map(|n| n as usize);
    let faces = |(y, z): (usize, usize)| {
        let value = move |x: usize, y: usize| field.values[x.min(nx - 1) + nx * (y.min(ny - 1) + ny * z)];
        (0..nx).map(move |x| [value(x, y), value(x + 1, y), value(x, y + 1), value(x + 1, y + 1)])
    };
    (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z))).flat_map(faces).collect()
}

/// Rest distance where there is nothing to collide with.
pub(crate) const NOTHING_NEAR: f32 = 1e9;
/// Places that a march looks at.
pub(crate) const MARCH_STEPS: u32 = 16;
/// The direction away from the head is asked for from here on, centimetres.
const NEAR: f32 = 1.0;
/// A march has arrived this near, centimetres.
pub(crate) const ARRIVED: f32 = 0.01;

/// Most that the distance to an obstacle changes with the place: between nodes whose values change by no more than their
/// distance, the trilinear one by the square root of three. What is farther from a contact than this times its way meets none,
/// and need not ask.
pub(crate) const STEEPEST: f32 = 1.8;

/// A vertex after a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contacted {
    /// World.
    pub x: Vec3,
    /// Where it was a step before, so that what is between is its velocity.
    pub prev: Vec3,
    /// How far it is from a contact, cm.
    pub room: f32,
}

/// What a vertex lies on, or is about to, for a law that reckons with it in its step. Displacements are of that step, and
/// relative to going with the head.
#[derive(Debug, Clone, Copy)]
pub struct Barrier {
    /// Away from it, world; a unit vector, or zero where the distance field is flat or far.
    pub normal: Vec3,
    /// How far the vertex has to go along it at least, cm; negative: how far it is from a contact.
    pub push: f32,
    /// How far the surface goes there, world, cm.
    pub goes: Vec3,
}

/// The head and the colliders that hair keeps out of.
#[derive(Debug, Clone, Copy)]
pub struct Obstacles<'a> {
    /// Head space.
    pub field: Option<&'a DistanceField>,
    pub capsules: &'a [Capsule],
    pub params: ContactParams,
    /// The step's beginning and end as shares of its frame.
    pub moments: [f32; 2],
}

/// How deep a vertex is in what it is deepest in.
#[derive(Debug, Clone, Copy)]
pub struct Touch {
    /// How far it has to be pushed, cm; negative: how far it is from a contact.
    pub push: f32,
    /// Away from the obstacle, world; a unit vector, or zero where the distance field is flat.
    pub normal: Vec3,
    pub on_head: bool,
    /// How far the place has moved by itself in the frame, world.
    pub shift: Vec3,
}

impl<'a> Obstacles<'a> {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(field: Option<&'a DistanceField>, capsules: &'a [Capsule], settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        let margin = bounded(settings.collision_margin, default.collision_margin, 0.0, 10.0);
        let pearl = match settings.pearl {
            Pearl::Off => 0.0,
            Pearl::Growing => bounded(settings.pearl_radius, default.pearl_radius, 0.0, 10.0),
        };
        // The head is thick, but for what sticks out of it.
        let thinnest = field.map_or(NOTHING_NEAR, |field| 2.0 * field.cell);
        let thinnest = capsules.iter().map(|c| c.radius_a.min(c.radius_b) + margin).fold(thinnest, f32::min);
        let way = |capsule: &Capsule| {
            let way = |at: [f32; 3], before: [f32; 3]| Vec3::from_array(at).distance(Vec3::from_array(before));
            way(capsule.a, capsule.a_before).max(way(capsule.b, capsule.b_before))
        };
        let params = ContactParams {
            field_min: field.map_or([0.0; 3], |field| field.min.to_array()),
            field_cell: field.map_or(1.0, |field| field.cell),
            field_n: field.map_or([0; 3], |field| field.n),
            n_capsules: capsules.len() as u32,
            margin,
            friction: bounded(settings.friction, default.friction, 0.0, 100.0),
            pearl,
            march_from: 0.5 * thinnest,
            capsule_way: capsules.iter().map(way).fold(0.0, f32::max),
            thin_below: 0.0,
            pad: [0; 2],
        };
        Self { field, capsules, params, moments: [1.0; 2] }
    }

    /// As they are in one of a frame's steps.
    pub fn at_step(self, step: usize, n_steps: usize) -> Self {
        let share = |step: usize| step as f32 / n_steps.max(1) as f32;
        Self { moments: [share(step), share(step + 1)], ..self }
    }

    /// Keep a vertex at `x` (world) out. A contact takes the velocity along its normal and, by Coulomb's law, some of that along the surface;
    /// it never adds any. `along`: where on the strand, 0 root to 1 tip.
    pub fn collide(&self, x: Vec3, prev: Vec3, rest_distance: f32, along: f32, before: Pose, after: Pose) -> Contacted {
        if self.field.is_none() && self.capsules.is_empty() {
            return Contacted { x, prev, room: NOTHING_NEAR };
        }
        let x = self.march(x, prev, rest_distance, along, before, after);
        let in_head = after.apply_inverse(x);
        let touch = self.touch(x, in_head, after.rotation, self.moments[1], rest_distance, along, 0.0);
        if touch.push <= 0.0 {
            return Contacted { x, prev, room: -touch.push };
        }
        let carried = self.carried(touch, prev, before, after);
        let pushed = x + touch.push * touch.normal;
        let slid = pushed - carried;
        let along_surface = slid - slid.dot(touch.normal) * touch.normal;
        let hold_back = (self.params.friction * touch.push / along_surface.length().max(1e-9)).min(1.0);
        let x = pushed - hold_back * along_surface;
        Contacted { x, prev: prev + slid.dot(touch.normal) * touch.normal, room: 0.0 }
    }

    /// What a vertex is nearest to or deepest in that would go with the head from `prev` to `carried`; its normal is known
    /// where it is nearer than `near`.
    pub fn barrier(
        &self,
        prev: Vec3,
        carried: Vec3,
        rest_distance: f32,
        along: f32,
        after: Pose,
        near: f32,
    ) -> Barrier {
        let in_head = after.apply_inverse(carried);
        let touch = self.touch(carried, in_head, after.rotation, self.moments[1], rest_distance, along, near);
        let stays = if touch.on_head { Vec3::ZERO } else { prev - carried };
        let goes = stays + (self.moments[1] - self.moments[0]) * touch.shift;
        Barrier { normal: touch.normal, push: touch.push, goes }
    }

    /// How far a vertex goes in a step as any obstacle sees it; with the head it would have gone to `carried`.
    pub fn way(&self, x: Vec3, prev: Vec3, carried: Vec3) -> f32 {
        let by_itself = self.params.capsule_way * (self.moments[1] - self.moments[0]);
        x.distance(carried).max(if self.capsules.is_empty() { 0.0 } else { x.distance(prev) }) + by_itself
    }

    /// Keep out a vertex that a correction takes from `start` to `x` at the end of a step; what it has to do with
    /// velocities is the caller's. Solvers end with it: else closing a length could carry hair through what it met.
    pub fn keep_out(&self, start: Vec3, x: Vec3, rest_distance: f32, along: f32, after: Pose) -> Vec3 {
        if self.field.is_none() && self.capsules.is_empty() {
            return x;
        }
        let at_end = Self { moments: [self.moments[1]; 2], ..*self };
        let x = at_end.march(x, start, rest_distance, along, after, after);
        let touch = self.touch(x, after.apply_inverse(x), after.rotation, self.moments[1], rest_distance, along, 0.0);
        if touch.push <= 0.0 { x } else { x + touch.push * touch.normal }
    }

    /// Where `x` is once it went from `prev` without going through anything.
    fn march(&self, x: Vec3, prev: Vec3, rest_distance: f32, along: f32, before: Pose, after: Pose) -> Vec3 {
        let (from_head, to_head) = (before.apply_inverse(prev), after.apply_inverse(x));
        let by_itself = self.params.capsule_way * (self.moments[1] - self.moments[0]);
        let way = from_head.distance(to_head).max(if self.capsules.is_empty() { 0.0 } else { x.distance(prev) });
        let way = way + by_itself;
        if way <= self.params.march_from {
            return x;
        }
        let mut t = 0.0;
        for step in 0..MARCH_STEPS {
            let moment = self.moments[0] + t * (self.moments[1] - self.moments[0]);
            let (at, in_head) = (prev + t * (x - prev), from_head + t * (to_head - from_head));
            let touch = self.touch(at, in_head, after.rotation, moment, rest_distance, along, NEAR);
            // A march past something close that takes too long goes on along it.
            if touch.push > -ARRIVED || step + 1 == MARCH_STEPS {
                // Seen from the obstacle: where it would be had it not moved, and what is left of the way.
                let origin = self.carried(touch, prev, before, after);
                let left = (1.0 - t) * (x - origin);
                let inwards = left.dot(touch.normal).min(0.0);
                return origin + t * (x - origin) + left - inwards * touch.normal;
            }
            t -= touch.push / way;
            if t >= 1.0 {
                return x;
            }
        }
        x
    }

    /// Where a place on what is touched has gone in the step.
    pub(crate) fn carried(&self, touch: Touch, place: Vec3, before: Pose, after: Pose) -> Vec3 {
        let carried = if touch.on_head { after.after_inverse_of(&before).apply(place) } else { place };
        carried + (self.moments[1] - self.moments[0]) * touch.shift
    }

    /// The obstacle that a vertex at `x` in the world, `in_head` in the head's space, is deepest in; the direction away from
    /// the head where it is nearer to a contact than `near`.
    #[expect(clippy::too_many_arguments, reason = "a vertex, a moment of its step, and what is asked")]
    pub fn touch(
        &self,
        x: Vec3,
        in_head: Vec3,
        rotation: Quat,
        moment: f32,
        rest_distance: f32,
        along: f32,
        near: f32,
    ) -> Touch {
        let wanted = self.params.margin + self.params.pearl * along;
        let mut deepest = Touch { push: -NOTHING_NEAR, normal: Vec3::Y, on_head: true, shift: Vec3::ZERO };
        if let Some(field) = self.field {
            deepest.push = wanted.min(rest_distance) - field.sample(in_head).min(NOTHING_NEAR);
            // Its gradient is asked for where it is needed.
            if deepest.push > -near {
                deepest.normal = rotate(rotation, field.gradient(in_head).normalize_or_zero());
            }
        }
        for capsule in self.capsules {
            let on_head = capsule.on_head == 1;
            let place = if on_head { in_head } else { x };
            let (a, b) = capsule.ends_at(moment);
            let (distance, normal, h) = capsule_nearest(a, capsule.radius_a, b, capsule.radius_b, place);
            let kept = if capsule.keeps_rest == 1 { wanted.min(rest_distance) } else { wanted };
            if kept - distance > deepest.push {
                let to = |now: [f32; 3], before: [f32; 3]| Vec3::from_array(now) - Vec3::from_array(before);
                let (way_a, way_b) = (to(capsule.a, capsule.a_before), to(capsule.b, capsule.b_before));
                let shift = way_a + h * (way_b - way_a);
                deepest = Touch { push: kept - distance, normal, on_head, shift };
                if on_head {
                    deepest.normal = rotate(rotation, normal);
                    deepest.shift = rotate(rotation, shift);
                }
            }
        }
        deepest
    }

    /// Distance to what hair may rest in, head space.
    pub fn rest_distance(&self, p: Vec3) -> f32 {
        let to_field = self.field.map_or(NOTHING_NEAR, |field| field.sample(p).min(NOTHING_NEAR));
        let resting = self.capsules.iter().filter(|capsule| capsule.keeps_rest == 1);
        resting.map(|capsule| capsule.distance(p)).fold(to_field, f32::min)
    }

    /// How much deeper than the surface, and than it rests, a place in the world is; negative outside.
    pub fn depth(&self, x: Vec3, pose: Pose, rest_distance: f32) -> f32 {
        let in_head = pose.apply_inverse(x);
        let resting = rest_distance.min(0.0) - self.rest_distance(in_head);
        let pushing = self.capsules.iter().filter(|capsule| capsule.keeps_rest == 0);
        pushing.map(|c| -c.distance(if c.on_head == 1 { in_head } else { x })).fold(resting, f32::max)
    }
}

impl Capsule {
    /// Where its ends are at a share of the frame.
    pub(crate) fn ends_at(&self, moment: f32) -> (Vec3, Vec3) {
        let at = |now: [f32; 3], before: [f32; 3]| {
            let (now, before) = (Vec3::from_array(now), Vec3::from_array(before));
            before + moment * (now - before)
        };
        (at(self.a, self.a_before), at(self.b, self.b_before))
    }

    pub(crate) fn distance(&self, p: Vec3) -> f32 {
        capsule_nearest(Vec3::from_array(self.a), self.radius_a, Vec3::from_array(self.b), self.radius_b, p).0
    }
}

/// Distance from two balls and the cone that touches both, the direction away, and where between the balls, 0 to 1.
///
/// Every place of the surface belongs to a ball between the two; the one that is nearest is found at the foot of the
/// perpendicular to the cone, which leans by as much as the cone narrows.
pub fn capsule_nearest(a: Vec3, radius_a: f32, b: Vec3, radius_b: f32, p: Vec3) -> (f32, Vec3, f32) {
    let axis = b - a;
    let squared = axis.length_squared();
    let thinner = radius_a - radius_b;
    // Where one ball holds the other there is nothing between.
    let mut h = if thinner < 0.0 { 1.0 } else { 0.0 };
    let slant = squared - thinner * thinner;
    if slant > 1e-10 {
        let length = squared.sqrt();
        let y = (p - a).dot(axis) / length;
        let across = (p - a - axis * (y / length)).length();
        h = ((y - across * thinner / slant.sqrt()) / length).clamp(0.0, 1.0);
    }
    let from_axis = p - a - h * axis;
    let far = from_axis.length();
    let normal = if far > 1e-9 { from_axis / far } else { Vec3::Y };
    (far - (radius_a + h * (radius_b - radius_a)), normal, h)
}

#[cfg(test)]
mod tests {
    use lorelei_core::collider::Collider;

    use super::*;

    #[test]
    fn a_capsules_distance_is_that_to_the_nearest_of_its_balls() {
        let (a, b) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(4.0, 5.0, -2.0));
        for (radius_a, radius_b) in [(1.0, 1.0), (2.5, 0.5), (0.1, 3.0), (9.0, 1.0)] {
            for i in 0..200 {
                let p = Vec3::new((i * 7 % 23) as f32 - 9.0, (i * 5 % 17) as f32 - 6.0, (i * 3 % 19) as f32 - 9.0);
                let (distance, normal, h) = capsule_nearest(a, radius_a, b, radius_b, p);
                // One of a thousand balls between the two.
                let nearest = (0..=1000)
                    .map(|j| j as f32 / 1000.0)
                    .map(|t| p.distance(a.lerp(b, t)) - (radius_a + t * (radius_b - radius_a)))
                    .fold(f32::INFINITY, f32::min);
                assert!((distance - nearest).abs() < 2e-3, "{p}: {distance} against {nearest}");
                let there = capsule_nearest(a, radius_a, b, radius_b, p - distance * normal);
                assert!(there.0.abs() < 1e-3 || distance < 0.0, "{p}: {normal} at {h} leads to {}", there.0);
            }
        }
    }

    #[test]
    fn what_is_dragged_comes_from_where_it_was() {
        let at = |x: f32| SimulationSettings {
            colliders: vec![Collider::sphere("ball", Vec3::new(x, 0.0, 0.0), 1.0)],
            ..SimulationSettings::default()
        };
        let before = capsules_of(&at(1.0));
        let mut now = capsules_of(&at(3.0));
        come_from(&mut now, &before);
        assert_eq!(now[0].a_before, [1.0, 0.0, 0.0]);
        assert_eq!(Obstacles::new(None, &now, &at(3.0)).params.capsule_way, 2.0);
        // A new one has come from nowhere.
        come_from(&mut now, &[]);
        assert_eq!(now[0].a_before, [3.0, 0.0, 0.0]);
    }
}
