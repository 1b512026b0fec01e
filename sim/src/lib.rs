//! Strand dynamics: the CPU reference solver and the GPU solver, side by side.
//!
//! A strand moves by one of two laws: [`rod`], which `sim_rod.wgsl` follows function by function, and the references'
//! [`chain`] (`sim_chain.wgsl`). [`rod_rest`] makes a style ready for rods, [`layer`] keeps what a law needs, [`follow`]
//! draws guides through a hair mesh's moved chains, [`clock`] cuts frames into steps of one length, [`contact`]
//! keeps hair out of head and colliders, [`volume`] is what hair does to hair, [`pull`] a hand that holds some of it,
//! [`air`] is the wind and [`wind`] its grid, and
//! [`measure`] says how well the laws are kept.

pub mod air;
pub mod bench;
pub mod chain;
pub mod clock;
pub mod contact;
pub mod cpu;
pub mod edge;
mod follow;
pub mod gpu;
mod lanes;
pub mod laws;
pub mod layer;
pub mod measure;
pub mod pose;
pub mod pull;
pub mod rest;
pub mod rod;
pub mod rod_rest;
pub mod state;
pub mod volume;
pub mod wind;

pub use cpu::CpuSolver;
pub use gpu::GpuSolver;
pub use measure::{Measure, measure};
pub use pull::Pull;
pub use state::SolverState;

/// A number from a file made harmless: what is not finite becomes the default, the rest is clamped.
pub(crate) fn bounded(value: f32, default: f32, min: f32, max: f32) -> f32 {
    if value.is_finite() { value.clamp(min, max) } else { default }
}
