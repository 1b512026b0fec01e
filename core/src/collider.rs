//! Shapes beside the head that hair keeps out of: a capsule each, between two balls of any radius; a sphere where both
//! balls are one.
//!
//! A capsule follows the head or stands in the world. An arm, a headband, a shoulder, a chair's back: each is a capsule
//! or two, placed with the mouse, and costs the solver one distance. Boxes and planes were left out: a mesh serves
//! those.

use std::fmt;

use glam::{Affine3A, Vec3};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::look::{Choice, ChoiceInfo, choices};

choices! {
    /// What a collider moves with.
    Attachment {
        Head = "head", "The head", "Moves with the head; its place is in head space";
        World = "world", "The world", "Stays where it is while the head moves";
    }
}

/// Most colliders that a solver looks at, in their order.
pub const MOST_COLLIDERS: usize = 64;
/// Largest coordinate and radius that is taken as it is, centimetres.
const FARTHEST: f32 = 1e5;

/// One capsule or sphere. Files from before there were capsules have `(x, y, z, radius)` for a sphere on the head.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Collider {
    pub name: String,
    /// Whether hair feels it.
    pub on: bool,
    pub attached: Attachment,
    /// Centres of the two balls, centimetres, in the space of what it is attached to; a sphere's are the same.
    pub ends: [Vec3; 2],
    /// Radii of the two balls, centimetres.
    pub radii: [f32; 2],
    /// Hair that rests inside stays where it rests, as on the head itself; otherwise it is pushed out.
    pub keeps_rest: bool,
}

impl Default for Collider {
    fn default() -> Self {
        Self::sphere("sphere", Vec3::ZERO, 4.0)
    }
}

impl Collider {
    pub fn sphere(name: &str, centre: Vec3, radius: f32) -> Self {
        Self::capsule(name, [centre; 2], [radius; 2])
    }

    pub fn capsule(name: &str, ends: [Vec3; 2], radii: [f32; 2]) -> Self {
        Self { name: name.to_owned(), on: true, attached: Attachment::Head, ends, radii, keeps_rest: false }
    }

    pub fn is_sphere(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// Whether its numbers are numbers, so that hair can keep out of it.
    pub fn is_usable(&self) -> bool {
        self.on
            && self.ends.iter().all(|end| end.is_finite() && end.abs().max_element() <= FARTHEST)
            && self.radii.iter().all(|radius| radius.is_finite() && (0.0..=FARTHEST).contains(radius))
    }

    /// From the space of its ends to the world.
    pub fn world_from_ends(&self, world_from_head: &Affine3A) -> Affine3A {
        match self.attached {
            Attachment::Head => *world_from_head,
            Attachment::World => Affine3A::IDENTITY,
        }
    }

    /// Attach it to something else; it stays where it is now.
    pub fn attach(&mut self, to: Attachment, world_from_head: &Affine3A) {
        let world = self.world_from_ends(world_from_head);
        self.attached = to;
        let back = self.world_from_ends(world_from_head).inverse() * world;
        self.ends = self.ends.map(|end| back.transform_point3(end));
    }

    /// Move one end, or all of a sphere.
    pub fn move_end(&mut self, end: usize, by: Vec3) {
        if self.is_sphere() {
            self.shift(by);
        } else {
            self.ends[end] += by;
        }
    }

    pub fn shift(&mut self, by: Vec3) {
        self.ends = self.ends.map(|end| end + by);
    }

    /// Set the radius of one end, centimetres; of both where it is a sphere.
    pub fn set_radius(&mut self, end: usize, radius: f32) {
        let radius = radius.clamp(0.05, 1000.0);
        if self.is_sphere() {
            self.radii = [radius; 2];
        } else {
            self.radii[end] = radius;
        }
    }
}

/// The fields as they are written.
#[derive(Deserialize)]
#[serde(default)]
struct Written {
    name: String,
    on: bool,
    attached: Attachment,
    ends: [Vec3; 2],
    radii: [f32; 2],
    keeps_rest: bool,
}

impl Default for Written {
    fn default() -> Self {
        let Collider { name, on, attached, ends, radii, keeps_rest } = Collider::default();
        Self { name, on, attached, ends, radii, keeps_rest }
    }
}

impl<'de> Deserialize<'de> for Collider {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColliderVisitor)
    }
}

struct ColliderVisitor;

impl<'de> Visitor<'de> for ColliderVisitor {
    type Value = Collider;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a collider with its fields, or the four numbers x, y, z, radius of a sphere")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Collider, A::Error> {
        let Written { name, on, attached, ends, radii, keeps_rest } =
            Written::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Collider { name, on, attached, ends, radii, keeps_rest })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Collider, A::Error> {
        let mut numbers = [0.0_f32; 4];
        for (i, number) in numbers.iter_mut().enumerate() {
            *number = seq.next_element()?.ok_or_else(|| A::Error::invalid_length(i, &self))?;
        }
        let [x, y, z, radius] = numbers;
        // Spheres on the head never pushed hair farther than it rests.
        Ok(Collider { keeps_rest: true, ..Collider::sphere("sphere", Vec3::new(x, y, z), radius) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_of_old_files_open() {
        let old: Vec<Collider> = ron::from_str("[(1.0, -2.0, 3, 4.5)]").unwrap();
        let sphere = Collider::sphere("sphere", Vec3::new(1.0, -2.0, 3.0), 4.5);
        assert_eq!(old, [Collider { keeps_rest: true, ..sphere }]);
        ron::from_str::<Collider>("(1.0, 2.0)").unwrap_err();
    }

    #[test]
    fn a_collider_is_read_as_it_was_written() {
        let mut arm = Collider::capsule("arm", [Vec3::X, Vec3::new(0.0, 2.0, 7.0)], [3.0, 2.5]);
        arm.attached = Attachment::World;
        arm.on = false;
        let text = ron::ser::to_string_pretty(&arm, ron::ser::PrettyConfig::new().depth_limit(7)).unwrap();
        assert_eq!(ron::from_str::<Collider>(&text).unwrap(), arm, "{text}");
        assert_eq!(ron::from_str::<Collider>("(name: \"sphere\")").unwrap(), Collider::default());
    }

    #[test]
    fn attaching_it_to_something_else_leaves_it_in_its_place() {
        let world_from_head = Affine3A::from_rotation_x(0.4) * Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
        let mut arm = Collider::capsule("arm", [Vec3::X, Vec3::Z * 9.0], [1.0; 2]);
        let seen = |arm: &Collider| arm.ends.map(|end| arm.world_from_ends(&world_from_head).transform_point3(end));
        let before = seen(&arm);
        arm.attach(Attachment::World, &world_from_head);
        assert!(before.iter().zip(seen(&arm)).all(|(a, b)| a.distance(b) < 1e-5));
        arm.attach(Attachment::Head, &world_from_head);
        assert!(arm.ends[0].distance(Vec3::X) < 1e-5 && arm.ends[1].distance(Vec3::Z * 9.0) < 1e-5);
    }

    #[test]
    fn numbers_that_are_none_are_not_used() {
        let mut ball = Collider::sphere("ball", Vec3::ZERO, 2.0);
        assert!(ball.is_usable());
        ball.radii[1] = f32::NAN;
        assert!(!ball.is_usable());
        assert!(!Collider::sphere("ball", Vec3::splat(f32::INFINITY), 1.0).is_usable());
        assert!(!Collider { on: false, ..Collider::default() }.is_usable());
    }
}
