//! What an artist sets about movement. The solver's state is derived from the groom and never saved.
//!
//! Every number is a physical one, so that the same groom moves the same at other vertex counts, step
//! rates and iteration counts. Shares "0-1 of something, per iteration" were rejected for that reason.

mod preset;
mod quality;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::camera::direction_from_deg;
use crate::collider::Collider;
use crate::look::{Choice, ChoiceInfo, Param, ParamValue, Slot, choices, integer, number};
use crate::pin::Pin;
use crate::wind::{AirSettings, WindSource};

pub use preset::HairKind;
pub use quality::Quality;

choices! {
    /// The law by which a strand moves.
    Solver {
        #[serde(alias = "Guides")]
        Rods = "rods", "Rods", "Exact length, bending and twist that no step or iteration changes; the style rests without sagging";
        Chains = "chains", "Chains", "Verlet chains with length and shape constraints in batches, as games have them: softer with fewer iterations and longer steps";
    }
}

choices! {
    /// What of the hair the law moves.
    Moved {
        Guides = "guides", "Guides", "Each guide by itself; strands are blended between guides";
        Mesh = "mesh", "Hair mesh", "The edges that lead from layer to layer of a hair mesh: a few stiff links a lock, cheapest, and locks stay whole";
        Rope = "rope", "Rope", "What hangs together on the scalp as one: a braid, a ponytail, a lock";
        Strands = "strands", "Every strand", "Each strand that is drawn, with its own curl: for a fast graphics card";
    }
}

choices! {
    /// What the style is.
    RestShape {
        Hanging = "hanging", "As it hangs", "Under gravity: the style stays as it is while the head is still";
        Weightless = "weightless", "Without weight", "As it would be without gravity: it sags when time starts";
    }
}

choices! {
    /// The air that hair moves in.
    Wind {
        Uniform = "uniform", "Steady wind", "Wind, gusts and the streams of sources as if nothing stood in their way: no grid";
        Grid = "grid", "Grid", "Air on a grid around the groom, which goes around the head and is stopped by hair";
        Off = "off", "Still air", "Hair is damped by air that does not move";
    }
}

choices! {
    /// Hair against hair.
    Volume {
        Off = "off", "Off", "Hair passes through hair: no grid, no cost";
        Density = "density", "Density", "Hair that is more crowded than it rests is pushed apart: volume is kept";
        DensityVelocity = "density-velocity", "Density and velocity", "Also goes along with the hair around it, as hair that rubs on hair does";
    }
}

choices! {
    /// How strands between the guides are kept out of the head while it moves.
    Interpolated {
        Pushed = "pushed", "Pushed out", "Each vertex that is in the head is put on it";
        SingleGuide = "single-guide", "One guide", "A strand that enters the head goes with its strongest guide from there on, and is pushed out where that is not enough";
        Free = "free", "Free", "As the guides have it, through the head or not: to see what the others do";
    }
}

choices! {
    /// How thick hair is against the head and colliders.
    Pearl {
        Off = "off", "As a line", "Every vertex keeps the same distance";
        Growing = "growing", "Growing balls", "A ball at every vertex that grows from root to tip: locks keep their thickness, and nothing slips between two vertices";
    }
}

