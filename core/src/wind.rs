//! What an artist sets about the air: sources that stand in the scene, gusts and eddies, and the grid of air.
//!
//! Everything that changes with time is a function of the time alone, so that scrubbing back gives the same
//! air. A random walk was rejected for that reason.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::hash::{combine, unit};
use crate::look::{Choice, ChoiceInfo, Param, ParamValue, Switch, choices, integer, number};

/// Sources that blow at one time; those beyond are left out.
pub const MAX_SOURCES: usize = 8;

choices! {
    /// What a source does with the air.
    #[derive(Default)]
    SourceKind {
        #[default]
        Fan = "fan", "Fan", "A disc that blows a stream along its axis";
        Vortex = "vortex", "Vortex", "A ball of air that turns about its axis";
    }
}

/// How a speed swells and falls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Gusts {
    /// Share of the speed (0-2) by which it swells and falls.
    pub strength: f32,
    /// Seconds from one gust to about the next.
    pub period_secs: f32,
}

impl Default for Gusts {
    fn default() -> Self {
        Self { strength: 0.0, period_secs: 2.5 }
    }
}

impl Gusts {
    /// What the speed is multiplied by at a time: 1 on average, never negative, the same for the same seed.
    ///
    /// Three sines whose periods are in no simple ratio (the golden one and its square).
    pub fn factor(&self, t_secs: f64, seed: u32) -> f32 {
        let strength = if self.strength.is_finite() { self.strength.clamp(0.0, 2.0) } else { 0.0 };
        if !t_secs.is_finite() || strength == 0.0 {
            return 1.0;
        }
        let period_secs = f64::from(if self.period_secs.is_finite() { self.period_secs.clamp(0.05, 1e4) } else { 2.5 });
        let wave = |k: u32, weight: f64, faster: f64| {
            let phase = f64::from(unit(combine(seed, 0x6757 + k)));
            weight * (std::f64::consts::TAU * (t_secs * faster / period_secs + phase)).sin()
        };
        let swell = wave(0, 0.5, 1.0) + wave(1, 0.3, 1.618_034) + wave(2, 0.2, 2.618_034);
        (1.0 + f64::from(strength) * swell).max(0.0) as f32
    }
}

/// Eddies that drift with the wind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Eddies {
    /// Root mean square of their speed as a share of the wind's (0-1). 0.1 is a breeze over open country, 0.3 a street.
    pub amount: f32,
    /// Size of the largest, centimetres.
    pub size_cm: f32,
    pub seed: u32,
}

impl Default for Eddies {
    fn default() -> Self {
        Self { amount: 0.0, size_cm: 15.0, seed: 1 }
    }
}

/// Something that blows. World space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WindSource {
    pub name: String,
    pub on: bool,
    pub kind: SourceKind,
    /// Middle, centimetres.
    pub place: Vec3,
    /// Where a fan blows to and what a vortex turns about; any length.
    pub direction: Vec3,
    /// Centimetres.
    pub radius: f32,
    /// In the stream's core, or where a vortex is fastest, cm/s.
    pub speed: f32,
    /// How quickly a fan's stream widens and slows: 0 not at all, 1 as a jet does in still air.
    pub falloff: f32,
    pub gusts: Gusts,
    pub eddies: Eddies,
}

impl Default for WindSource {
    /// A hair dryer on the model's left, half a metre from the middle of a head.
    fn default() -> Self {
        Self {
            name: "Fan".to_owned(),
            on: true,
            kind: SourceKind::Fan,
            place: Vec3::new(45.0, 0.0, 20.0),
            direction: Vec3::new(-0.9, 0.0, -0.4),
            radius: 6.0,
            speed: 600.0,
            falloff: 1.0,
            gusts: Gusts::default(),
            eddies: Eddies { amount: 0.1, ..Eddies::default() },
        }
    }
}

/// Largest radius, centimetres, and speed, cm/s: a hurricane.
pub const MAX_RADIUS: f32 = 200.0;
pub const MAX_SPEED: f32 = 5000.0;

impl WindSource {
    /// A new source that blows at `centre` from `distance` away.
    pub fn aimed_at(centre: Vec3, distance: f32, name: &str) -> Self {
        let fan = Self::default();
        let from_centre = -fan.direction.normalize();
        Self { name: name.to_owned(), place: centre + distance * from_centre, direction: -from_centre, ..fan }
    }

    /// The same with every number finite and in range.
    #[must_use]
    pub fn tamed(&self) -> Self {
        let number = |value: f32, low: f32, high: f32, otherwise: f32| {
            if value.is_finite() { value.clamp(low, high) } else { otherwise }
        };
        let finite = |v: Vec3| if v.is_finite() { v.clamp(Vec3::splat(-1e5), Vec3::splat(1e5)) } else { Vec3::ZERO };
        Self {
            place: finite(self.place),
            direction: finite(self.direction).normalize_or(Vec3::NEG_Z),
            radius: number(self.radius, 0.5, MAX_RADIUS, 6.0),
            speed: number(self.speed, 0.0, MAX_SPEED, 0.0),
            falloff: number(self.falloff, 0.0, 20.0, 1.0),
            gusts: self.gusts,
            eddies: self.eddies.tamed(),
            ..self.clone()
        }
    }
}

impl Eddies {
    /// The same with every number finite and in range.
    #[must_use]
    pub fn tamed(&self) -> Self {
        let amount = if self.amount.is_finite() { self.amount.clamp(0.0, 2.0) } else { 0.0 };
        let size_cm = if self.size_cm.is_finite() { self.size_cm.clamp(0.5, 1e4) } else { 15.0 };
        Self { amount, size_cm, seed: self.seed }
    }
}

