//! Which unit, which up and which front a file has, from the hair and the head in it.
//!
//! No strand format says. Evidence is weighed instead of taking the first rule that fits, because every
//! single rule fails on some groom: slicked-back hair does not fall, short hair hides its length, a head
//! at the origin does not stand.

use glam::{DMat4, DVec4, Vec3};

use super::detect::Format;
use super::space::{Axis, Space, Unit};
use crate::mesh::TriMesh;
use crate::strands::{Strands, polyline_length};

/// A guessed space.
pub struct Guess {
    pub space: Space,
    /// How it was found, for people.
    pub reason: String,
    /// What is odd about it.
    pub warning: Option<String>,
}

/// Strands looked at.
const N_SAMPLES: usize = 4096;

impl Space {
    /// Guess the space of strands, of a head, or of both where they share one.
    pub fn guess(strands: Option<&Strands>, mesh: Option<&TriMesh>, format: Option<Format>) -> Guess {
        let hair = strands.map(Hair::measure);
        let (up, up_reason) = guess_up(hair.as_ref(), mesh, format);
        let front = guess_front(up, hair.as_ref(), mesh);
        let (unit, size_reason, cost) = guess_unit(hair.as_ref(), mesh, format);
        let space = Space { unit, up, front };
        let warning = (cost > 1.0).then(|| {
            format!(
                "the size fits no unit well ({size_reason}): check the unit, {} was taken",
                unit.label().to_lowercase()
            )
        });
        let reason = format!("{}: {size_reason}; {up_reason}", space.describe());
        Guess { space, reason, warning }
    }
}

/// What a groom's shape says.
struct Hair {
    /// Sum of all root-to-tip vectors over the sum of their lengths: how hair falls, at most 1 long.
    fall: Vec3,
    /// Mean direction from the centre of a sphere through the roots to the roots: the scalp is a cap.
    cap: Vec3,
    min: Vec3,
    max: Vec3,
    root_min: Vec3,
    root_max: Vec3,
    median_length: f32,
}

impl Hair {
    fn measure(strands: &Strands) -> Self {
        let n_strands = strands.n_strands();
        let step = n_strands.div_ceil(N_SAMPLES).max(1);
        let mut roots = Vec::new();
        let mut lengths = Vec::new();
        let (mut sum, mut sum_of_lengths) = (Vec3::ZERO, 0.0);
        for strand_idx in (0..n_strands).step_by(step) {
            let points = strands.strand(strand_idx);
            let (Some(&root), Some(&tip)) = (points.first(), points.last()) else { continue };
            roots.push(root);
            lengths.push(polyline_length(points));
            sum += tip - root;
            sum_of_lengths += (tip - root).length();
        }
        lengths.sort_by(f32::total_cmp);
        let (min, max) = strands.bounds().unwrap_or_default();
        let start = roots.first().copied().unwrap_or_default();
        let (root_min, root_max) = roots.iter().fold((start, start), |(lo, hi), &p| (lo.min(p), hi.max(p)));
        let cap = sphere_centre(&roots).map_or(Vec3::ZERO, |centre| {
            roots.iter().map(|&root| (root - centre).normalize_or_zero()).sum::<Vec3>() / roots.len() as f32
        });
        Self {
            fall: if sum_of_lengths > 0.0 { sum / sum_of_lengths } else { Vec3::ZERO },
            cap,
            min,
            max,
            root_min,
            root_max,
            median_length: lengths.get(lengths.len() / 2).copied().unwrap_or(0.0),
        }
    }
}

/// Compute the centre of the sphere that fits points best: |p|^2 = 2 c.p + k is linear in c and k
/// (least squares). `None` for too few points or points in a plane.
fn sphere_centre(points: &[Vec3]) -> Option<Vec3> {
    if points.len() < 16 {
        return None;
    }
    // Around the mean and at unit size, so that squares keep their digits.
    let mean = points.iter().map(|p| p.as_dvec3()).sum::<glam::DVec3>() / points.len() as f64;
    let size = points.iter().map(|p| (p.as_dvec3() - mean).length()).fold(0.0, f64::max);
    if size <= 0.0 {
        return None;
    }
    let (mut normal, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for p in points {
        let p = (p.as_dvec3() - mean) / size;
        let row = (2.0 * p).extend(1.0);
        normal += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w);
        right += row * p.length_squared();
    }
    if normal.determinant().abs() < 1e-9 * (points.len() as f64).powi(4) {
        return None;
    }
    let solution = normal.inverse() * right;
    solution.is_finite().then(|| (mean + solution.truncate() * size).as_vec3())
}

