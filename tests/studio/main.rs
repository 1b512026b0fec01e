//! Tests across crates, in one binary.

mod architecture;
mod bcsdf;
mod golden;
mod looks;
mod scalp;
mod style;
