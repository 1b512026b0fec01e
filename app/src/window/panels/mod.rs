//! The panels around the viewport, one a file.

pub mod history;
pub mod lights;
pub mod look;
pub mod outliner;
pub mod properties;
pub mod read_as;
pub mod simulation;
pub mod statistics;
pub mod widgets;

#[cfg(test)]
mod tests;
