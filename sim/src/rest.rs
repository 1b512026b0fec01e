//! What the solver compares with: every vertex at rest in head space, and how far from the head it rests.

use glam::{Vec3, Vec4};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use rayon::prelude::*;

/// Contacts begin this much closer than the rest distance, so that rounding makes none at rest, centimetres.
const SLACK: f32 = 1e-3;
/// Rest distance where there is nothing to collide with.
pub(crate) const NOTHING_NEAR: f32 = 1e9;

/// The head and the spheres that hair keeps out of, in head space.
#[derive(Debug, Clone, Copy)]
pub struct Obstacles<'a> {
    pub field: Option<&'a DistanceField>,
    /// Centre and radius, centimetres.
    pub spheres: &'a [[f32; 4]],
}

impl Obstacles<'_> {
    /// Distance to the nearest obstacle and the direction away from it (a unit vector, or zero where the
    /// distance field is flat).
    pub fn distance_and_normal(&self, p: Vec3) -> (f32, Vec3) {
        let (mut distance, mut normal) = (NOTHING_NEAR, Vec3::Y);
        if let Some(field) = self.field {
            distance = field.sample(p).min(NOTHING_NEAR);
            normal = field.gradient(p).normalize_or_zero();
        }
        for &[x, y, z, radius] in self.spheres {
            let from_centre = p - Vec3::new(x, y, z);
            let to_sphere = from_centre.length() - radius;
            if to_sphere < distance {
                distance = to_sphere;
                normal = from_centre.normalize_or(Vec3::Y);
            }
        }
        (distance, normal)
    }

    /// As [`Obstacles::distance_and_normal`], the distance alone.
    pub fn distance(&self, p: Vec3) -> f32 {
        let to_field = self.field.map_or(NOTHING_NEAR, |field| field.sample(p).min(NOTHING_NEAR));
        self.spheres.iter().map(|&[x, y, z, radius]| p.distance(Vec3::new(x, y, z)) - radius).fold(to_field, f32::min)
    }
}

/// Guides at rest. Vertex `k` of guide `g` is `vertices[g * n_vertices + k]`: xyz its position in head space,
/// w the distance from the obstacles at which it rests, less a slack; it is never pushed farther than that.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rest {
    pub n_vertices: u32,
    pub vertices: Vec<Vec4>,
}

impl Rest {
    /// Positions that are not finite become the origin: the solver cannot fail.
    pub fn new(guides: &GuideSet, obstacles: Obstacles<'_>) -> Self {
        let vertices = guides
            .positions
            .par_iter()
            .map(|&p| {
                let p = if p.is_finite() { p } else { Vec3::ZERO };
                p.extend(obstacles.distance(p) - SLACK)
            })
            .collect();
        Self { n_vertices: guides.n_vertices, vertices }
    }

    pub fn n_guides(&self) -> usize {
        self.vertices.len().checked_div(self.n_vertices as usize).unwrap_or(0)
    }
}
