//! A scene in, a texture out; and the CPU references that it is tested against.

mod bound;
pub mod environment;
pub mod exact;
pub mod false_colour;
mod fragments;
mod frame;
pub mod generate;
mod head;
pub mod inspect;
pub mod mirror;
pub mod overlay;
mod profile;
mod raster;
pub mod reference;
mod renderer;
mod resolve;
pub mod sample;
pub mod scattering;
pub mod scene;
pub mod shade;
pub mod shadow;
pub mod slot;
pub mod sort;
pub mod tonemap;
pub mod versus;
pub mod view;
pub mod white_balance;

pub use bound::Bound;
pub use frame::FrameInput;
pub use generate::MovedLayer;
pub use head::TooManyTriangles;
pub use profile::DRAWING_PASSES;
pub use raster::TooManyVertices;
pub use renderer::{FrameStatistics, Pixels, RenderError, Renderer};