/// Parameters of the strand solver, in physical units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SimulationSettings {
    pub solver: Solver,
    pub moved: Moved,
    pub wind: Wind,
    /// Solver steps a second; independent of the frame rate.
    pub steps_per_second: f32,
    /// Constraint iterations a step.
    pub n_iterations: u32,
    /// cm/s2, downwards.
    pub gravity: f32,
    /// How quickly strands lose speed relative to the head by rubbing on each other, 1/s.
    pub damping: f32,
    /// Bending stiffness as a length in centimetres: about how far a lock reaches out sideways before its
    /// own weight bends it down. 5 is a single human hair.
    pub bend_length: f32,
    /// Time over which bending loses its speed, seconds: what stills quiver and leaves the swing alone.
    pub bend_damping: f32,
    /// As `damping`, for movement along the strand.
    pub damping_along: f32,
    pub rest_shape: RestShape,
    /// Share of a vertex's distance from its local shape that an iteration of chains takes away, 0-1.
    pub shape: f32,
    /// How fast a displaced root springs back to the style, Hz: what spray, clips and neighbours do.
    pub hold: f32,
    /// Distance along the strand over which the hold falls to 1/e, centimetres.
    pub hold_length: f32,
    /// Steady wind: where it blows to, degrees, as a camera azimuth; and elevation.
    pub wind_azimuth_deg: f32,
    pub wind_elevation_deg: f32,
    /// cm/s. 0 is calm, 300 a breeze, 1500 a storm.
    pub wind_speed: f32,
    /// Gusts and eddies of the steady wind, and the grid of air.
    pub air: AirSettings,
    /// What blows in the scene; the first [`crate::wind::MAX_SOURCES`] that are on.
    pub sources: Vec<WindSource>,
    /// How quickly a strand takes up the speed of the air around it, 1/s.
    pub drag: f32,
    /// Distance kept between hair and head, centimetres.
    pub collision_margin: f32,
    /// Coulomb coefficient against the head.
    pub friction: f32,
    pub pearl: Pearl,
    pub interpolated: Interpolated,
    pub volume: Volume,
    /// Cells along the longest side of the groom with room to swing.
    pub volume_cells: u32,
    /// How hard hair twice as crowded as at rest is driven apart, in multiples of gravity.
    pub volume_push: f32,
    /// How much more crowded than at rest is let be, as a share.
    pub volume_tolerance: f32,
    /// How quickly hair takes up the speed of the hair around it, 1/s.
    pub volume_rub: f32,
    /// Radius of hair against the head and colliders at its tip, cm; see [`Pearl`].
    pub pearl_radius: f32,
    /// What hair also keeps out of. Files from before there were capsules call them spheres.
    #[serde(alias = "spheres")]
    pub colliders: Vec<Collider>,
    /// What holds hair to its place on the head.
    pub pins: Vec<Pin>,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self {
            solver: Solver::Rods,
            moved: Moved::Guides,
            wind: Wind::Uniform,
            steps_per_second: 240.0,
            n_iterations: 3,
            gravity: 981.0,
            damping: 1.5,
            bend_length: 2.5,
            bend_damping: 0.003,
            damping_along: 1.5,
            rest_shape: RestShape::Hanging,
            shape: 0.2,
            hold: 3.0,
            hold_length: 3.0,
            wind_azimuth_deg: 90.0,
            wind_elevation_deg: 0.0,
            wind_speed: 0.0,
            air: AirSettings::default(),
            sources: Vec::new(),
            drag: 1.5,
            collision_margin: 0.15,
            friction: 0.2,
            pearl: Pearl::Off,
            interpolated: Interpolated::Pushed,
            volume: Volume::Off,
            volume_cells: 32,
            volume_push: 2.0,
            volume_tolerance: 0.1,
            volume_rub: 4.0,
            pearl_radius: 0.6,
            colliders: Vec::new(),
            pins: Vec::new(),
        }
    }
}

impl SimulationSettings {
    /// Velocity of the steady wind, cm/s.
    pub fn wind_velocity(&self) -> Vec3 {
        self.wind_speed * direction_from_deg(self.wind_azimuth_deg, self.wind_elevation_deg)
    }

    /// Let the air move so everywhere, cm/s. Calm air keeps the direction that was set.
    pub fn set_wind_velocity(&mut self, wind: Vec3) {
        if self.wind == Wind::Off {
            self.wind = Wind::Uniform;
        }
        self.wind_speed = wind.length();
        if let Some(direction) = wind.try_normalize() {
            self.wind_azimuth_deg = direction.x.atan2(direction.z).to_degrees();
            self.wind_elevation_deg = direction.y.clamp(-1.0, 1.0).asin().to_degrees();
        }
    }

