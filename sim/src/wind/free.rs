//! The air where nothing stands in its way: steady wind, eddies and the streams of sources. Twin of `wind_free.wgsl`.
//!
//! A fan's stream is a round turbulent jet: constant over a core of six diameters, then slowing with one over the
//! distance while it widens by as much (Pope 2000, "Turbulent flows", section 5.1). A vortex is Lamb's and Oseen's, which a
//! Gaussian ends along its axis.
//!
//! Eddies are a sum of waves, each across its own direction, so that the sum has no divergence (Kraichnan 1970; Fung et
//! al. 1992, "Kinematic simulation"), carried by the mean wind without changing (Taylor 1938). Their wave numbers are
//! whole, so the pattern repeats after [`PERIODS`] of the largest eddies and what has drifted by can be taken modulo one
//! period: hours into a scene the eddies are as fine as at its start.

use std::f32::consts::{LN_2, TAU};

use glam::{DVec3, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::hash::random;
use lorelei_core::simulation::SimulationSettings;
use lorelei_core::wind::{Eddies, MAX_SOURCES, SourceKind, WindSource};

use crate::bounded;

/// Waves that eddies are made of.
pub const N_MODES: usize = 12;
/// Largest eddies in a period of the pattern.
const PERIODS: f32 = 4.0;
/// Length of a jet's core in radii: six diameters.
const CORE: f32 = 12.0;
const FAN: u32 = 0;
const VORTEX: u32 = 1;

/// Layout of `FreeSource` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FreeSource {
    pub place: Vec3,
    pub kind: u32,
    /// Unit vector.
    pub direction: Vec3,
    /// cm.
    pub radius: f32,
    /// Where its eddies have drifted to, in periods (0-1).
    pub drift: Vec3,
    /// Periods of its eddies in a centimetre.
    pub per_period: f32,
    /// cm/s, gusts included.
    pub speed: f32,
    pub falloff: f32,
    /// Root mean square of its eddies as a share of the speed.
    pub rough: f32,
    pub pad: f32,
}

/// Layout of `Mode` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Mode {
    /// Waves in a period along each axis; w the phase in turns.
    pub waves: Vec4,
    pub amplitude: Vec4,
}

/// The free air at one time. Layout of `FreeAir` in WGSL.
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FreeAir {
    /// cm/s, gusts included.
    pub steady: Vec3,
    pub n_sources: u32,
    /// Where the eddies have drifted to, in periods (0-1).
    pub drift: Vec3,
    /// Periods of the eddies in a centimetre.
    pub per_period: f32,
    /// Root mean square of the eddies, cm/s.
    pub rough: f32,
    pub pad: [f32; 3],
    pub sources: [FreeSource; MAX_SOURCES],
    pub modes: [Mode; N_MODES],
}

impl FreeAir {
    /// The air of these settings at a time. The same time gives the same air.
    pub fn new(settings: &SimulationSettings, t_secs: f64) -> Self {
        let t_secs = if t_secs.is_finite() { t_secs } else { 0.0 };
        let velocity = settings.wind_velocity();
        let velocity = if velocity.is_finite() { velocity.clamp_length_max(1e4) } else { Vec3::ZERO };
        let eddies = settings.air.eddies.tamed();
        let mut free = Self {
            steady: velocity * settings.air.gusts.factor(t_secs, eddies.seed),
            rough: eddies.amount * velocity.length(),
            ..bytemuck::Zeroable::zeroed()
        };
        (free.drift, free.per_period) = drifted(&eddies, velocity, t_secs);
        for (seed, mode) in free.modes.iter_mut().enumerate() {
            *mode = mode_of(seed as u32);
        }
        let blowing = settings.sources.iter().filter(|source| source.on).take(MAX_SOURCES);
        for (slot, source) in free.sources.iter_mut().zip(blowing) {
            *slot = FreeSource::new(&source.tamed(), t_secs);
            free.n_sources += 1;
        }
        free
    }

    /// Eddies of unit root mean square, divergence-free; `at` in periods.
    fn eddies(&self, at: Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for mode in &self.modes {
            let turns = mode.waves.xyz().dot(at) + mode.waves.w;
            sum += (TAU * (turns - turns.floor())).cos() * mode.amplitude.xyz();
        }
        sum
    }

    /// A stream at a place with the eddies of its source.
    fn roughened(&self, source: &FreeSource, v: Vec3, p: Vec3) -> Vec3 {
        if source.rough <= 0.0 {
            return v;
        }
        v + source.rough * v.length() * self.eddies(p * source.per_period + source.drift)
    }

