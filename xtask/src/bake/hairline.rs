//! Where hair ends: the curve from the forehead over the temples and around the ears to the nape.
//!
//! A hairline is one height per azimuth about the axis of the skull, a spline through anatomical
//! landmarks. A painted mask was rejected: it would have to be painted again when the head changes.

use glam::{Vec3, vec3};

use super::mannequin::Mannequin;

/// Azimuths are taken around the vertical through here.
const AXIS: Vec3 = vec3(0.0, 0.0, -1.0);

/// Azimuth (degrees, 0 front, 180 back) and height of the hairline (cm).
const LANDMARKS: &[[f32; 2]] = &[
    [0.0, 7.75], // Middle of the forehead: 6.5 cm over the brows along the skin.
    [12.0, 7.8],
    [24.0, 7.7],
    [33.0, 7.35], // The temple recedes a little.
    [42.0, 6.2],
    [50.0, 4.6],
    [57.0, 3.1],
    [63.0, 1.9],
    [69.0, 0.6],
    [74.0, -1.0], // Sideburn.
    [78.0, -1.6],
    [82.0, -0.6],
    [88.0, 2.4],
    [96.0, 3.1], // Over the ear.
    [104.0, 2.6],
    [112.0, 0.2],
    [120.0, -2.8], // Behind the ear.
    [130.0, -5.1],
    [145.0, -6.5],
    [160.0, -7.3],
    [172.0, -7.8], // Nape.
    [180.0, -7.9],
];

/// Clearance kept around the ears.
const EAR_CLEARANCE: f32 = 0.45;

/// Positive on the scalp, negative on bare skin; zero on the hairline. About centimetres.
pub fn scalp(mannequin: &Mannequin, p: Vec3) -> f32 {
    let azimuth_deg = p.x.abs().atan2(p.z - AXIS.z).to_degrees();
    (p.y - height(azimuth_deg)).min(mannequin.ear_distance(p) - EAR_CLEARANCE)
}

/// Height of the hairline, by a Catmull-Rom spline over uneven azimuths.
pub fn height(azimuth_deg: f32) -> f32 {
    let last = LANDMARKS.len() - 1;
    let i = (1..last).find(|&i| azimuth_deg < LANDMARKS[i][0]).unwrap_or(last);
    let at = |i: isize| LANDMARKS[i.clamp(0, last as isize) as usize];
    let [a, b, c, d] = [at(i as isize - 2), at(i as isize - 1), at(i as isize), at(i as isize + 1)];
    let t = ((azimuth_deg - b[0]) / (c[0] - b[0])).clamp(0.0, 1.0);
    let span = c[0] - b[0];
    let slope = |lo: [f32; 2], hi: [f32; 2]| if hi[0] > lo[0] { (hi[1] - lo[1]) / (hi[0] - lo[0]) * span } else { 0.0 };
    let (m0, m1) = (if i == 1 { 0.0 } else { slope(a, c) }, if i == last { 0.0 } else { slope(b, d) });
    let (t2, t3) = (t * t, t * t * t);
    b[1] * (2.0 * t3 - 3.0 * t2 + 1.0) + m0 * (t3 - 2.0 * t2 + t) + c[1] * (3.0 * t2 - 2.0 * t3) + m1 * (t3 - t2)
}
