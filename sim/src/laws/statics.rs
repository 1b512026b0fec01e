//! Where hair hangs must be a matter of the hair: of no step, no iteration and no number of vertices.

use glam::Vec3;
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::{RestShape, SimulationSettings, Wind};

use super::scenes::{ball_field, cantilever, draped, hanging};
use super::{Bound, Rows, Subject, Under};
use crate::bench::BenchError;

/// Length of the cantilever, cm.
const LENGTH: f32 = 10.0;
/// Length of what drapes, cm.
const DRAPED: f32 = 30.0;

/// Nothing but weight and bending.
pub fn bare(under: &Under<'_>) -> SimulationSettings {
    let bare = under.settings();
    SimulationSettings { hold: 0.0, drag: 0.0, damping: 5.0, bend_damping: 0.0, wind: Wind::Off, ..bare }
}

/// Where the tip of a clamped, horizontal strand hangs when its shape without weight is straight: the elastica
/// B phi'' = (L - s) cos(phi), by shooting for the curvature at the root that vanishes at the tip.
pub fn elastica(length: f64, bend_length: f64) -> [f64; 2] {
    let stiffness = bend_length.powi(3);
    let n = 4000;
    let ds = length / f64::from(n);
    let shoot = |at_root: f64| {
        let (mut phi, mut curvature, mut x, mut y) = (0.0_f64, at_root, 0.0, 0.0);
        for i in 0..n {
            let s = (f64::from(i) + 0.5) * ds;
            let middle = phi + 0.5 * ds * curvature;
            let slope = (length - s) * middle.cos() / stiffness;
            phi += ds * (curvature + 0.5 * ds * slope);
            curvature += ds * slope;
            x += ds * middle.cos();
            y += ds * middle.sin();
        }
        (curvature, phi, [x, y])
    };
    // From the shape of a rope, bent by a right angle at the root, upwards: the first curvature whose tip is straight and
    // hangs.
    let (mut most, mut least) = (0.0, -10.0 * length * length / stiffness);
    for _ in 0..200 {
        let middle = 0.5 * (most + least);
        let (at_tip, phi, _) = shoot(middle);
        let is_too_bent = at_tip < 0.0 || phi < -std::f64::consts::FRAC_PI_2;
        if is_too_bent { least = middle } else { most = middle }
    }
    shoot(most).2
}

/// How far the cantilever's tip is from the elastica's, as a share of the length.
pub fn droop_error(
    under: &Under<'_>,
    bend_length: f32,
    n_vertices: u32,
    steps_per_second: f32,
) -> Result<f32, BenchError> {
    let [x, y] = elastica(f64::from(LENGTH), f64::from(bend_length));
    let rest_shape = RestShape::Weightless;
    let settings = SimulationSettings { rest_shape, bend_length, steps_per_second, ..bare(under) };
    let mut subject = Subject::new(under, &cantilever(LENGTH, n_vertices), None, &settings)?;
    subject.settle(10.0)?;
    let tip = subject.positions()?.last().copied().unwrap_or(Vec3::NAN);
    Ok(tip.distance(Vec3::new(x as f32, y as f32, 0.0)) / LENGTH)
}

/// Three stiffnesses, three resolutions; the worst of 30 to 240 steps a second.
pub fn cantilevers(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    for bend_length in [3.0, 5.0, 10.0] {
        for n_vertices in [16, 32, 64] {
            let mut worst = 0.0_f32;
            for steps_per_second in [30.0, 60.0, 120.0, 240.0] {
                worst = worst.max(droop_error(under, bend_length, n_vertices, steps_per_second)?);
            }
            let scene = format!("stiffness {bend_length} cm, {n_vertices} vertices, 30 to 240 Hz");
            let bound = Bound::AtMost(3.0);
            rows.push(under.row(
                "tip of a cantilever, from the elastica",
                scene,
                f64::from(100.0 * worst),
                "% of length",
                bound,
            ));
        }
    }
    Ok(rows)
}

/// What takes hair from its style.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// Its weight: the style is the shape without.
    Weight,
    /// A steady wind of 300 cm/s.
    Wind,
}

impl Load {
    fn name(self) -> &'static str {
        match self {
            Self::Weight => "over a ball, sagged under its weight",
            Self::Wind => "over a ball, held by the wind",
        }
    }

    fn settings(self, under: &Under<'_>) -> SimulationSettings {
        let settings = under.settings();
        match self {
            Self::Weight => SimulationSettings { rest_shape: RestShape::Weightless, ..settings },
            Self::Wind => SimulationSettings { wind_speed: 300.0, ..settings },
        }
    }
}

/// Hair of 30 cm over the head, for eight seconds: where it hangs.
pub fn drape(
    under: &Under<'_>,
    load: Load,
    steps_per_second: f32,
    more_iterations: u32,
) -> Result<Vec<Vec3>, BenchError> {
    let settings = load.settings(under);
    let n_iterations = settings.n_iterations * more_iterations;
    let settings = SimulationSettings { steps_per_second, n_iterations, ..settings };
    hang(under, &draped(8, 32, DRAPED, 0.0), true, &settings)
}

fn hang(
    under: &Under<'_>,
    guides: &GuideSet,
    is_on_ball: bool,
    settings: &SimulationSettings,
) -> Result<Vec<Vec3>, BenchError> {
    let field = is_on_ball.then(ball_field);
    let mut subject = Subject::new(under, guides, field.as_ref(), settings)?;
    subject.settle(8.0)?;
    subject.positions()
}

/// A hanging strand in the wind at eight places that it has with any number of vertices of the form 7 n + 2.
pub fn strand_in_wind(under: &Under<'_>, n_vertices: u32) -> Result<Vec<Vec3>, BenchError> {
    let x = hang(under, &hanging(DRAPED, n_vertices), false, &Load::Wind.settings(under))?;
    Ok((0..8).map(|i| x[1 + i * (n_vertices as usize - 2) / 7]).collect())
}

/// The farthest of two shapes from each other, as a share of the length in hundredths.
pub fn apart(a: &[Vec3], b: &[Vec3]) -> f64 {
    let farthest = a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    f64::from(100.0 * farthest / DRAPED)
}

/// The same drape at other steps, iterations and resolutions.
pub fn drapes(under: &Under<'_>) -> Rows {
    const LAW: &str = "the same drape, farthest apart";
    let bound = Bound::AtMost(2.0);
    let mut rows = Vec::new();
    for load in [Load::Weight, Load::Wind] {
        let reference = drape(under, load, 240.0, 1)?;
        for steps_per_second in [30.0, 60.0, 120.0] {
            let value = apart(&reference, &drape(under, load, steps_per_second, 1)?);
            let scene = format!("{}: {steps_per_second} Hz against 240", load.name());
            rows.push(under.row(LAW, scene, value, "% of length", bound));
        }
        let value = apart(&reference, &drape(under, load, 240.0, 2)?);
        rows.push(under.row(LAW, format!("{}: twice the iterations", load.name()), value, "% of length", bound));
    }
    let value = apart(&strand_in_wind(under, 16)?, &strand_in_wind(under, 65)?);
    rows.push(under.row(LAW, "a strand held by the wind: 16 vertices against 65", value, "% of length", bound));
    Ok(rows)
}