    /// Velocity of the air at a place, world, cm/s.
    pub fn free_air(&self, p: Vec3) -> Vec3 {
        let mut v = self.steady;
        if self.rough > 0.0 {
            v += self.rough * self.eddies(p * self.per_period + self.drift);
        }
        for source in self.blowing() {
            v += self.roughened(source, source.stream(p), p);
        }
        v
    }

    /// What a source's body makes of the air in it: a velocity, and in w how much of the place is in it (0-1).
    pub(super) fn body(&self, source: &FreeSource, p: Vec3, cell: f32) -> Vec4 {
        let from_place = p - source.place;
        let along = from_place.dot(source.direction);
        let aside = (from_place - along * source.direction).length();
        if source.kind == FAN {
            let half_thick = (0.75 * cell).max(0.15 * source.radius);
            let share = (0.5 + (half_thick - along.abs()) / cell).clamp(0.0, 1.0)
                * (0.5 + (source.radius - aside) / cell).clamp(0.0, 1.0);
            if share <= 0.0 {
                return Vec4::ZERO;
            }
            let on_disc = p - along * source.direction;
            return self.roughened(source, source.outlet(aside), on_disc).extend(share);
        }
        let share = (0.5 + (source.radius - aside.max(along.abs())) / cell).clamp(0.0, 1.0);
        if share <= 0.0 {
            return Vec4::ZERO;
        }
        self.roughened(source, source.stream(p), p).extend(share)
    }

    /// What a fan makes of the air that goes from a place to another in a step: a velocity, and in w how much of the air goes
    /// through it (0-1).
    pub(super) fn blown_through(&self, source: &FreeSource, before: Vec3, now: Vec3, cell: f32) -> Vec4 {
        let far = (now - source.place).dot(source.direction);
        let behind = (source.place - before).dot(source.direction);
        if source.kind != FAN || far <= 0.0 || behind <= 0.0 {
            return Vec4::ZERO;
        }
        let through = before + behind / (behind + far) * (now - before);
        let aside = through.distance(source.place);
        let share = (0.5 + (source.radius - aside) / cell).clamp(0.0, 1.0);
        if share <= 0.0 {
            return Vec4::ZERO;
        }
        self.roughened(source, source.outlet(aside), through).extend(share)
    }

    pub(super) fn blowing(&self) -> &[FreeSource] {
        &self.sources[..self.n_sources as usize]
    }
}

impl FreeSource {
    /// The stream at a place (world, cm), without its eddies, cm/s.
    pub fn stream(&self, p: Vec3) -> Vec3 {
        let from_place = p - self.place;
        let along = from_place.dot(self.direction);
        let aside = from_place - along * self.direction;
        let r2 = aside.dot(aside);
        if self.kind == FAN {
            if along < 0.0 {
                return Vec3::ZERO;
            }
            let widened = (self.falloff * along / (CORE * self.radius)).max(1.0);
            let b = self.radius * widened;
            let s = r2 / (b * b);
            let far = (along / (CORE * self.radius)).clamp(0.0, 1.0);
            let profile = (-LN_2 * (s * (s + (1.0 - s) * far)).min(80.0)).exp();
            return self.speed / widened * profile * self.direction;
        }
        let core = 0.5 * self.radius;
        let s = r2 / (core * core);
        let flat = along / self.radius;
        let swirl = (0.5 * (1.0 - s.min(80.0)) - (flat * flat).min(80.0)).exp();
        self.speed / core * swirl * self.direction.cross(aside)
    }

    /// What a fan blows through its disc, so far from the axis. Not by [`Self::stream`], which is nothing behind the disc:
    /// rounding puts half of the places on it there.
    fn outlet(&self, aside: f32) -> Vec3 {
        let s = aside * aside / (self.radius * self.radius);
        self.speed * (-LN_2 * (s * s).min(80.0)).exp() * self.direction
    }

    fn new(source: &WindSource, t_secs: f64) -> Self {
        let speed = source.speed * source.gusts.factor(t_secs, source.eddies.seed);
        let (drift, per_period) = drifted(&source.eddies, source.speed * source.direction, t_secs);
        Self {
            place: source.place,
            kind: match source.kind {
                SourceKind::Fan => FAN,
                SourceKind::Vortex => VORTEX,
            },
            direction: source.direction,
            radius: source.radius,
            drift,
            per_period,
            speed: bounded(speed, 0.0, 0.0, 1e4),
            falloff: source.falloff,
            rough: source.eddies.amount,
            pad: 0.0,
        }
    }
}

