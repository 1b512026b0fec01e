//! The same inputs give the same frames, and going back gives the frame that was there: to the last bit.

use glam::{Affine3A, Vec3};
use lorelei_core::motion::Motion;
use lorelei_core::simulation::{SimulationSettings, Volume};

use super::rest::everything_on;
use super::scenes::{PIVOT, ball_field, draped};
use super::{Bound, Rows, Subject, Under};
use crate::bench::BenchError;

const FPS: f32 = 60.0;

fn pass(subject: &mut Subject<'_>, frames: std::ops::Range<u32>) -> Result<Vec<Vec3>, BenchError> {
    for frame in frames {
        subject.set_head_pose(&Motion::Shake.pose((frame + 1) as f32 / FPS, PIVOT));
        subject.advance(1.0 / FPS)?;
    }
    subject.positions()
}

fn differing(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).filter(|(a, b)| a.to_array().map(f32::to_bits) != b.to_array().map(f32::to_bits)).count() as f64
}

/// Vertices that differ: between two runs; after going back to a kept state; and from the first frame after a reset.
pub fn differences(under: &Under<'_>, settings: &SimulationSettings) -> Result<[f64; 3], BenchError> {
    let (field, guides) = (ball_field(), draped(24, 24, 20.0, 0.3));
    let new = || Subject::new(under, &guides, Some(&field), settings);
    let (mut one, mut other) = (new()?, new()?);
    pass(&mut one, 0..30)?;
    let kept = one.read_state()?;
    let last = pass(&mut one, 30..60)?;
    let between_runs = differing(&last, &pass(&mut other, 0..60)?);
    // Another pass of time, then back.
    pass(&mut one, 60..75)?;
    let is_taken = one.write_state(&kept);
    let scrubbed = if is_taken { differing(&last, &pass(&mut one, 30..60)?) } else { f64::NAN };
    one.set_head_pose(&Affine3A::IDENTITY);
    one.reset();
    let after_reset = differing(&one.positions()?, &guides.positions);
    Ok([between_runs, scrubbed, after_reset])
}

/// A second of a shake, bare and with everything on.
pub fn frames(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    let bare = under.settings();
    let full = SimulationSettings { wind_speed: 300.0, ..everything_on(&bare, Volume::DensityVelocity) };
    for (name, settings) in [("a second of a shake", bare), ("the same, everything on, in wind", full)] {
        let values = differences(under, &settings)?;
        let laws = [
            "the same frames again: vertices that differ",
            "scrubbed back: vertices that differ",
            "reset is rest: vertices that differ",
        ];
        rows.extend(
            laws.into_iter().zip(values).map(|(law, value)| under.row(law, name, value, "", Bound::AtMost(0.0))),
        );
    }
    Ok(rows)
}
