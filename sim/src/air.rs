//! The velocity of the air where a strand is. Twins of the `sim_air_*.wgsl` modules, one for each choice of the wind.

use glam::Vec3;
use lorelei_core::simulation::{SimulationSettings, Wind};

/// Faster air is a mistake in a file, cm/s.
const MAX_SPEED: f32 = 1e4;

/// The air around the groom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Air {
    Still,
    /// The same everywhere, cm/s.
    Uniform(Vec3),
}

impl Air {
    pub fn new(settings: &SimulationSettings) -> Self {
        match settings.wind {
            Wind::Off => Self::Still,
            Wind::Uniform => {
                let velocity = settings.wind_velocity();
                Self::Uniform(if velocity.is_finite() { velocity.clamp_length_max(MAX_SPEED) } else { Vec3::ZERO })
            }
        }
    }

    /// At a place in the world, cm/s. Twin of `air_velocity`.
    pub fn velocity(&self, _p: Vec3) -> Vec3 {
        match *self {
            Self::Still => Vec3::ZERO,
            Self::Uniform(velocity) => velocity,
        }
    }

    /// The shader module that stands in for the slot `sim_air`.
    pub(crate) fn module(&self) -> &'static str {
        match self {
            Self::Still => "sim_air_off",
            Self::Uniform(_) => "sim_air_uniform",
        }
    }

    /// Contents of the uniform `air`.
    pub(crate) fn params(&self) -> [f32; 4] {
        self.velocity(Vec3::ZERO).extend(0.0).to_array()
    }
}