/// How far eddies have drifted with a wind, in periods (0-1), and periods in a centimetre.
fn drifted(eddies: &Eddies, velocity: Vec3, t_secs: f64) -> (Vec3, f32) {
    let period_cm = PERIODS * eddies.size_cm;
    let start = Vec3::from_array([1, 2, 3].map(|axis| random(eddies.seed, axis)));
    let drift = start.as_dvec3() - velocity.as_dvec3() * (t_secs / f64::from(period_cm));
    ((drift - drift.floor()).min(DVec3::splat(0.999_999_9)).as_vec3(), period_cm.recip())
}

/// A wave of the pattern: two to eight waves a period, larger ones stronger by Kolmogorov's law, together of unit root
/// mean square.
fn mode_of(seed: u32) -> Mode {
    let of = |purpose: u32| 2.0 * random(0x0A1B + seed, purpose) - 1.0;
    // Wave numbers rise from PERIODS, the largest eddies, to twice that.
    let wanted = PERIODS * (1.0 + seed as f32 / (N_MODES - 1) as f32);
    let waves = (wanted * Vec3::new(of(1), of(2), of(3)).normalize_or(Vec3::X)).round();
    let across = waves.cross(Vec3::new(of(4), of(5), of(6))).normalize_or(Vec3::Y);
    // Energy in a band goes with k^(-5/3) dk.
    let strength = |k: u32| (PERIODS * (1.0 + k as f32 / (N_MODES - 1) as f32)).powf(-5.0 / 6.0);
    let energy: f32 = (0..N_MODES as u32).map(|k| 0.5 * strength(k).powi(2)).sum();
    Mode { waves: waves.extend(random(seed, 7)), amplitude: (strength(seed) / energy.sqrt() * across).extend(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn airy() -> SimulationSettings {
        let mut settings = SimulationSettings { wind_speed: 200.0, ..Default::default() };
        settings.air.eddies.amount = 0.3;
        settings
    }

    #[test]
    fn eddies_have_no_divergence_and_the_strength_that_was_asked_for() {
        let free = FreeAir::new(&airy(), 12.5);
        let (mut squared, mut largest_divergence, n) = (0.0, 0.0_f32, 4000);
        for i in 0..n {
            let p = Vec3::from_array([1, 2, 3].map(|axis| 500.0 * random(i, axis)));
            squared += (free.free_air(p) - free.steady).length_squared();
            let h = 0.05;
            let slope = |d: Vec3| (free.free_air(p + h * d) - free.free_air(p - h * d)).dot(d) / (2.0 * h);
            largest_divergence = largest_divergence.max((slope(Vec3::X) + slope(Vec3::Y) + slope(Vec3::Z)).abs());
        }
        let rms = (squared / n as f32).sqrt();
        assert!((rms / 60.0 - 1.0).abs() < 0.15, "{rms} cm/s");
        // Each slope alone is about 60 cm/s over a few centimetres.
        assert!(largest_divergence < 0.1, "{largest_divergence} 1/s");
    }

    #[test]
    fn a_jet_keeps_its_momentum_and_slows_with_distance() {
        let fan = WindSource { place: Vec3::ZERO, direction: Vec3::X, speed: 500.0, radius: 5.0, ..Default::default() };
        let settings = SimulationSettings { sources: vec![fan], ..Default::default() };
        let free = FreeAir::new(&settings, 0.0);
        let at = |x: f32| free.sources[0].stream(Vec3::X * x).x;
        assert!((at(20.0) - 500.0).abs() < 1.0 && at(-1.0) == 0.0);
        assert!((at(240.0) / at(120.0) - 0.5).abs() < 1e-3);
        let momentum = |x: f32| -> f32 {
            (0..4000)
                .map(|i| 0.05 * (i as f32 + 0.5))
                .map(|r| r * free.sources[0].stream(Vec3::new(x, r, 0.0)).x.powi(2))
                .sum()
        };
        assert!((momentum(240.0) / momentum(120.0) - 1.0).abs() < 0.01);
    }

    #[test]
    fn nonsense_makes_no_wind_that_is_not_finite() {
        let bad = WindSource { place: Vec3::NAN, speed: f32::INFINITY, radius: -1.0, ..Default::default() };
        let settings =
            SimulationSettings { wind_speed: f32::NAN, sources: vec![bad; 20], ..SimulationSettings::default() };
        let free = FreeAir::new(&settings, f64::NAN);
        assert_eq!(free.n_sources as usize, MAX_SOURCES);
        for p in [Vec3::ZERO, Vec3::splat(1e30), Vec3::splat(40.0)] {
            assert!(free.free_air(p).is_finite());
        }
    }
}
