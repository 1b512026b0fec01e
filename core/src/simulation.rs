//! What an artist sets about movement. The solver's state is derived from the groom and never saved.

use serde::{Deserialize, Serialize};

use crate::look::{Choice, ChoiceInfo, Param, ParamValue, Slot, choices};

choices! {
    /// What moves the strands.
    Solver {
        Guides = "guides", "Guide chains", "Verlet chains for the guides; strands follow by interpolation";
    }
}

/// Parameters of the strand solver, in physical units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SimulationSettings {
    pub solver: Solver,
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
            solver: Solver::Guides,
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

impl SimulationSettings {
    /// All settings as a slot, for the panel, `--set` and `lorelei looks`.
    #[rustfmt::skip]
    pub fn slot(&mut self) -> Slot<'_> {
        fn number<'a>(key: &str, label: &'static str, unit: &'static str, (min, max): (f32, f32), value: &'a mut f32, help: &'static str) -> Param<'a> {
            Param { key: format!("sim.{key}"), label, unit, min, max, of: &[], help, value: ParamValue::F32(value) }
        }
        Slot { key: "sim", label: "Simulation", help: "How the hair moves", choice: &mut self.solver, params: vec![
            number("gravity", "Gravity", "cm/s\u{b2}", (0.0, 4000.0), &mut self.gravity, "981 on Earth"),
            number("damping", "Damping", "of 1, per s", (0.0, 1.0), &mut self.damping, "Share of the speed that is lost in a second"),
            number("stiffness", "Stiffness", "", (0.0, 1.0), &mut self.stiffness, "Pull of every piece towards the shape it rests in"),
            number("root_stiffness", "Root stiffness", "", (0.0, 1.0), &mut self.root_stiffness, "Extra pull at the root, fading to the tip"),
            number("wind_speed", "Wind", "cm/s", (0.0, 3000.0), &mut self.wind_speed, "0 calm, 300 a breeze, 1500 a storm"),
            number("wind_azimuth", "Wind azimuth", "deg", (-360.0, 360.0), &mut self.wind_azimuth_deg, "Where the wind blows to: 0 to the front, 90 to the model's left"),
            number("wind_elevation", "Wind elevation", "deg", (-90.0, 90.0), &mut self.wind_elevation_deg, "Above the horizon"),
            number("drag", "Drag", "1/s", (0.0, 20.0), &mut self.drag, "How quickly hair takes up the speed of the air"),
            number("margin", "Distance to the head", "cm", (0.0, 2.0), &mut self.collision_margin, "Kept between hair and head"),
            number("friction", "Friction", "", (0.0, 2.0), &mut self.friction, "Against the head"),
            number("steps", "Steps", "1/s", (30.0, 480.0), &mut self.steps_per_second, "Solver steps a second, whatever the frame rate"),
            Param { key: "sim.iterations".to_owned(), label: "Iterations", unit: "", min: 1.0, max: 64.0, of: &[], help: "Constraint iterations a step", value: ParamValue::U32(&mut self.n_iterations) },
        ] }
    }
}
