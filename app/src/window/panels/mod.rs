//! The panels around the viewport, one a file.

pub mod colliders;
mod curve_editor;
pub mod history;
pub mod lights;
pub mod lod;
pub mod look;
pub mod outliner;
pub mod pins;
pub mod properties;
pub mod read_as;
pub mod simulation;
pub mod statistics;
pub mod style;
pub mod widgets;
pub mod wind;

#[cfg(test)]
mod tests;
