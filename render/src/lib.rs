//! A scene in, a texture out; and the CPU references that it is tested against.

pub mod exact;
pub mod generate;
pub mod mirror;
pub mod ribbons;
pub mod scattering;
pub mod scene;
pub mod shade;
pub mod shadow;
pub mod slot;
pub mod view;