/// The grid of air, and what the steady wind carries along.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AirSettings {
    pub gusts: Gusts,
    pub eddies: Eddies,
    /// Cells along each side, 16-128; taken to the nearest of [`RESOLUTIONS`].
    pub resolution: u32,
    /// How fast vorticity confinement drives small eddies that the grid has smoothed away, 1/s.
    pub vorticity: f32,
    /// How hard hair slows the air: 1 as hard as the air drives hair, 0 not at all.
    pub hair_drag: f32,
    /// Whether the air goes around the head.
    pub obstacle: Switch,
    /// Multigrid cycles a frame: each leaves about a tenth of the divergence.
    pub n_cycles: u32,
}

/// Sizes of the grid: halved until 3 or 4 cells are left.
pub const RESOLUTIONS: [u32; 7] = [16, 24, 32, 48, 64, 96, 128];

impl Default for AirSettings {
    fn default() -> Self {
        Self {
            gusts: Gusts::default(),
            eddies: Eddies::default(),
            resolution: 32,
            vorticity: 4.0,
            hair_drag: 1.0,
            obstacle: Switch::On,
            n_cycles: 2,
        }
    }
}

impl AirSettings {
    /// The nearest size that the grid can have.
    pub fn n_cells(&self) -> u32 {
        RESOLUTIONS.into_iter().min_by_key(|n| n.abs_diff(self.resolution)).unwrap_or(32)
    }

    /// Everything but the sources, for the slot `wind`.
    #[rustfmt::skip]
    pub(crate) fn params(&mut self) -> Vec<Param<'_>> {
        const BLOWS: &[&str] = &["uniform", "grid"];
        const GRID: &[&str] = &["grid"];
        vec![
            number("wind.gusts", "Gusts", "", (0.0, 2.0), &mut self.gusts.strength, BLOWS, "Share of the speed by which the wind swells and falls"),
            number("wind.gust_period", "Between gusts", "s", (0.1, 60.0), &mut self.gusts.period_secs, BLOWS, "Seconds from one gust to about the next"),
            number("wind.eddies", "Eddies", "", (0.0, 2.0), &mut self.eddies.amount, BLOWS, "Speed of the eddies as a share of the wind's: 0.1 open country, 0.3 a street"),
            number("wind.eddy_size", "Eddy size", "cm", (0.5, 200.0), &mut self.eddies.size_cm, BLOWS, "Size of the largest eddies"),
            integer("wind.seed", "Seed", "", (0, 9999), &mut self.eddies.seed, BLOWS, "Other gusts and eddies of the same kind"),
            integer("wind.resolution", "Grid", "cells", (16, 128), &mut self.resolution, GRID, "Cells along each side: 16, 24, 32, 48, 64, 96 or 128, the nearest is taken; twice as many take eight times as long"),
            number("wind.vorticity", "Vorticity", "1/s", (0.0, 40.0), &mut self.vorticity, GRID, "How fast eddies are driven that the grid would smooth away"),
            number("wind.hair_drag", "Hair stops air", "", (0.0, 4.0), &mut self.hair_drag, GRID, "How hard hair slows the air: 1 as hard as the air drives hair, 0 not at all"),
            integer("wind.cycles", "Pressure cycles", "", (1, 8), &mut self.n_cycles, GRID, "Multigrid cycles a frame: more leave less divergence"),
            Param { key: "wind.obstacle".to_owned(), label: "Around the head", unit: "", min: 0.0, max: 0.0, of: GRID, help: "Whether the air goes around the head", value: ParamValue::Choice(&mut self.obstacle) },
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gusts_depend_on_time_and_seed_alone_and_average_to_the_speed() {
        let gusts = Gusts { strength: 0.8, period_secs: 2.0 };
        let mean = (0..20_000).map(|i| f64::from(gusts.factor(f64::from(i) * 0.01, 3))).sum::<f64>() / 20_000.0;
        assert!((mean - 1.0).abs() < 0.02, "{mean}");
        assert_eq!(gusts.factor(7.25, 3), gusts.factor(7.25, 3));
        assert!((0..100).any(|i| (gusts.factor(f64::from(i), 3) - gusts.factor(f64::from(i), 4)).abs() > 0.1));
        assert!((0..1000).all(|i| gusts.factor(f64::from(i) * 0.1, 9) >= 0.0));
        assert_eq!(Gusts { strength: f32::NAN, period_secs: f32::NAN }.factor(1.0, 0), 1.0);
        assert!(Gusts { strength: 1.0, period_secs: 0.0 }.factor(1e9, 0).is_finite());
    }

    #[test]
    fn a_source_that_is_nonsense_is_tamed() {
        let bad = WindSource {
            place: Vec3::NAN,
            direction: Vec3::ZERO,
            radius: f32::INFINITY,
            speed: -1e30,
            falloff: f32::NAN,
            eddies: Eddies { amount: f32::NAN, size_cm: 0.0, seed: 0 },
            ..WindSource::default()
        }
        .tamed();
        assert!(bad.place.is_finite() && (bad.direction.length() - 1.0).abs() < 1e-5);
        assert!(bad.radius > 0.0 && bad.speed == 0.0 && bad.falloff.is_finite() && bad.eddies.size_cm > 0.0);
    }

    #[test]
    fn every_parameter_takes_its_default_and_any_number_of_cells_is_one_that_can_be() {
        let mut settings = AirSettings::default();
        for mut param in settings.params() {
            let text = param.value.to_text();
            param.set_from_text(&text).unwrap();
        }
        assert_eq!(settings, AirSettings::default());
        for (asked, is) in [(0, 16), (33, 32), (100, 96), (u32::MAX, 128)] {
            assert_eq!(AirSettings { resolution: asked, ..AirSettings::default() }.n_cells(), is);
        }
    }
}
