//! What the grid of air promises, whatever the hair in it does.

use std::ops::Range;

use glam::{Vec3, Vec4Swizzles};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::look::Switch;
use lorelei_core::simulation::{SimulationSettings, Wind};
use lorelei_core::wind::{AirSettings, Eddies, WindSource};

use super::scenes::{ball_field, draped};
use super::{Bound, Row};
use crate::CpuSolver;
use crate::contact::Obstacles;
use crate::pose::Pose;
use crate::wind::ROOM;
use crate::wind::cpu::{HairLayer, divergence_rms};
use crate::wind::{CpuWind, WindFrame};

const FRAME_SECS: f32 = 1.0 / 60.0;

/// Wind on a grid of so many cells.
pub fn windy(speed: f32, resolution: u32) -> SimulationSettings {
    SimulationSettings {
        wind: Wind::Grid,
        wind_speed: speed,
        air: AirSettings { resolution, ..AirSettings::default() },
        ..SimulationSettings::default()
    }
}

/// A box of 40 cm about the origin.
pub fn boxed(settings: &SimulationSettings) -> CpuWind {
    CpuWind::new([Vec3::splat(-12.5), Vec3::splat(12.5)].into_iter(), settings, Pose::IDENTITY)
}

/// Let frames of a sixtieth of a second pass around a head at rest.
pub fn pass(
    wind: &mut CpuWind,
    settings: &SimulationSettings,
    field: Option<&DistanceField>,
    hair: &[HairLayer<'_>],
    frames: Range<u32>,
) {
    for frame in frames {
        let t_secs = f64::from(frame + 1) * f64::from(FRAME_SECS);
        let frame = WindFrame { pose: Pose::IDENTITY, jumped: false, t_secs, frame_secs: FRAME_SECS };
        wind.advance(settings, Obstacles::new(field, &[], settings), hair, &frame);
    }
}

/// Divergence that is left, RMS, cm/s, so many frames after a head stood suddenly in a wind of 350 cm/s.
pub fn divergence_left(resolution: u32, n_cycles: u32, n_frames: u32) -> f32 {
    let mut settings = windy(350.0, resolution);
    settings.air.n_cycles = n_cycles;
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, Some(&ball_field()), &[], 0..n_frames);
    divergence_rms(wind.grid(), wind.faces())
}

/// Divergence that is left, RMS, and the fastest air, cm/s, half a second after a fan of 800 cm/s began to blow at the ball
/// from outside of the box, through a part of its boundary alone.
pub fn fan_from_outside(resolution: u32) -> (f32, f32) {
    let mut settings = windy(0.0, resolution);
    let place = Vec3::new(40.0, 0.0, 20.0);
    settings.sources = vec![WindSource { place, direction: -place.normalize(), speed: 800.0, ..WindSource::default() }];
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, Some(&ball_field()), &[], 0..30);
    let fastest = wind.air().cells().map(|(_, v)| v.xyz().length()).fold(0.0, f32::max);
    (divergence_rms(wind.grid(), wind.faces()), fastest)
}

/// A fan that blows aslant through still air, by where it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fan {
    /// In the box.
    Inside,
    /// Nearer to the box than its air goes in a frame.
    Outside,
}

/// Mean speed on the axis of a fan of 800 cm/s, 1, 2, 3 and 4 diameters of its outlet before it, as a share of the outlet's
/// speed: 0.6 to 1 s after it began. A free jet keeps its speed for six diameters (Pope 2000, section 5.1).
pub fn on_the_axis(fan: Fan, resolution: u32) -> [f32; 4] {
    let (side, far) = match fan {
        Fan::Inside => (80.0, 30.0),
        Fan::Outside => (64.0, 45.0),
    };
    let direction = Vec3::new(-0.9, 0.0, -0.4).normalize();
    let source = WindSource { place: -far * direction, direction, speed: 800.0, ..WindSource::default() };
    let source = WindSource { eddies: Eddies { amount: 0.0, ..source.eddies }, ..source };
    let diameter = 2.0 * source.radius;
    let settings = SimulationSettings { sources: vec![source], ..windy(0.0, resolution) };
    let corner = Vec3::splat(0.5 * side / ROOM);
    let mut wind = CpuWind::new([-corner, corner].into_iter(), &settings, Pose::IDENTITY);
    pass(&mut wind, &settings, None, &[], 0..36);
    let mut shares = [0.0; 4];
    for frame in 36..60 {
        pass(&mut wind, &settings, None, &[], frame..frame + 1);
        for (i, share) in shares.iter_mut().enumerate() {
            let p = (diameter * (i + 1) as f32 - far) * direction;
            *share += wind.air().air_velocity(p).dot(direction) / (24.0 * 800.0);
        }
    }
    shares
}