fn guess_up(hair: Option<&Hair>, mesh: Option<&TriMesh>, format: Option<Format>) -> (Axis, String) {
    let bounds = hair.map(|hair| (hair.min, hair.max)).or_else(|| mesh.and_then(TriMesh::bounds)).unwrap_or_default();
    let largest = (bounds.1 - bounds.0).max_element().max(f32::MIN_POSITIVE);
    // A person that stands on the origin: the head is several heads away from it, upwards.
    let stand = (0.5 * (bounds.0 + bounds.1) / (3.0 * largest)).clamp(Vec3::NEG_ONE, Vec3::ONE);
    let (fall, cap) = hair.map_or((Vec3::ZERO, Vec3::ZERO), |hair| (hair.fall, hair.cap));
    let tall = mesh
        .and_then(TriMesh::bounds)
        .map_or(Vec3::ZERO, |(min, max)| (max - min) / (max - min).max_element().max(f32::MIN_POSITIVE));
    let score = |axis: Axis| {
        let d = axis.vector();
        // Weights are of one size because each piece of evidence is at most 1; custom decides near ties.
        let custom = match (axis, format) {
            (Axis::Y, Some(Format::Gltf)) => 10.0,
            (Axis::Z, Some(Format::Hair)) | (Axis::Y, _) => 0.35,
            (Axis::Z, _) => 0.25,
            (Axis::X, _) => 0.0,
            (Axis::NegX | Axis::NegY | Axis::NegZ, _) => -0.2,
        };
        custom - fall.dot(d) + 0.7 * cap.dot(d) + 0.8 * stand.dot(d) + 0.2 * tall.dot(d.abs())
    };
    let up = Axis::ALL.into_iter().max_by(|&a, &b| score(a).total_cmp(&score(b))).unwrap_or(Axis::Y);
    let d = up.vector();
    let mut reasons = Vec::new();
    if format == Some(Format::Gltf) {
        reasons.push("glTF prescribes Y up".to_owned());
    } else {
        if -fall.dot(d) > 0.2 {
            reasons.push("hair falls the other way".to_owned());
        }
        if cap.dot(d) > 0.2 {
            reasons.push("roots lie on that side of the scalp".to_owned());
        }
        if stand.dot(d) > 0.3 {
            reasons.push("the head is far from the origin that way".to_owned());
        }
        if reasons.is_empty() {
            reasons.push("up is by custom, the shape says little".to_owned());
        }
    }
    (up, reasons.join(", "))
}

/// The custom of the up axis; for up axes without a custom, the side with the nose.
fn guess_front(up: Axis, hair: Option<&Hair>, mesh: Option<&TriMesh>) -> Axis {
    if matches!(up, Axis::Y | Axis::Z) {
        return up.usual_front();
    }
    let sides = Axis::ALL.into_iter().filter(|axis| axis.vector().dot(up.vector()) == 0.0);
    let u = up.vector();
    if let Some(mesh) = mesh {
        // Only at the height of the hair, or the upper half: shoulders stick out further than noses.
        let heights = mesh.positions.iter().map(|p| p.dot(u));
        let (lo, hi) = heights.fold((f32::MAX, f32::MIN), |(lo, hi), h| (lo.min(h), hi.max(h)));
        let lo = match hair {
            Some(hair) => hair.root_min.dot(u).min(hair.root_max.dot(u)),
            None => 0.5 * (lo + hi),
        };
        let spread = |side: Axis| {
            let f = side.vector();
            let head = || mesh.positions.iter().filter(|p| p.dot(u) >= lo);
            let (back, front) = head().map(|p| p.dot(f)).fold((f32::MAX, f32::MIN), |(a, b), d| (a.min(d), b.max(d)));
            let nose: Vec<Vec3> = head().filter(|p| p.dot(f) > front - 0.04 * (front - back)).copied().collect();
            let mean = nose.iter().sum::<Vec3>() / nose.len().max(1) as f32;
            let variance = nose.iter().map(|p| (*p - mean).length_squared()).sum::<f32>() / nose.len().max(1) as f32;
            // A long face-to-back axis tells front and back from the sides.
            variance.sqrt() / (front - back).max(f32::MIN_POSITIVE)
        };
        return sides.min_by(|&a, &b| spread(a).total_cmp(&spread(b))).unwrap_or_else(|| up.usual_front());
    }
    // Roots lie behind the middle of the head: the face has none.
    let Some(hair) = hair else { return up.usual_front() };
    let score = |side: Axis| {
        let custom = if side == up.usual_front() { 0.2 } else { 0.0 };
        custom - hair.cap.dot(side.vector())
    };
    sides.max_by(|&a, &b| score(a).total_cmp(&score(b))).unwrap_or_else(|| up.usual_front())
}

