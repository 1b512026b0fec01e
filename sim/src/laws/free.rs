//! A strand that nothing hinders keeps what mechanics says it keeps.

use glam::{Quat, Vec3};
use lorelei_core::simulation::SimulationSettings;

use super::scenes::hanging;
use super::statics::bare;
use super::{Bound, Rows, Subject, Under};
use crate::bench::BenchError;

/// Steps a second while a chain whips: what implicit steps lose is told apart from what is wrong.
const WHIP_HZ: f32 = 960.0;

/// Angular momentum about the pin and kinetic energy after each of `n_steps`, over those after the first.
pub fn whipped(under: &Under<'_>, n_steps: usize) -> Result<Vec<[f32; 2]>, BenchError> {
    // A chain without stiffness on a fixed pin, without weight: its angular momentum about the pin is kept.
    let n_vertices = 24;
    let guides = hanging(20.0, n_vertices);
    let settings = SimulationSettings {
        gravity: 0.0,
        damping: 0.0,
        damping_along: 0.0,
        bend_length: 0.0,
        shape: 0.0,
        steps_per_second: WHIP_HZ,
        ..bare(under)
    };
    let mut subject = Subject::new(under, &guides, None, &settings)?;
    let x = guides.positions;
    let dt = 1.0 / WHIP_HZ;
    let pin = x[1];
    // Swinging about Z, faster towards the tip.
    let velocity = |p: Vec3| Vec3::Z.cross(p - pin) * (2.0 + 0.2 * (p - pin).length());
    let prev: Vec<Vec3> = x.iter().map(|&p| p - dt * velocity(p)).collect();
    subject.set_state(&x, &prev);
    let mass = |k: usize| if k + 1 == n_vertices as usize { 0.5 } else { 1.0 };
    let (mut before, mut kept) = (x, Vec::new());
    for _ in 0..n_steps {
        subject.step_once()?;
        let now = subject.positions()?;
        let (mut momentum, mut energy) = (0.0, 0.0);
        for k in 2..now.len() {
            let v = (now[k] - before[k]) / dt;
            momentum += mass(k) * (now[k] - pin).cross(v).z;
            energy += 0.5 * mass(k) * v.length_squared();
        }
        kept.push([momentum, energy]);
        before = now;
    }
    let first = kept.first().copied().unwrap_or([1.0; 2]);
    Ok(kept.into_iter().map(|now| [now[0] / first[0], now[1] / first[1]]).collect())
}

/// Half a second of whipping.
pub fn whip(under: &Under<'_>) -> Rows {
    let kept = whipped(under, 480)?;
    let change = kept.iter().map(|[momentum, _]| (momentum - 1.0).abs()).fold(0.0, f32::max);
    let gains = kept.windows(2).map(|pair| pair[1][1] / pair[0][1] - 1.0).fold(f32::NEG_INFINITY, f32::max);
    let percent = |share: f32| f64::from(100.0 * share);
    let scene = "free chain whips for 0.5 s at 960 Hz";
    let law = "angular momentum about the pin, change";
    Ok(vec![
        under.row(law, scene, percent(change), "%", Bound::AtMost(5.0)),
        under.row("energy gained in a step", scene, percent(gains), "%", Bound::AtMost(0.1)),
    ])
}

/// Half a period of a strand of 30 cm that is let go from 10 degrees, s: only gravity acts on it.
pub fn half_period(under: &Under<'_>) -> Result<f32, BenchError> {
    let guides = hanging(30.0, 32);
    let settings = SimulationSettings { damping: 0.0, drag: 0.0, bend_length: 1.0, shape: 0.0, ..bare(under) };
    let settings = SimulationSettings { damping_along: 0.0, ..settings };
    let mut subject = Subject::new(under, &guides, None, &settings)?;
    let pin = guides.positions[1];
    let aside: Vec<Vec3> = guides.positions.iter().map(|&p| pin + Quat::from_rotation_z(0.17) * (p - pin)).collect();
    subject.set_state(&aside, &aside);
    let (mut crossings, mut before) = (Vec::new(), 1.0);
    for frame in 1..=480 {
        subject.advance(1.0 / 120.0)?;
        let x = subject.positions()?.last().map_or(f32::NAN, |tip| tip.x);
        if (x > 0.0) != (before > 0.0) {
            // Compute when it passed the middle, between two frames.
            crossings.push((frame as f32 - x / (x - before)) / 120.0);
        }
        before = x;
    }
    let [first, .., last] = crossings.as_slice() else { return Ok(f32::NAN) };
    Ok((last - first) / (crossings.len() - 1) as f32)
}

/// A hanging chain swings at 1.2024 sqrt(g / l) (first zero of the Bessel function J0, halved).
pub fn swing(under: &Under<'_>) -> Rows {
    let exact = std::f32::consts::PI / (1.2024 * (981.0_f32 / 30.0).sqrt());
    let error = f64::from(100.0 * (half_period(under)? / exact - 1.0).abs());
    let scene = "hair of 30 cm let go from 10 degrees, against the hanging chain";
    Ok(vec![under.row("period of a swing, error", scene, error, "%", Bound::AtMost(5.0))])
}
