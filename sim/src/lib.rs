//! Strand dynamics: the CPU reference solver and the GPU solver, side by side.
//!
//! Guides are Verlet chains with their first two vertices fixed to the head. [`strand`] is the law of one
//! strand over one step, and `sim_strand.wgsl` its twin with the same names in the same order. [`clock`] cuts
//! frames into steps of one length, [`measure`] says how well the laws are kept.

pub mod bench;
pub mod clock;
pub mod cpu;
pub mod gpu;
pub mod measure;
pub mod rest;
pub mod strand;

pub use cpu::CpuSolver;
pub use gpu::GpuSolver;
pub use measure::{Measure, measure};