/// Sizes in centimetres between which a measure is plausible, and its usual size.
struct Plausible {
    what: &'static str,
    size: f32,
    low: f32,
    usual: f32,
    high: f32,
}

fn guess_unit(hair: Option<&Hair>, mesh: Option<&TriMesh>, format: Option<Format>) -> (Unit, String, f32) {
    let mut measures = Vec::new();
    if let Some(hair) = hair {
        // A scalp is about 19 cm long and 15 cm wide; partial grooms cover less of it.
        let roots = (hair.root_max - hair.root_min).max_element();
        measures.push(Plausible { what: "roots spread over", size: roots, low: 5.0, usual: 17.0, high: 23.0 });
        let all = (hair.max - hair.min).max_element();
        measures.push(Plausible { what: "all hair measures", size: all, low: 12.0, usual: 30.0, high: 130.0 });
        let length = hair.median_length;
        measures.push(Plausible { what: "a strand is as long as", size: length, low: 0.8, usual: 15.0, high: 90.0 });
    }
    if let Some((min, max)) = mesh.and_then(TriMesh::bounds) {
        // From a head without neck to a standing person.
        let size = (max - min).max_element();
        measures.push(Plausible { what: "the head's mesh measures", size, low: 18.0, usual: 35.0, high: 210.0 });
    }
    measures.retain(|measure| measure.size > 0.0);
    let cost = |unit: Unit| {
        // Inches are rare in hair files.
        let rare = match (unit, format) {
            (Unit::Metre, Some(Format::Gltf)) => -2.0,
            (Unit::Inch, _) => 0.3,
            (Unit::Millimetre, _) => 0.1,
            (Unit::Metre | Unit::Centimetre, _) => 0.0,
        };
        measures.iter().fold(rare, |cost, m| {
            let cm = m.size * unit.in_cm();
            let outside = (m.low / cm).ln().max((cm / m.high).ln()).max(0.0);
            cost + outside.powi(2) + 0.1 * (cm / m.usual).ln().powi(2)
        })
    };
    let unit = Unit::ALL.into_iter().min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(Unit::Centimetre);
    let reason = measures.first().map_or_else(
        || "no size to judge by".to_owned(),
        |m| format!("{} {} cm then", m.what, round(m.size * unit.in_cm())),
    );
    let excess =
        cost(unit) - 0.1 * measures.iter().map(|m| (m.size * unit.in_cm() / m.usual).ln().powi(2)).sum::<f32>();
    (unit, reason, excess)
}

/// Three digits are enough for people.
fn round(value: f32) -> String {
    if value >= 100.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hair that falls from a cap of 9 cm radius around a centre, Y up, centimetres.
    fn bob(centre: Vec3) -> Strands {
        let mut strands = Strands::default();
        for strand_idx in 0..400 {
            let t = (strand_idx as f32 + 0.5) / 400.0;
            let azimuth = strand_idx as f32 * 2.399_963;
            let y = 1.0 - 0.9 * t;
            let r = (1.0 - y * y).sqrt();
            let n = Vec3::new(r * azimuth.cos(), y, r * azimuth.sin());
            let points: Vec<Vec3> =
                (0..8).map(|k| centre + 9.0 * n + n * 0.8 * k as f32 - Vec3::Y * 0.3 * (k * k) as f32).collect();
            strands.push(&points);
        }
        strands
    }

    #[test]
    fn unit_and_up_are_found_for_every_unit_and_axis() {
        for centre in [Vec3::ZERO, Vec3::new(0.0, 160.0, 0.0)] {
            for unit in [Unit::Millimetre, Unit::Centimetre, Unit::Metre] {
                for up in Axis::ALL {
                    let mut strands = bob(centre);
                    let space = Space::new(unit, up);
                    super::super::space::transform_points(space.file_from_world(), &mut strands.points);
                    let guess = Space::guess(Some(&strands), None, None);
                    assert_eq!((guess.space.unit, guess.space.up), (unit, up), "{} {centre}", guess.reason);
                    assert!(guess.warning.is_none(), "{:?}", guess.warning);
                }
            }
        }
    }

    #[test]
    fn a_groom_of_a_kilometre_is_called_odd() {
        let mut strands = bob(Vec3::ZERO);
        strands.points.iter_mut().for_each(|p| *p *= 1e5);
        assert!(Space::guess(Some(&strands), None, None).warning.is_some());
    }
}
