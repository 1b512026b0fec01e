//! Whatever the head does, hair keeps its length and stays out of the head, and comes to rest where it was.

use glam::Affine3A;
use lorelei_core::guides::GuideSet;
use lorelei_core::look::Choice;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::{HairKind, SimulationSettings};

use super::scenes::{PIVOT, ball_field, draped, grooms, violent_shake};
use super::{Bound, Row, Rows, Subject, Under};
use crate::Measure;
use crate::bench::BenchError;

/// The worst of every frame.
#[derive(Debug, Clone, Copy, Default)]
pub struct Worst {
    pub length_error_rms: f32,
    pub length_error_max: f32,
    pub penetration_max_cm: f32,
    pub from_rest_rms_cm: f32,
    pub speed_max: f32,
    pub n_not_finite: usize,
}

impl Worst {
    pub fn add(&mut self, now: &Measure) {
        *self = self.and(&Self {
            length_error_rms: now.length_error_rms,
            length_error_max: now.length_error_max,
            penetration_max_cm: now.penetration_max_cm,
            from_rest_rms_cm: now.from_rest_rms_cm,
            speed_max: now.speed_max,
            n_not_finite: now.n_not_finite,
        });
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            length_error_rms: self.length_error_rms.max(other.length_error_rms),
            length_error_max: self.length_error_max.max(other.length_error_max),
            penetration_max_cm: self.penetration_max_cm.max(other.penetration_max_cm),
            from_rest_rms_cm: self.from_rest_rms_cm.max(other.from_rest_rms_cm),
            speed_max: self.speed_max.max(other.speed_max),
            n_not_finite: self.n_not_finite.max(other.n_not_finite),
        }
    }
}

/// A groom on the ball through one period of a motion, at 60 frames a second: the worst on the way, and how it is after
/// `rest_secs` more.
pub fn through(
    under: &Under<'_>,
    guides: &GuideSet,
    settings: &SimulationSettings,
    motion: Motion,
    rest_secs: f32,
) -> Result<(Worst, Measure), BenchError> {
    let mut subject = Subject::new(under, guides, Some(&ball_field()), settings)?;
    let mut worst = Worst::default();
    let mut blown = settings.clone();
    for frame in 1..=(60.0 * motion.period_secs()) as u32 {
        let t = frame as f32 / 60.0;
        if motion.moves_air() {
            let direction = SimulationSettings { wind_speed: 1.0, ..settings.clone() }.wind_velocity();
            blown.set_wind_velocity(motion.wind(t, settings.wind_velocity(), direction));
            subject.set_settings(&blown)?;
        }
        subject.set_head_pose(&motion.pose(t, PIVOT));
        subject.advance(1.0 / 60.0)?;
        worst.add(&subject.measure()?);
    }
    subject.settle(rest_secs)?;
    Ok((worst, subject.measure()?))
}

/// One row a motion: the worst of every kind of hair, long and curled.
pub fn every_motion(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    let grooms = [draped(12, 32, 35.0, 0.0), draped(12, 32, 25.0, 0.5)];
    for &motion in Motion::ALL.iter().filter(|motion| motion.period_secs() > 0.0) {
        let mut worst = Worst::default();
        for &kind in HairKind::ALL {
            let mut settings = under.settings();
            settings.take(kind);
            for guides in &grooms {
                worst = worst.and(&through(under, guides, &settings, motion, 0.0)?.0);
            }
        }
        rows.extend(of_worst(under, motion.info().name, &worst));
    }
    Ok(rows)
}

/// A violent shake for two seconds, of every groom with every kind of hair.
pub fn violent_shakes(under: &Under<'_>) -> Rows {
    let mut worst = Worst::default();
    for &kind in HairKind::ALL {
        let mut settings = under.settings();
        settings.take(kind);
        for (_, guides) in grooms() {
            worst = worst.and(&violent(under, &guides, &settings)?);
        }
    }
    Ok(of_worst(under, "violent shake, 34 degrees to either side at 2.5 Hz", &worst).into())
}

/// Two seconds of a violent shake.
pub fn violent(under: &Under<'_>, guides: &GuideSet, settings: &SimulationSettings) -> Result<Worst, BenchError> {
    let mut worst = Worst::default();
    let mut subject = Subject::new(under, guides, Some(&ball_field()), settings)?;
    subject.run(2.0, 60.0, violent_shake, |now| worst.add(now))?;
    Ok(worst)
}

fn of_worst(under: &Under<'_>, scene: &str, worst: &Worst) -> [Row; 2] {
    let error = 100.0 * f64::from(worst.length_error_rms);
    [
        under.row("length error, RMS", scene, error, "%", Bound::AtMost(1.0)),
        under.row("deepest in the head", scene, worst.penetration_max_cm.into(), "cm", Bound::AtMost(0.1)),
    ]
}

/// Back at rest after a motion: shaken hair must not stay where it was thrown. Of the four grooms.
pub fn come_back(under: &Under<'_>) -> Rows {
    let mut rows = Vec::new();
    for (name, guides) in grooms() {
        let (_, after) = through(under, &guides, &under.settings(), Motion::Shake, 6.0)?;
        let scene = format!("{name}, six seconds after a shake");
        let bound = Bound::AtMost(1.0);
        rows.push(under.row("back where it was, RMS", scene.clone(), after.from_rest_rms_cm.into(), "cm", bound));
        rows.push(under.row("no jitter", scene, after.speed_max.into(), "cm/s", Bound::AtMost(0.1)));
    }
    Ok(rows)
}

/// The head does not move.
pub fn still(_: f32) -> Affine3A {
    Affine3A::IDENTITY
}
