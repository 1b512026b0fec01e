//! One exhaustive `match` for each question of the look: which WGSL file stands in for which slot. A new technique is
//! a variant, a file and an arm; the compiler finds the missing arm.

mod drawing;
mod scattering;
mod shadowing;
mod view;

pub use drawing::{antialiasing, background, shading_rate, supersampling, tonemapping};
pub use scattering::{ambient, environment, lobes, multiple_scattering, scattering};
pub use shadowing::shadowing;
pub use view::{shadow_part, view_colour, view_picture};
