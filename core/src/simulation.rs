//! What an artist sets about movement. The solver's state is derived from the groom and never saved.

use serde::{Deserialize, Serialize};

/// Parameters of the strand solver, in physical units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SimulationSettings {
    /// Solver steps a second; independent of the frame rate.
    pub steps_per_second: f32,
    /// Constraint iterations a step.
    pub n_iterations: u32,
    /// cm/s2, downwards.
    pub gravity: f32,
    /// Share of the velocity lost in a second, 0-1.
    pub damping: f32,
    /// Pull of the bend and local-shape constraints towards the rest shape, 0-1.
    pub stiffness: f32,
    /// Extra pull towards the rest pose at the root, fading to the tip, 0-1.
    pub root_stiffness: f32,
    /// Steady wind: where it blows to, degrees, as a camera azimuth; and elevation.
    pub wind_azimuth_deg: f32,
    pub wind_elevation_deg: f32,
    /// cm/s. 0 is calm, 300 a breeze, 1500 a storm.
    pub wind_speed: f32,
    /// How quickly a strand takes up the speed of the air around it, 1/s.
    pub drag: f32,
    /// Distance kept between hair and head, centimetres.
    pub collision_margin: f32,
    /// Coulomb coefficient against the head.
    pub friction: f32,
    /// Spheres in head space that hair also keeps out of: centre x, y, z and radius in centimetres.
    pub spheres: Vec<[f32; 4]>,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self {
            steps_per_second: 120.0,
            n_iterations: 8,
            gravity: 981.0,
            damping: 0.9,
            stiffness: 0.35,
            root_stiffness: 0.6,
            wind_azimuth_deg: 90.0,
            wind_elevation_deg: 0.0,
            wind_speed: 0.0,
            drag: 1.5,
            collision_margin: 0.15,
            friction: 0.25,
            spheres: Vec::new(),
        }
    }
}
