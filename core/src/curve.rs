//! The curve through a strand's control points: uniform Catmull-Rom, C1, with the end points mirrored so
//! that a straight chain stays straight (Yuksel, Schaefer and Keyser 2009, section 3.1).
//!
//! The curve is linear in its control points: blending chains and then drawing the curve is the same as
//! blending the curves. That is why guides can be resampled once, before strands are interpolated.

use glam::Vec3;

/// Weights of four control points at `x` (0-1) between the second and the third. Twin in generate.wgsl.
pub fn catmull_rom_weights(x: f32) -> [f32; 4] {
    let (x2, x3) = (x * x, x * x * x);
    [0.5 * (-x + 2.0 * x2 - x3), 0.5 * (2.0 - 5.0 * x2 + 3.0 * x3), 0.5 * (x + 4.0 * x2 - 3.0 * x3), 0.5 * (x3 - x2)]
}

/// How these weights change with `x`: the curve's direction from its control points.
pub fn catmull_rom_slopes(x: f32) -> [f32; 4] {
    let x2 = x * x;
    [
        0.5 * (-1.0 + 4.0 * x - 3.0 * x2),
        0.5 * (-10.0 * x + 9.0 * x2),
        0.5 * (1.0 + 8.0 * x - 9.0 * x2),
        0.5 * (3.0 * x2 - 2.0 * x),
    ]
}

/// The curve through `points` at `u`, from 0 at the first to `points.len() - 1` at the last; clamped.
pub fn catmull_rom(points: &[Vec3], u: f32) -> Vec3 {
    let Some(last) = points.len().checked_sub(1) else { return Vec3::ZERO };
    if last == 0 {
        return points[0];
    }
    let u = u.clamp(0.0, last as f32);
    let segment = (u as usize).min(last - 1);
    let w = catmull_rom_weights(u - segment as f32);
    let before = if segment == 0 { 2.0 * points[0] - points[1] } else { points[segment - 1] };
    let after = if segment + 2 > last { 2.0 * points[last] - points[last - 1] } else { points[segment + 2] };
    w[0] * before + w[1] * points[segment] + w[2] * points[segment + 1] + w[3] * after
}

/// Parameters of `n` samples of the curve through `points`, evenly spaced by arc length. The first and
/// the last are the ends. `n` is at least 2.
pub fn even_parameters(points: &[Vec3], n: usize) -> Vec<f32> {
    /// Chords a control segment is measured with.
    const CHORDS: usize = 8;
    let last = points.len().saturating_sub(1);
    let mut length_at = vec![0.0_f64];
    let mut before = points.first().copied().unwrap_or_default();
    for step in 1..=last * CHORDS {
        let here = catmull_rom(points, step as f32 / CHORDS as f32);
        length_at.push(length_at[step - 1] + f64::from(here.distance(before)));
        before = here;
    }
    let total = length_at[length_at.len() - 1];
    let mut step = 0;
    let even = (0..n).map(|k| {
        let wanted = total * k as f64 / (n - 1) as f64;
        while step + 2 < length_at.len() && length_at[step + 1] < wanted {
            step += 1;
        }
        if total <= 0.0 || k + 1 == n {
            return last as f32 * k as f32 / (n - 1) as f32;
        }
        let chord = (length_at[step + 1] - length_at[step]).max(1e-12);
        (step as f32 + ((wanted - length_at[step]) / chord).clamp(0.0, 1.0) as f32) / CHORDS as f32
    });
    even.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curve_passes_its_control_points_and_keeps_straight_chains_straight() {
        let bent = [Vec3::ZERO, Vec3::new(1.0, 2.0, 0.0), Vec3::new(3.0, 2.5, 1.0), Vec3::new(4.0, 0.0, 2.0)];
        for (i, p) in bent.iter().enumerate() {
            assert!(catmull_rom(&bent, i as f32).distance(*p) < 1e-6);
        }
        let straight: Vec<Vec3> = (0..5).map(|i| Vec3::new(0.0, -2.0 * i as f32, 0.0)).collect();
        for k in 0..=40 {
            let u = k as f32 * 0.1;
            assert!(catmull_rom(&straight, u).distance(Vec3::new(0.0, -2.0 * u, 0.0)) < 1e-5);
        }
    }

    #[test]
    fn even_parameters_space_samples_evenly() {
        let points =
            [Vec3::ZERO, Vec3::X, Vec3::new(5.0, 1.0, 0.0), Vec3::new(5.5, 4.0, 0.0), Vec3::new(9.0, 4.0, 3.0)];
        let samples: Vec<Vec3> = even_parameters(&points, 65).iter().map(|&u| catmull_rom(&points, u)).collect();
        assert!(samples[0].distance(points[0]) < 1e-6 && samples[64].distance(points[4]) < 1e-6);
        let steps: Vec<f32> = samples.windows(2).map(|s| s[0].distance(s[1])).collect();
        let mean = steps.iter().sum::<f32>() / 64.0;
        assert!(steps.iter().all(|step| (step / mean - 1.0).abs() < 0.08), "{steps:?}");
    }
}
