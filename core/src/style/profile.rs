//! How strong an operator is from root to tip, drawn by hand: two to eight points and a smooth line through
//! them.
//!
//! The line is Steffen's monotone cubic: it passes its points and never swings beyond them, so a curve drawn
//! between 0 and 1 stays there. Splines that overshoot were rejected: a clump that pulls with -0.1 turns
//! inside out. Both generators read the line from one table of [`N_TABLE`] samples, so that they agree to the
//! bit whatever a driver's arithmetic is; between samples they interpolate linearly.

use serde::{Deserialize, Serialize};

/// Points of a profile at most; at least two.
pub const MOST_POINTS: usize = 8;
/// Samples of a profile's table: the first at 0, the last at 1.
pub const N_TABLE: usize = 33;
/// Points stay this far from each other along the strand.
pub const LEAST_GAP: f32 = 0.01;

/// A profile with a name.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// What `--set` takes.
    pub name: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    /// Empty: no curve, the ramp counts.
    pub points: &'static [[f32; 2]],
}

const fn shape(name: &'static str, label: &'static str, help: &'static str, points: &'static [[f32; 2]]) -> Shape {
    Shape { name, label, help, points }
}

/// Profiles to begin with.
pub const SHAPES: &[Shape] = &[
    shape("none", "Ramp", "No curve: as the number \u{201c}Ramp\u{201d} says", &[]),
    shape("even", "Even", "The same from root to tip", &[[0.0, 1.0], [1.0, 1.0]]),
    shape("rising", "Rising", "From nothing at the root to all at the tip", &[[0.0, 0.0], [1.0, 1.0]]),
    shape("falling", "Falling", "From all at the root to nothing at the tip", &[[0.0, 1.0], [1.0, 0.0]]),
    shape("middle", "Middle", "Nothing at root and tip", &[[0.0, 0.0], [0.5, 1.0], [1.0, 0.0]]),
    shape("ends", "Root and tip", "Nothing in the middle", &[[0.0, 1.0], [0.5, 0.0], [1.0, 1.0]]),
    shape("tip", "Tip", "Only the last third", &[[0.0, 0.0], [0.6, 0.0], [1.0, 1.0]]),
    shape("late", "Late", "From the middle on in full", &[[0.0, 0.0], [0.35, 0.0], [0.55, 1.0], [1.0, 1.0]]),
    shape("root", "Root", "Away at the root, then on beside the others", ROOT),
    shape("pointed", "Pointed", "Widest in the middle, and ending in a point", POINTED),
];

pub(super) const ROOT: &[[f32; 2]] = &[[0.0, 1.0], [0.12, 0.8], [0.5, 0.0], [1.0, 0.0]];
pub(super) const POINTED: &[[f32; 2]] = &[[0.0, 0.6], [0.45, 1.0], [1.0, 0.15]];

/// A drawn profile; empty where none was drawn.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "Vec<[f32; 2]>", into = "Vec<[f32; 2]>")]
pub struct Profile {
    /// (place along the strand, strength), both 0-1, in ascending order of place.
    points: Vec<[f32; 2]>,
}

impl From<Vec<[f32; 2]>> for Profile {
    /// Take the points in their order along the strand, within 0-1, as many as there is room for. Fewer than two
    /// that are at a place are no profile.
    fn from(mut points: Vec<[f32; 2]>) -> Self {
        points.retain(|[x, y]| x.is_finite() && y.is_finite());
        points.truncate(MOST_POINTS);
        for point in &mut points {
            *point = point.map(|v| v.clamp(0.0, 1.0));
        }
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        points.dedup_by(|b, a| b[0] - a[0] < 0.5 * LEAST_GAP);
        if points.len() < 2 {
            points.clear();
        }
        Self { points }
    }
}

impl From<Profile> for Vec<[f32; 2]> {
    fn from(profile: Profile) -> Self {
        profile.points
    }
}

impl Profile {
    /// The points of a profile written in code.
    pub fn of(points: &[[f32; 2]]) -> Self {
        points.to_vec().into()
    }

    /// Points that follow x^ramp.
    pub fn of_ramp(ramp: f32) -> Self {
        let xs: &[f32] = if ramp <= 0.0 || ramp == 1.0 { &[0.0, 1.0] } else { &[0.0, 0.25, 0.5, 0.75, 1.0] };
        let y = |x: f32| if ramp <= 0.0 { 1.0 } else { x.powf(ramp) };
        xs.iter().map(|&x| [x, y(x)]).collect::<Vec<_>>().into()
    }

