//! A groom's movement frame by frame, without a picture: for the command line, and for whatever simulates while the
//! window shows something else.
//!
//! [`Course`] says where the head is and how the air moves at a time, [`Run`] takes a solver through it in frames of one
//! length. The same inputs give the same frames on one device.

pub mod course;
pub mod file;
pub mod filmstrip;
pub mod frames;
pub mod key;
pub mod range;
pub mod run;
pub mod solver;

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::moved::MovedHair;
use lorelei_core::simulation::Moved;
use lorelei_render::Bound;

pub use course::Course;
pub use run::Run;

/// What is moved of every layer, at rest, and the head that it keeps out of.
#[derive(Debug, Clone)]
pub struct Subject {
    pub hair: Vec<MovedHair>,
    pub field: Option<Arc<DistanceField>>,
}

impl Subject {
    /// Of a groom that is bound.
    pub fn of(bound: &Bound, moved: Moved) -> Self {
        let field = bound.field().cloned();
        let hair = bound.layers().map(|(layer, binding)| MovedHair::new(moved, layer, binding, field.as_deref()));
        Self { hair: hair.collect(), field }
    }

    /// Guides, chains, or strands.
    pub fn n_curves(&self) -> usize {
        self.hair.iter().map(|hair| hair.curves.n_guides()).sum()
    }

    pub fn n_vertices(&self) -> usize {
        self.hair.iter().map(|hair| hair.curves.positions.len()).sum()
    }
}

/// One frame: where the head is, and every layer's guides, or strands where those were moved, in world space: vertex `k` of
/// guide `g` at `g * n_vertices + k`.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    pub world_from_head: Affine3A,
    pub positions: Vec<Vec<Vec3>>,
}

impl Shot {
    /// Bytes that it takes in memory.
    pub fn n_bytes(&self) -> usize {
        size_of::<Self>() + self.positions.iter().map(|layer| size_of_val(layer.as_slice())).sum::<usize>()
    }
}