/// Mean speeds along a wind of 300 cm/s to +X around the ball, after 1.5 s, cm/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AroundTheHead {
    /// 3 cm behind it.
    pub lee: f32,
    /// 9 cm before it.
    pub before: f32,
    /// 4 cm beside it.
    pub side: f32,
    pub inside: f32,
}

/// As they are with an obstacle or without.
pub fn around_the_head(obstacle: Switch) -> AroundTheHead {
    let mut settings = windy(300.0, 32);
    settings.air.obstacle = obstacle;
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, Some(&ball_field()), &[], 0..90);
    let air = wind.air();
    let mean = |at: Vec3| {
        let around = [Vec3::ZERO, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z].map(|d| air.air_velocity(at + 2.0 * d));
        around.iter().map(|v| v.x).sum::<f32>() / 5.0
    };
    AroundTheHead {
        lee: mean(Vec3::X * 12.0),
        before: mean(Vec3::X * -18.0),
        side: mean(Vec3::Y * 13.0),
        inside: mean(Vec3::ZERO),
    }
}

/// Farthest from the wind that air in an empty box goes in half a second, cm/s.
pub fn astray_in_an_empty_box() -> f32 {
    let settings = windy(350.0, 16);
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, None, &[], 0..30);
    let blows = settings.wind_velocity();
    wind.air().cells().map(|(_, v)| v.xyz().distance(blows)).fold(0.0, f32::max)
}

/// Largest gain of kinetic energy in a frame of air that nothing drives, a stream and a ball of it that turns, as a share.
pub fn energy_gained() -> f64 {
    let mut settings = windy(0.0, 16);
    settings.air.vorticity = 0.0;
    let mut wind = boxed(&settings);
    wind.fill(|p| (Vec3::Y.cross(p) * 20.0 + Vec3::new(0.0, 100.0, 0.0)) * (-p.length_squared() / 60.0).exp());
    let energy = |wind: &CpuWind| wind.air().cells().map(|(_, v)| f64::from(v.xyz().length_squared())).sum::<f64>();
    // The first frame takes the divergence away.
    pass(&mut wind, &settings, Some(&ball_field()), &[], 0..1);
    let mut before = energy(&wind);
    let mut most = if before > 0.0 { f64::NEG_INFINITY } else { f64::NAN };
    for frame in 1..40 {
        pass(&mut wind, &settings, Some(&ball_field()), &[], frame..frame + 1);
        let now = energy(&wind);
        most = most.max(now / before - 1.0);
        before = now;
    }
    most
}

/// How far hair goes from its rest in a wind of 300 cm/s to +X on the grid, over how far it goes in uniform wind, %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairInWind {
    /// Of all guides, RMS.
    pub all: f64,
    /// Of the tips on the side where the wind comes from, and on the other.
    pub windward: f64,
    pub lee: f64,
}

/// A whole head of hair over the ball, after 1.5 s.
pub fn hair_in_wind() -> HairInWind {
    let guides = draped(60, 16, 20.0, 0.0);
    let field = ball_field();
    let blown = |wind: Wind| {
        let settings = SimulationSettings { wind, ..windy(300.0, 32) };
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
        for _ in 0..90 {
            solver.advance(FRAME_SECS);
        }
        let tips = |is_there: fn(f32) -> bool| {
            let n = guides.n_vertices as usize;
            let tips = guides.positions.iter().zip(solver.positions(0)).skip(n - 1).step_by(n);
            let moved = tips.filter(|(rest, _)| is_there(rest.x)).map(|(rest, now)| rest.distance(now.xyz()));
            moved.fold((0.0, 0.0), |(sum, n), moved| (sum + moved, n + 1.0))
        };
        let mean = |(sum, n): (f32, f32)| f64::from(sum / n);
        [solver.measure().from_rest_rms_cm.into(), mean(tips(|x| x < -4.0)), mean(tips(|x| x > 4.0))]
    };
    let (uniform, grid) = (blown(Wind::Uniform), blown(Wind::Grid));
    let [all, windward, lee] = std::array::from_fn(|i| 100.0 * grid[i] / uniform[i]);
    HairInWind { all, windward, lee }
}

