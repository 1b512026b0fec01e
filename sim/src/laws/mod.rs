//! What must hold of hair that moves, measured: each law on scenes of its own, under either solver, on the CPU or the GPU.
//!
//! `lorelei measure laws` prints them as a table, and sim/tests/solver/ fails where the default solver breaks one. The bounds
//! are the project's own promises, not what is measured: a solver that breaks one says so in the table.

pub mod again;
pub mod free;
pub mod motions;
pub mod rest;
pub mod robust;
pub mod scenes;
pub mod statics;
mod subject;
pub mod wind;

use lorelei_core::look::Choice;
use lorelei_core::simulation::{SimulationSettings, Solver};

pub use subject::{On, Subject};

use crate::bench::BenchError;

/// What a value has to be to keep its law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

/// A law in one scene, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub law: &'static str,
    pub scene: String,
    /// What moves: the name of a solver, or `air`.
    pub of: &'static str,
    pub value: f64,
    pub unit: &'static str,
    pub bound: Bound,
}

impl Row {
    /// Whether the law is kept; what is no number keeps none.
    pub fn holds(&self) -> bool {
        match self.bound {
            Bound::AtMost(most) => self.value <= most,
            Bound::AtLeast(least) => self.value >= least,
        }
    }
}

/// Which solver is measured, and where.
#[derive(Clone, Copy)]
pub struct Under<'a> {
    pub on: &'a On,
    pub solver: Solver,
}

impl Under<'_> {
    /// The solver's defaults.
    pub fn settings(&self) -> SimulationSettings {
        SimulationSettings { solver: self.solver, ..SimulationSettings::default() }
    }

    fn row(&self, law: &'static str, scene: impl Into<String>, value: f64, unit: &'static str, bound: Bound) -> Row {
        Row { law, scene: scene.into(), of: self.solver.info().name, value, unit, bound }
    }
}

/// Rows of one law, or why they could not be measured.
pub type Rows = Result<Vec<Row>, BenchError>;
/// Measures one law.
pub type Measurement = fn(&Under<'_>) -> Rows;

/// Every law of strands, in the order of the table.
pub const OF_STRANDS: [Measurement; 11] = [
    motions::every_motion,
    motions::violent_shakes,
    statics::cantilevers,
    statics::drapes,
    rest::ten_seconds,
    rest::ten_minutes,
    rest::with_every_choice,
    free::whip,
    free::swing,
    robust::nonsense,
    again::frames,
];
