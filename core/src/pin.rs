//! Hair pins, clips and bands: balls fixed to the head that hold to its place whatever hair lies in them.
//!
//! A pin is placed where it is seen, in the style; what lies in it is found again each time hair is made ready to move, so
//! that it holds other hair once it is dragged elsewhere. A list of held vertices was rejected: it would be wrong after
//! every change of the hair.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::groom::{Groom, Source};
use crate::mesh_query::MeshQuery;

/// Largest coordinate and radius that is taken as it is, centimetres.
const FARTHEST: f32 = 1e5;
/// Smallest and largest radius that a person can set, centimetres.
pub const RADII: (f32, f32) = (0.1, 30.0);

/// Hair so near to a ray is seen where it goes, centimetres: a hair mesh has its vertices a few centimetres apart.
const NEAR: f32 = 3.0;

/// One ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Pin {
    pub name: String,
    /// Whether it holds hair.
    pub on: bool,
    /// Head space, centimetres.
    pub centre: Vec3,
    /// Centimetres.
    pub radius: f32,
}

impl Default for Pin {
    fn default() -> Self {
        Self { name: "Pin".to_owned(), on: true, centre: Vec3::ZERO, radius: 1.5 }
    }
}

impl Pin {
    /// Whether its numbers are numbers, so that it can hold hair.
    pub fn is_usable(&self) -> bool {
        let is_in = |number: f32| number.is_finite() && number.abs() <= FARTHEST;
        self.on && self.centre.to_array().into_iter().all(is_in) && is_in(self.radius) && self.radius > 0.0
    }

    pub fn set_radius(&mut self, radius: f32) {
        self.radius = radius.clamp(RADII.0, RADII.1);
    }

    /// How much of each vertex of a curve it holds, 0-1: all of what lies in it; where an edge leads into it, its end
    /// outside by how near that is to the ball, in edges, so that a curve with few vertices is held where it passes.
    pub fn shares(&self, curve: &[Vec3]) -> Vec<f32> {
        let mut shares = vec![0.0_f32; curve.len()];
        for (share, &place) in shares.iter_mut().zip(curve) {
            if place.distance(self.centre) <= self.radius {
                *share = 1.0;
            }
        }
        for (k, ends) in curve.windows(2).enumerate() {
            if let Some([enters, leaves]) = self.within([ends[0], ends[1]]) {
                shares[k] = shares[k].max(1.0 - enters);
                shares[k + 1] = shares[k + 1].max(leaves);
            }
        }
        shares
    }

    /// Where an edge enters the ball and leaves it, in shares of its length; `None` where it passes.
    fn within(&self, [a, b]: [Vec3; 2]) -> Option<[f32; 2]> {
        let (along, to_centre) = (b - a, self.centre - a);
        let squared = along.length_squared();
        if squared < 1e-12 {
            return None;
        }
        let middle = to_centre.dot(along) / squared;
        let half_squared = (self.radius * self.radius - (to_centre - middle * along).length_squared()) / squared;
        if half_squared < 0.0 {
            return None;
        }
        let (enters, leaves) = ((middle - half_squared.sqrt()).max(0.0), (middle + half_squared.sqrt()).min(1.0));
        (enters <= leaves).then_some([enters, leaves])
    }
}

