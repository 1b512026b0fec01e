//! A groom at rest stays at rest, whatever kind of hair it is and whatever is switched on.

use lorelei_core::guides::GuideSet;
use lorelei_core::look::Choice;
use lorelei_core::simulation::{HairKind, Pearl, SimulationSettings, Volume, Wind};

use super::scenes::{ball_field, draped, grooms};
use super::{Bound, Rows, Subject, Under};
use crate::Measure;
use crate::bench::BenchError;

const SPEED: &str = "a groom at rest: fastest vertex";
const DRIFT: &str = "a groom at rest: drift, RMS";

/// Let time pass over a groom on a still head, at so many frames a second.
pub fn left_alone(
    under: &Under<'_>,
    guides: &GuideSet,
    settings: &SimulationSettings,
    secs: f32,
    frames_per_second: f32,
) -> Result<Measure, BenchError> {
    let mut subject = Subject::new(under, guides, Some(&ball_field()), settings)?;
    for _ in 0..(secs * frames_per_second).round() as u32 {
        subject.advance(1.0 / frames_per_second)?;
    }
    subject.measure()
}

/// The four grooms under gravity for ten seconds.
pub fn ten_seconds(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    for (name, guides) in grooms() {
        let last = left_alone(under, &guides, &under.settings(), 10.0, 60.0)?;
        rows.push(under.row(SPEED, format!("{name}, after 10 s"), last.speed_max.into(), "cm/s", Bound::AtMost(1e-4)));
    }
    Ok(rows)
}

/// Every kind of hair for ten minutes, at sixty steps a second: the law must not need finer ones.
pub fn ten_minutes(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    for &kind in HairKind::ALL {
        let (mut speed, mut drift) = (0.0_f32, 0.0_f32);
        for guides in [draped(3, 32, 35.0, 0.0), draped(3, 32, 25.0, 0.5), draped(3, 32, 15.0, 0.5)] {
            let mut settings = under.settings();
            settings.take(kind);
            settings.steps_per_second = 60.0;
            let last = left_alone(under, &guides, &settings, 600.0, 30.0)?;
            (speed, drift) = (speed.max(last.speed_max), drift.max(last.from_rest_rms_cm));
        }
        let scene = format!("{}, after 10 min at 60 Hz", kind.info().name);
        rows.push(under.row(SPEED, scene.clone(), speed.into(), "cm/s", Bound::AtMost(1e-4)));
        rows.push(under.row(DRIFT, scene, drift.into(), "cm", Bound::AtMost(1e-3)));
    }
    Ok(rows)
}

/// Everything that can act on hair, switched on: the air's grid, hair on hair, thickness.
pub fn everything_on(settings: &SimulationSettings, volume: Volume) -> SimulationSettings {
    let mut settings = SimulationSettings { volume, pearl: Pearl::Growing, wind: Wind::Grid, ..settings.clone() };
    settings.air.resolution = 16;
    settings
}

/// Softer and looser than every kind.
pub fn soft(under: &Under<'_>) -> SimulationSettings {
    SimulationSettings { hold: 0.5, bend_length: 0.3, ..under.settings() }
}

/// Curls with everything on, left alone for ten seconds.
pub fn curls_with(under: &Under<'_>, name: &str, settings: &SimulationSettings, volume: Volume) -> Rows {
    let settings = everything_on(settings, volume);
    let last = left_alone(under, &draped(30, 24, 22.0, 0.5), &settings, 10.0, 60.0)?;
    let scene = format!("curls, {name}, wind=grid, pearls, volume={}, after 10 s", volume.info().name);
    Ok(vec![
        under.row(SPEED, scene.clone(), last.speed_max.into(), "cm/s", Bound::AtMost(1e-4)),
        under.row(DRIFT, scene, last.from_rest_rms_cm.into(), "cm", Bound::AtMost(1e-3)),
    ])
}

/// Every kind of hair with everything on, and one that is softer and looser than all of them.
pub fn with_every_choice(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    for &kind in HairKind::ALL {
        let mut settings = under.settings();
        settings.take(kind);
        rows.extend(curls_with(under, kind.info().name, &settings, Volume::DensityVelocity)?);
    }
    for volume in [Volume::Density, Volume::DensityVelocity] {
        rows.extend(curls_with(under, "soft and loose", &soft(under), volume)?);
    }
    Ok(rows)
}