    /// Its name, where it is one of [`SHAPES`].
    pub fn shape(&self) -> Option<&'static Shape> {
        SHAPES.iter().find(|shape| shape.points == self.points)
    }

    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    pub fn points(&self) -> &[[f32; 2]] {
        &self.points
    }

    /// Move a point as far as its neighbours let it.
    pub fn move_point(&mut self, point_idx: usize, [x, y]: [f32; 2]) {
        let low = point_idx.checked_sub(1).map_or(0.0, |before| self.points[before][0] + LEAST_GAP);
        let high = self.points.get(point_idx + 1).map_or(1.0, |after| after[0] - LEAST_GAP);
        self.points[point_idx] = [x.clamp(low.min(high), high.max(low)), y.clamp(0.0, 1.0)];
    }

    /// Add a point; `None` where there is no room for it, else its index.
    pub fn insert(&mut self, [x, y]: [f32; 2]) -> Option<usize> {
        let is_near = self.points.iter().any(|point| (point[0] - x).abs() < LEAST_GAP);
        if self.points.len() >= MOST_POINTS || is_near {
            return None;
        }
        let at = self.points.partition_point(|point| point[0] < x);
        self.points.insert(at, [x.clamp(0.0, 1.0), y.clamp(0.0, 1.0)]);
        Some(at)
    }

    /// Take a point away; the last two stay.
    pub fn remove(&mut self, point_idx: usize) -> bool {
        let can = self.points.len() > 2;
        if can {
            self.points.remove(point_idx);
        }
        can
    }

    /// Strength at `x`, 0 where the operator begins and 1 at the tip. Steffen 1990, "A simple method for monotonic
    /// interpolation in one dimension"; beyond the outer points it stays as it is there. 1 for an empty profile.
    pub fn at(&self, x: f32) -> f32 {
        let points = &self.points;
        let Some(last) = points.len().checked_sub(1) else { return 1.0 };
        if x <= points[0][0] {
            return points[0][1];
        }
        if x >= points[last][0] {
            return points[last][1];
        }
        let i = points.partition_point(|point| point[0] <= x) - 1;
        let [x0, y0] = points[i];
        let h = points[i + 1][0] - x0;
        let s = (points[i + 1][1] - y0) / h;
        let (m0, m1) = (self.slope(i), self.slope(i + 1));
        let d = x - x0;
        ((m0 + m1 - 2.0 * s) / (h * h) * d * d * d + (3.0 * s - 2.0 * m0 - m1) / h * d * d + m0 * d + y0)
            .clamp(0.0, 1.0)
    }

    /// Slope at a point: Steffen 1990, eq. 11.
    fn slope(&self, i: usize) -> f32 {
        let points = &self.points;
        if i == 0 || i + 1 == points.len() {
            // The secant of the only gap beside it: a straight line stays straight.
            let [a, b] = if i == 0 { [points[0], points[1]] } else { [points[i - 1], points[i]] };
            return (b[1] - a[1]) / (b[0] - a[0]);
        }
        let (h0, h1) = (points[i][0] - points[i - 1][0], points[i + 1][0] - points[i][0]);
        let (s0, s1) = ((points[i][1] - points[i - 1][1]) / h0, (points[i + 1][1] - points[i][1]) / h1);
        let p = (s0 * h1 + s1 * h0) / (h0 + h1);
        let sign = |s: f32| if s == 0.0 { 0.0 } else { s.signum() };
        (sign(s0) + sign(s1)) * s0.abs().min(s1.abs()).min(0.5 * p.abs())
    }

    /// The profile at even places; `None` where none was drawn.
    pub fn table(&self) -> Option<[f32; N_TABLE]> {
        (!self.is_empty()).then(|| std::array::from_fn(|k| self.at(k as f32 / (N_TABLE - 1) as f32)))
    }
}

/// A table between its samples at `x`, 0-1. Twin of `table_at` in generate.wgsl.
pub fn table_at(table: &[f32; N_TABLE], x: f32) -> f32 {
    let at = x.clamp(0.0, 1.0) * (N_TABLE - 1) as f32;
    let sample = (at as usize).min(N_TABLE - 2);
    table[sample] + (at - sample as f32) * (table[sample + 1] - table[sample])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_profile_passes_its_points_and_a_straight_one_is_straight() {
        let points = [[0.0, 0.2], [0.3, 0.9], [0.5, 0.9], [1.0, 0.1]];
        let profile = Profile::of(&points);
        for [x, y] in points {
            assert!((profile.at(x) - y).abs() < 1e-6);
        }
        let line = Profile::of(&[[0.0, 0.0], [0.4, 0.4], [1.0, 1.0]]);
        let table = line.table().unwrap();
        for k in 0..=50 {
            let x = k as f32 / 50.0;
            assert!((line.at(x) - x).abs() < 1e-5 && (table_at(&table, x) - x).abs() < 1e-5);
        }
        assert_eq!(Profile::default().table(), None);
        assert!((Profile::of_ramp(2.0).at(0.5) - 0.25).abs() < 1e-6 && Profile::of_ramp(0.0).at(0.0) == 1.0);
    }

    #[test]
    fn points_keep_their_order_and_their_number() {
        let mut profile = Profile::of(&[[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]);
        profile.move_point(1, [-3.0, 7.0]);
        assert_eq!(profile.points()[1], [LEAST_GAP, 1.0]);
        assert_eq!(profile.insert([0.7, 0.2]), Some(2));
        assert_eq!(profile.insert([0.7, 0.3]), None);
        while profile.remove(0) {}
        assert_eq!(profile.points().len(), 2);
        let mut many: Profile = (0..20).map(|k| [k as f32 / 20.0, 0.5]).collect::<Vec<_>>().into();
        assert_eq!(many.points().len(), MOST_POINTS);
        assert_eq!(many.insert([0.99, 0.5]), None);
        assert!(Profile::from(vec![[f32::NAN, 0.0], [0.2, 1.0]]).is_empty());
    }

    proptest! {
        #[test]
        fn a_profile_never_leaves_the_range_between_two_points(
            points in proptest::collection::vec([0.0..1.0_f32, 0.0..1.0_f32], 2..9), x in 0.0..1.0_f32,
        ) {
            let profile = Profile::from(points);
            let y = profile.at(x);
            for pair in profile.points().windows(2) {
                if (pair[0][0]..=pair[1][0]).contains(&x) {
                    let (low, high) = (pair[0][1].min(pair[1][1]), pair[0][1].max(pair[1][1]));
                    prop_assert!((low - 1e-4..=high + 1e-4).contains(&y), "{y} not in {low}..{high}");
                }
            }
        }
    }
}