/// Where a ray meets the style or the head first: the place for a pin that is put where a person looks. `direction` is a
/// unit vector, all in head space.
pub fn place_seen(groom: &Groom, origin: Vec3, direction: Vec3) -> Option<Vec3> {
    let head = groom.head.as_ref().and_then(|head| MeshQuery::new(&head.mesh).ok());
    let mut nearest = head.and_then(|head| head.ray(origin, direction)).map(|hit| hit.distance);
    let mut see = |places: &[Vec3]| {
        for &place in places {
            let along = (place - origin).dot(direction);
            let is_near = (place - origin - along * direction).length() <= NEAR;
            if along > 0.0 && is_near && nearest.is_none_or(|nearest| along < nearest) {
                nearest = Some(along);
            }
        }
    };
    for layer in groom.layers.iter().filter(|layer| layer.visible) {
        match &layer.source {
            Source::Guides(strands) | Source::Strands(strands) => see(&strands.points),
            Source::HairMesh(mesh) => mesh.layers.iter().for_each(|layer| see(&layer.positions)),
        }
    }
    nearest.map(|along| origin + along * direction)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::groom::{Head, Layer};
    use crate::mesh_query::tests::sphere;
    use crate::strands::Strands;

    #[test]
    fn a_place_is_seen_on_hair_before_the_head_and_on_the_head_before_hair_behind_it() {
        let mut strands = Strands::default();
        strands.push(&[Vec3::new(0.0, 0.0, 12.0), Vec3::new(0.0, -5.0, 13.0)]);
        strands.push(&[Vec3::new(14.0, 0.0, 0.0), Vec3::new(14.0, -5.0, 0.0)]);
        let mut groom = Groom { layers: vec![Layer::new("a", Source::Guides(Arc::new(strands)))], ..Groom::default() };
        groom.head = Some(Head { mesh: Arc::new(sphere(Vec3::ZERO, 10.0, 16)), ..Head::default() });
        let seen = |groom: &Groom, direction: Vec3| place_seen(groom, -60.0 * direction, direction);
        assert_eq!(seen(&groom, Vec3::NEG_Z), Some(Vec3::Z * 12.0));
        let on_head = seen(&groom, Vec3::X).unwrap();
        assert!(on_head.distance(Vec3::NEG_X * 10.0) < 0.3, "{on_head}");
        groom.layers[0].visible = false;
        assert!(seen(&groom, Vec3::NEG_Z).unwrap().distance(Vec3::Z * 10.0) < 0.3);
        groom.head = None;
        assert_eq!(seen(&groom, Vec3::NEG_Z), None);
    }

    #[test]
    fn what_lies_in_it_is_held_and_edges_that_pass_hold_their_ends() {
        let pin = Pin { centre: Vec3::new(0.0, -5.0, 0.0), radius: 1.2, ..Pin::default() };
        let fine: Vec<Vec3> = (0..11).map(|k| Vec3::NEG_Y * k as f32).collect();
        let shares = pin.shares(&fine);
        assert_eq!(shares[4..7], [1.0; 3]);
        assert!((shares[3] - 0.2).abs() < 1e-5 && (shares[7] - 0.2).abs() < 1e-5, "{shares:?}");
        assert!(shares[..3].iter().chain(&shares[8..]).all(|share| *share == 0.0), "{shares:?}");
        // Through the middle of one long edge, nearer to its end.
        let coarse = pin.shares(&[Vec3::ZERO, Vec3::NEG_Y * 8.0, Vec3::NEG_Y * 16.0]);
        assert!((coarse[0] - 0.525).abs() < 1e-5 && (coarse[1] - 0.775).abs() < 1e-5 && coarse[2] == 0.0, "{coarse:?}");
        let beside: Vec<Vec3> = fine.iter().map(|p| p + 1.3 * Vec3::X).collect();
        assert_eq!(pin.shares(&beside), [0.0; 11]);
        assert_eq!(pin.shares(&[Vec3::ZERO; 3]), [0.0; 3]);
        assert_eq!(pin.shares(&[]), [0.0; 0]);
    }

    #[test]
    fn numbers_that_are_none_hold_nothing() {
        assert!(Pin::default().is_usable());
        for wrong in [
            Pin { on: false, ..Pin::default() },
            Pin { centre: Vec3::NAN, ..Pin::default() },
            Pin { radius: f32::INFINITY, ..Pin::default() },
            Pin { radius: 0.0, ..Pin::default() },
        ] {
            assert!(!wrong.is_usable(), "{wrong:?}");
        }
    }

    #[test]
    fn what_is_left_out_is_as_it_is_by_default() {
        let pin: Pin = ron::from_str("(name: \"temple\", centre: (1.0, 2.0, 3.0))").unwrap();
        assert_eq!(pin, Pin { name: "temple".to_owned(), centre: Vec3::new(1.0, 2.0, 3.0), ..Pin::default() });
    }
}
