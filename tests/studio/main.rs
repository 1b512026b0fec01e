//! Tests across crates, in one binary.

mod architecture;
mod bcsdf;
mod golden;
mod scalp;
mod style;
