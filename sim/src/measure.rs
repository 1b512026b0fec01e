//! How well a solver keeps its laws: lengths, depth in the head, energy, and whether every number is finite.

use std::ops::Range;

use glam::{Vec4, Vec4Swizzles};
use rayon::prelude::*;

use crate::contact::Obstacles;
use crate::pose::Pose;
use crate::rest::Rest;
use crate::rod::N_PINNED;

/// Some strands, or several of these taken together with [`Measure::and`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// Root mean square of each edge's length over its rest length, less 1.
    pub length_error_rms: f32,
    pub length_error_max: f32,
    /// How much deeper than the surface, and than it rests, the deepest vertex is.
    pub penetration_max_cm: f32,
    /// Mean over the free vertices of half the speed squared, erg/g.
    pub kinetic_energy: f32,
    /// Fastest vertex, cm/s.
    pub speed_max: f32,
    /// Root mean square of the distance to where the rest pose would be, cm.
    pub from_rest_rms_cm: f32,
    /// Vertices with a coordinate that is not finite.
    pub n_not_finite: usize,
    /// Free vertices measured.
    pub n_vertices: usize,
}

impl Default for Measure {
    fn default() -> Self {
        Self {
            length_error_rms: 0.0,
            length_error_max: 0.0,
            penetration_max_cm: 0.0,
            kinetic_energy: 0.0,
            speed_max: 0.0,
            from_rest_rms_cm: 0.0,
            n_not_finite: 0,
            n_vertices: 0,
        }
    }
}

impl Measure {
    /// Two layers, or two parts of one, taken together.
    pub fn and(&self, other: &Self) -> Self {
        let n = self.n_vertices + other.n_vertices;
        let mean = |a: f32, b: f32| (a * self.n_vertices as f32 + b * other.n_vertices as f32) / n.max(1) as f32;
        let rms = |a: f32, b: f32| mean(a * a, b * b).sqrt();
        Self {
            length_error_rms: rms(self.length_error_rms, other.length_error_rms),
            length_error_max: self.length_error_max.max(other.length_error_max),
            penetration_max_cm: self.penetration_max_cm.max(other.penetration_max_cm),
            kinetic_energy: mean(self.kinetic_energy, other.kinetic_energy),
            speed_max: self.speed_max.max(other.speed_max),
            from_rest_rms_cm: rms(self.from_rest_rms_cm, other.from_rest_rms_cm),
            n_not_finite: self.n_not_finite + other.n_not_finite,
            n_vertices: n,
        }
    }
}

/// Measure positions (world) against those one step before and against rest.
pub fn measure(
    rest: &Rest,
    obstacles: Obstacles<'_>,
    pose: Pose,
    positions: &[Vec4],
    previous: &[Vec4],
    step_secs: f32,
) -> Measure {
    let of_strands = STRANDS_AT_ONCE * rest.n_vertices.max(1) as usize;
    let first = (0..rest.vertices.len()).into_par_iter().step_by(of_strands);
    let measured: Vec<Measure> = first
        .map(|first| {
            let strands = first..(first + of_strands).min(rest.vertices.len());
            measure_strands(rest, obstacles, pose, positions, previous, step_secs, strands)
        })
        .collect();
    measured.iter().fold(Measure::default(), |sum, strands| sum.and(strands))
}

/// Strands that a thread measures at a time.
const STRANDS_AT_ONCE: usize = 256;

/// Those of whole strands.
fn measure_strands(
    rest: &Rest,
    obstacles: Obstacles<'_>,
    pose: Pose,
    positions: &[Vec4],
    previous: &[Vec4],
    step_secs: f32,
    vertices: Range<usize>,
) -> Measure {
    let n = rest.n_vertices as usize;
    let mut measure = Measure::default();
    let (mut squared_error, mut n_edges) = (0.0_f64, 0_usize);
    let (mut energy, mut squared_from_rest) = (0.0_f64, 0.0_f64);
    for idx in vertices {
        let k = idx % n;
        let x = positions[idx].xyz();
        if !x.is_finite() {
            measure.n_not_finite += 1;
            continue;
        }
        if k < N_PINNED {
            continue;
        }
        measure.n_vertices += 1;
        let rest_length = rest.vertices[idx].xyz().distance(rest.vertices[idx - 1].xyz());
        let length = x.distance(positions[idx - 1].xyz());
        // An edge without a length has no relative error.
        if rest_length > 1e-4 && length.is_finite() {
            let error = (length / rest_length - 1.0).abs();
            squared_error += f64::from(error).powi(2);
            n_edges += 1;
            measure.length_error_max = measure.length_error_max.max(error);
        }
        let rest_distance = obstacles.rest_distance(rest.vertices[idx].xyz());
        let depth = obstacles.depth(x, pose, rest_distance);
        measure.penetration_max_cm = measure.penetration_max_cm.max(depth);
        let speed = x.distance(previous[idx].xyz()) / step_secs;
        energy += 0.5 * f64::from(speed).powi(2);
        measure.speed_max = measure.speed_max.max(speed);
        squared_from_rest += f64::from(x.distance_squared(pose.apply(rest.vertices[idx].xyz())));
    }
    measure.length_error_rms = (squared_error / n_edges.max(1) as f64).sqrt() as f32;
    measure.kinetic_energy = (energy / measure.n_vertices.max(1) as f64) as f32;
    measure.from_rest_rms_cm = (squared_from_rest / measure.n_vertices.max(1) as f64).sqrt() as f32;
    measure
}