    /// All settings as slots, for the panel, `--set` and `lorelei looks`.
    pub fn slots(&mut self) -> Vec<Slot<'_>> {
        const BLOWS: &[&str] = &["uniform", "grid"];
        const RODS: &[&str] = &["rods"];
        const CHAINS: &[&str] = &["chains"];
        let solver = vec![
            number("sim.gravity", "Gravity", "cm/s\u{b2}", (0.0, 4000.0), &mut self.gravity, &[], "981 on Earth"),
            number(
                "sim.damping",
                "Damping",
                "1/s",
                (0.0, 20.0),
                &mut self.damping,
                &[],
                "How quickly hair comes to rest on the head",
            ),
            number(
                "sim.damping_along",
                "Damping along",
                "1/s",
                (0.0, 20.0),
                &mut self.damping_along,
                RODS,
                "Likewise, of movement along the hair",
            ),
            number(
                "sim.bend_length",
                "Stiffness",
                "cm",
                (0.0, 30.0),
                &mut self.bend_length,
                RODS,
                "How far a lock reaches out before its weight bends it: 1 soft, 5 wiry, 20 bristle",
            ),
            number(
                "sim.bend_damping",
                "Bend damping",
                "s",
                (0.0, 0.2),
                &mut self.bend_damping,
                RODS,
                "Time over which bending loses its speed: stills quiver and bounce",
            ),
            Param {
                key: "sim.rest".to_owned(),
                label: "The style is",
                unit: "",
                min: 0.0,
                max: 1.0,
                help: "Whether the style is what hangs under gravity",
                of: RODS,
                value: ParamValue::Choice(&mut self.rest_shape),
            },
            number(
                "sim.shape",
                "Shape",
                "",
                (0.0, 1.0),
                &mut self.shape,
                CHAINS,
                "How much of its local shape a strand finds back in each iteration",
            ),
            number(
                "sim.hold",
                "Hold",
                "Hz",
                (0.0, 30.0),
                &mut self.hold,
                &[],
                "How fast the roots spring back to the style: 0 loose, 3 natural, 15 sprayed",
            ),
            number(
                "sim.hold_length",
                "Hold reaches",
                "cm",
                (0.1, 60.0),
                &mut self.hold_length,
                &[],
                "Distance from the root over which the hold fades",
            ),
            number(
                "sim.margin",
                "Distance to the head",
                "cm",
                (0.0, 2.0),
                &mut self.collision_margin,
                &[],
                "Kept between hair and head",
            ),
            number("sim.friction", "Friction", "", (0.0, 2.0), &mut self.friction, &[], "Against the head"),
            number(
                "sim.steps",
                "Steps",
                "1/s",
                (30.0, 960.0),
                &mut self.steps_per_second,
                &[],
                "Solver steps a second, whatever the frame rate",
            ),
            integer(
                "sim.iterations",
                "Iterations",
                "",
                (1, 32),
                &mut self.n_iterations,
                &[],
                "Of contacts, and of chains' lengths and shape, in a step",
            ),
        ];
        let mut wind = vec![
            number(
                "wind.speed",
                "Speed",
                "cm/s",
                (0.0, 3000.0),
                &mut self.wind_speed,
                BLOWS,
                "0 calm, 300 a breeze, 1500 a storm",
            ),
            number(
                "wind.azimuth",
                "Azimuth",
                "deg",
                (-360.0, 360.0),
                &mut self.wind_azimuth_deg,
                BLOWS,
                "Where the wind blows to: 0 to the front, 90 to the model's left",
            ),
            number(
                "wind.elevation",
                "Elevation",
                "deg",
                (-90.0, 90.0),
                &mut self.wind_elevation_deg,
                BLOWS,
                "Above the horizon",
            ),
            number(
                "wind.drag",
                "Drag",
                "1/s",
                (0.0, 20.0),
                &mut self.drag,
                &[],
                "How quickly hair takes up the speed of the air",
            ),
        ];
        let pearl = vec![number(
            "pearl.radius",
            "Radius at the tip",
            "cm",
            (0.0, 3.0),
            &mut self.pearl_radius,
            &["growing"],
            "Half of a lock's thickness; half the distance of two vertices, and nothing slips between them",
        )];
        wind.extend(self.air.params());
        const COUNTED: &[&str] = &["density", "density-velocity"];
        let volume = vec![
            integer(
                "volume.cells",
                "Cells",
                "",
                (8, 96),
                &mut self.volume_cells,
                COUNTED,
                "Along the longest side of the groom; finer cells keep finer locks apart",
            ),
            number(
                "volume.push",
                "Spreads",
                "g",
                (0.0, 20.0),
                &mut self.volume_push,
                COUNTED,
                "How hard hair twice as crowded as at rest is driven apart, in multiples of gravity",
            ),
            number(
                "volume.tolerance",
                "Lets be",
                "",
                (0.01, 3.0),
                &mut self.volume_tolerance,
                COUNTED,
                "How much more crowded than at rest hair may be: 0.25 is a quarter more",
            ),
            number(
                "volume.rub",
                "Goes along",
                "1/s",
                (0.0, 60.0),
                &mut self.volume_rub,
                &["density-velocity"],
                "How quickly hair takes up the speed of the hair around it",
            ),
        ];
        vec![
            Slot {
                key: "sim",
                label: "Simulation",
                help: "How the hair moves",
                choice: &mut self.solver,
                params: solver,
            },
            Slot {
                key: "moved",
                label: "What moves",
                help: "Guides, the hair mesh, or every strand by itself",
                choice: &mut self.moved,
                params: Vec::new(),
            },
            Slot {
                key: "wind",
                label: "Wind",
                help: "The air that the hair moves in",
                choice: &mut self.wind,
                params: wind,
            },
            Slot {
                key: "pearl",
                label: "Thickness",
                help: "How thick hair is against the head and colliders",
                choice: &mut self.pearl,
                params: pearl,
            },
            Slot {
                key: "volume",
                label: "Hair on hair",
                help: "What hair does to the hair around it",
                choice: &mut self.volume,
                params: volume,
            },
            Slot {
                key: "interpolated",
                label: "Strands in the head",
                help: "How strands between the guides are kept out of the head while it moves",
                choice: &mut self.interpolated,
                params: Vec::new(),
            },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_default_is_in_the_range_of_its_parameter() {
        let mut settings = SimulationSettings::default();
        let mut keys = std::collections::HashSet::new();
        for mut param in settings.slots().into_iter().flat_map(|slot| slot.params) {
            assert!(keys.insert(param.key.clone()), "{}", param.key);
            let text = param.value.to_text();
            param.set_from_text(&text).unwrap();
        }
    }

    #[test]
    fn settings_from_before_there_were_pins_have_none_and_pins_are_read_as_they_were_written() {
        assert_eq!(ron::from_str::<SimulationSettings>("(gravity: 981.0)").unwrap(), SimulationSettings::default());
        let pin = Pin { name: "clip".to_owned(), on: false, centre: Vec3::new(7.0, 1.0, 3.0), radius: 2.0 };
        let settings = SimulationSettings { pins: vec![pin], ..SimulationSettings::default() };
        let text = ron::to_string(&settings).unwrap();
        assert_eq!(ron::from_str::<SimulationSettings>(&text).unwrap(), settings, "{text}");
    }

    #[test]
    fn wind_blows_where_its_azimuth_points() {
        let settings = SimulationSettings { wind_speed: 200.0, wind_azimuth_deg: 90.0, ..Default::default() };
        assert!(settings.wind_velocity().distance(Vec3::X * 200.0) < 1e-3);
        for wind in [Vec3::new(-30.0, 40.0, -50.0), Vec3::NEG_Z, Vec3::Y * 10.0] {
            let mut blown = SimulationSettings { wind: Wind::Off, ..Default::default() };
            blown.set_wind_velocity(wind);
            assert!(blown.wind_velocity().distance(wind) < 1e-3 && blown.wind == Wind::Uniform, "{wind}");
        }
        let mut calm = settings.clone();
        calm.set_wind_velocity(Vec3::ZERO);
        assert_eq!(calm, SimulationSettings { wind_speed: 0.0, ..settings });
    }
}