/// All of them.
pub fn of_air() -> Vec<Row> {
    let row = |law, scene: String, value: f64, unit, bound| Row { law, scene, of: "air", value, unit, bound };
    let mut rows = Vec::new();
    for resolution in [16, 32, 48] {
        let left = [1, 2, 3].map(|n_cycles| f64::from(divergence_left(resolution, n_cycles, 1)));
        let law = "divergence after projection, RMS";
        let scene = format!("{resolution} cells, a head suddenly in 350 cm/s, 2 cycles");
        rows.push(row(law, scene, left[1], "cm/s", Bound::AtMost(1.0)));
        let scene = format!("{resolution} cells, 30 frames later");
        rows.push(row(law, scene, divergence_left(resolution, 2, 30).into(), "cm/s", Bound::AtMost(0.1)));
        let share = 100.0 * (left[1] / left[0]).max(left[2] / left[1]);
        rows.push(row("what a cycle leaves of it", format!("{resolution} cells"), share, "%", Bound::AtMost(30.0)));
    }
    for resolution in [32, 48] {
        let (divergence, fastest) = fan_from_outside(resolution);
        let scene = format!("{resolution} cells, a fan of 800 cm/s outside of the box, after 0.5 s");
        let law = "divergence after projection, RMS";
        rows.push(row(law, scene.clone(), divergence.into(), "cm/s", Bound::AtMost(2.0)));
        let law = "no air is faster than what drives it";
        rows.push(row(law, scene, fastest.into(), "cm/s", Bound::AtMost(1000.0)));
    }
    for (fan, stands) in [(Fan::Inside, "inside the box"), (Fan::Outside, "outside of the box")] {
        let at = [32, 48].map(|resolution| on_the_axis(fan, resolution));
        let scene = format!("a fan of 800 cm/s {stands}, one to four diameters before it");
        let least = at.iter().flatten().copied().fold(f32::INFINITY, f32::min);
        let law = "a fan's stream keeps its speed";
        rows.push(row(law, scene.clone(), f64::from(100.0 * least), "% of it", Bound::AtLeast(90.0)));
        let apart = at[0].iter().zip(at[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        let law = "and does so on any grid: 32 cells against 48";
        rows.push(row(law, scene, f64::from(100.0 * apart), "% of it", Bound::AtMost(5.0)));
    }
    let around = around_the_head(Switch::On);
    let share = |speed: f32| f64::from(speed) / 3.0;
    let scene = |place: &str| format!("{place} a ball of 9 cm in 300 cm/s");
    let calm = "calm in the lee of the head";
    rows.push(row(calm, scene("3 cm behind"), share(around.lee.abs()), "% of the wind", Bound::AtMost(33.0)));
    let blows = "the wind goes around it";
    rows.push(row(blows, scene("9 cm before"), share(around.before), "% of the wind", Bound::AtLeast(67.0)));
    rows.push(row(blows, scene("4 cm beside"), share(around.side), "% of the wind", Bound::AtLeast(105.0)));
    rows.push(row(
        "still in the head",
        scene("inside"),
        share(around.inside.abs()),
        "% of the wind",
        Bound::AtMost(0.3),
    ));
    let hair = hair_in_wind();
    let scene = |whose: &str| format!("a head of hair on a ball, 300 cm/s, {whose}");
    let law = "the grid's wind moves hair";
    let unit = "% of uniform wind's way";
    rows.push(row(law, scene("all of it"), hair.all, unit, Bound::AtLeast(40.0)));
    rows.push(row(law, scene("windward tips"), hair.windward, unit, Bound::AtLeast(60.0)));
    rows.push(row("hair shelters hair", scene("tips in the lee"), hair.lee, unit, Bound::AtMost(70.0)));
    let straight = "steady wind stays as it is";
    rows.push(row(
        straight,
        "an empty box, 0.5 s of 350 cm/s".to_owned(),
        astray_in_an_empty_box().into(),
        "cm/s",
        Bound::AtMost(0.01),
    ));
    let law = "energy gained in a frame, nothing drives it";
    rows.push(row(
        law,
        "a stream and a whirl around a head".to_owned(),
        100.0 * energy_gained(),
        "%",
        Bound::AtMost(0.1),
    ));
    rows
}
