//! Nothing breaks a solver: whatever goes in, numbers come out, and once it is over the hair is where it belongs.

use glam::{Affine3A, Vec3};
use lorelei_core::collider::Collider;
use lorelei_core::guides::GuideSet;
use lorelei_core::simulation::{Pearl, SimulationSettings};

use super::scenes::{RADIUS, ball_field, draped, violent_shake};
use super::{Bound, Rows, Subject, Under};
use crate::Measure;
use crate::bench::BenchError;

/// Hair with a strand in the middle of the head, one at a single point, one of NaN and one that turns back on itself.
pub fn awkward() -> GuideSet {
    let mut awkward = draped(8, 16, 12.0, 0.0);
    for k in 0..16 {
        awkward.positions[k] = Vec3::new(0.01 * k as f32, 0.0, 0.0);
        awkward.positions[16 + k] = Vec3::Y * RADIUS;
        awkward.positions[32 + k] = Vec3::NAN;
        awkward.positions[48 + k] = Vec3::Y * (RADIUS + (k % 2) as f32);
    }
    awkward
}

/// Settings that no one means.
pub fn wild(settings: &SimulationSettings) -> SimulationSettings {
    SimulationSettings {
        gravity: f32::NAN,
        damping: f32::INFINITY,
        bend_length: 1e30,
        hold: -5.0,
        wind_speed: 1e30,
        steps_per_second: 0.0,
        n_iterations: 0,
        colliders: vec![
            Collider::sphere("ball", Vec3::new(0.0, -12.0, 0.0), 5.0),
            Collider::sphere("none", Vec3::NAN, f32::NAN),
        ],
        pearl: Pearl::Growing,
        pearl_radius: f32::NAN,
        ..settings.clone()
    }
}

/// Four seconds of teleports, poses that are no numbers, and frames of no time, of endless time and of NaN: most vertices
/// that were not finite in a frame.
pub fn mistreated(under: &Under<'_>, settings: &SimulationSettings) -> Result<usize, BenchError> {
    let mut subject = Subject::new(under, &awkward(), Some(&ball_field()), settings)?;
    let mut most = 0;
    for frame in 0..240 {
        let pose = match frame % 48 {
            11 => Affine3A::from_translation(Vec3::splat(1e4)),
            23 => Affine3A::from_rotation_x(3.0),
            35 => Affine3A::from_translation(Vec3::NAN),
            _ => violent_shake(frame as f32 / 60.0),
        };
        subject.set_head_pose(&pose);
        subject.advance([1.0 / 60.0, 0.0, 1e9, f32::NAN][frame % 4])?;
        most = most.max(subject.measure()?.n_not_finite);
    }
    Ok(most)
}

/// What six seconds make of hair that was put to a single point inside the head.
pub fn crushed(under: &Under<'_>) -> Result<Measure, BenchError> {
    let guides = draped(8, 24, 20.0, 0.3);
    let mut subject = Subject::new(under, &guides, Some(&ball_field()), &under.settings())?;
    let at_a_point = vec![Vec3::ZERO; guides.positions.len()];
    subject.set_state(&at_a_point, &at_a_point);
    subject.settle(6.0)?;
    subject.measure()
}

/// How far hair is from its style a tenth of a second after the head was put five metres away.
pub fn teleported(under: &Under<'_>) -> Result<Measure, BenchError> {
    let guides = draped(8, 24, 20.0, 0.3);
    let mut subject = Subject::new(under, &guides, Some(&ball_field()), &under.settings())?;
    let far = Affine3A::from_translation(Vec3::new(500.0, 100.0, 0.0));
    subject.run(0.1, 60.0, |_| far, |_| ())?;
    subject.measure()
}

/// All of it.
pub fn nonsense(under: &Under<'_>) -> Rows {
    const LAW: &str = "never NaN: vertices that are no numbers";
    let scene = "strands in the head, at a point, of NaN, folded; teleports; frames of 0, 1e9 s and NaN";
    let mut rows = Vec::new();
    let n = mistreated(under, &under.settings())?;
    rows.push(under.row(LAW, scene, n as f64, "", Bound::AtMost(0.0)));
    let n = mistreated(under, &wild(&under.settings()))?;
    rows.push(under.row(LAW, format!("{scene}; settings of NaN and 1e30"), n as f64, "", Bound::AtMost(0.0)));
    let last = crushed(under)?;
    let scene = "6 s after all of it was put to a point in the head";
    let error = 100.0 * f64::from(last.length_error_rms);
    rows.push(under.row("recovers: length error, RMS", scene, error, "%", Bound::AtMost(1.0)));
    rows.push(under.row(
        "recovers: deepest in the head",
        scene,
        last.penetration_max_cm.into(),
        "cm",
        Bound::AtMost(0.1),
    ));
    let away = teleported(under)?.from_rest_rms_cm;
    let scene = "head put 5 m away";
    let bound = Bound::AtMost(if under.solver == lorelei_core::simulation::Solver::Rods { 0.01 } else { 0.5 });
    rows.push(under.row("a teleport carries the hair, RMS", scene, away.into(), "cm", bound));
    Ok(rows)
}
