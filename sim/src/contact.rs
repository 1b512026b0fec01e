//! What hair keeps out of: the head as a distance field, and spheres. Twin of `sim_contact.wgsl`: same names, same order.

use glam::Vec3;
use lorelei_core::distance_field::DistanceField;
use lorelei_core::simulation::SimulationSettings;

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
    pub n_spheres: u32,
    /// Kept between hair and obstacles, cm.
    pub margin: f32,
    /// Coulomb coefficient.
    pub friction: f32,
    pub pad: [u32; 2],
}

impl ContactParams {
    /// Settings from a file can be anything: what is not finite becomes the default, the rest is bounded.
    pub fn new(field: Option<&DistanceField>, settings: &SimulationSettings) -> Self {
        let default = SimulationSettings::default();
        Self {
            field_min: field.map_or([0.0; 3], |field| field.min.to_array()),
            field_cell: field.map_or(1.0, |field| field.cell),
            field_n: field.map_or([0; 3], |field| field.n),
            n_spheres: settings.spheres.len() as u32,
            margin: bounded(settings.collision_margin, default.collision_margin, 0.0, 10.0),
            friction: bounded(settings.friction, default.friction, 0.0, 100.0),
            pad: [0; 2],
        }
    }
}

/// Rest distance where there is nothing to collide with.
pub(crate) const NOTHING_NEAR: f32 = 1e9;

/// The head and the spheres that hair keeps out of, in head space.
#[derive(Debug, Clone, Copy)]
pub struct Obstacles<'a> {
    pub field: Option<&'a DistanceField>,
    /// Centre and radius, centimetres.
    pub spheres: &'a [[f32; 4]],
    pub params: ContactParams,
}

impl<'a> Obstacles<'a> {
    pub fn new(field: Option<&'a DistanceField>, settings: &'a SimulationSettings) -> Self {
        Self { field, spheres: &settings.spheres, params: ContactParams::new(field, settings) }
    }

    /// Push a vertex at `x` (world) out to the margin, or to where it rests if that is nearer; returns it and where it was
    /// a step before. A contact takes the velocity along its normal and, by Coulomb's law, some of that along the
    /// surface; it never adds any.
    pub fn collide(&self, x: Vec3, prev: Vec3, rest_distance: f32, before: Pose, after: Pose) -> (Vec3, Vec3) {
        let (distance, normal_in_head) = self.distance_and_normal(after.apply_inverse(x));
        let push = self.params.margin.min(rest_distance) - distance;
        if push <= 0.0 {
            return (x, prev);
        }
        let carry = after.after_inverse_of(&before);
        let normal = rotate(after.rotation, normal_in_head);
        let pushed = x + push * normal;
        let slid = pushed - carry.apply(prev);
        let along = slid - slid.dot(normal) * normal;
        let hold_back = (self.params.friction * push / along.length().max(1e-9)).min(1.0);
        (pushed - hold_back * along, prev + slid.dot(normal) * normal)
    }

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
