//! The few signed distances the mannequin is sculpted from, and the blends that join them.
//!
//! Distances are in centimetres, negative inside. Blends are the quadratic polynomial kind: they touch
//! only what lies within `k` of both shapes, so that a feature can be tuned without moving its neighbours.

use glam::{Mat3, Vec3};

/// Ellipsoid with half axes `r`. A first-order estimate of the distance, exact on the surface.
pub fn ellipsoid(p: Vec3, centre: Vec3, r: Vec3) -> f32 {
    let q = p - centre;
    let k0 = (q / r).length();
    let k1 = (q / (r * r)).length();
    if k1 < 1e-6 { -r.min_element() } else { k0 * (k0 - 1.0) / k1 }
}

/// Ellipsoid whose axes are the columns of `frame`.
pub fn turned_ellipsoid(p: Vec3, centre: Vec3, frame: &Mat3, r: Vec3) -> f32 {
    ellipsoid(frame.transpose() * (p - centre), Vec3::ZERO, r)
}

/// Round cone: the hull of a sphere of radius `ra` at `a` and one of radius `rb` at `b`.
pub fn cone(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    // In the plane of p and the axis the flank is a line with slope (ra - rb) / length.
    let axis = b - a;
    let length = axis.length();
    let y = (p - a).dot(axis) / length;
    let x = (p - a - axis * (y / length)).length();
    let sin = ((ra - rb) / length).clamp(-0.999, 0.999);
    let cos = (1.0 - sin * sin).sqrt();
    let foot = y * cos - x * sin; // Along the flank, from the tangent point on the first sphere.
    if foot <= 0.0 {
        x.hypot(y) - ra
    } else if foot >= length * cos {
        x.hypot(y - length) - rb
    } else {
        x * cos + y * sin - ra
    }
}

/// Polyline with a radius at each point.
pub fn tube(p: Vec3, points: &[(Vec3, f32)]) -> f32 {
    points.windows(2).fold(f32::MAX, |d, w| d.min(cone(p, w[0].0, w[1].0, w[0].1, w[1].1)))
}

/// A Catmull-Rom curve through `knots` (position, radius), `n_between` pieces to a span.
pub fn curve(knots: &[(Vec3, f32)], n_between: usize) -> Vec<(Vec3, f32)> {
    let at = |i: isize| knots[i.clamp(0, knots.len() as isize - 1) as usize];
    let mut points = Vec::with_capacity(knots.len() * n_between);
    for span in 0..knots.len() as isize - 1 {
        let [a, b, c, d] = [at(span - 1), at(span), at(span + 1), at(span + 2)];
        for piece in 0..n_between {
            let t = piece as f32 / n_between as f32;
            let p = 0.5
                * (2.0 * b.0
                    + (c.0 - a.0) * t
                    + (2.0 * a.0 - 5.0 * b.0 + 4.0 * c.0 - d.0) * (t * t)
                    + (3.0 * b.0 - a.0 - 3.0 * c.0 + d.0) * (t * t * t));
            points.push((p, b.1 + (c.1 - b.1) * t));
        }
    }
    points.push(at(knots.len() as isize - 1));
    points
}

/// Union, rounded where the two are closer than `k`.
pub fn join(a: f32, b: f32, k: f32) -> f32 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// Intersection, rounded over `k`.
pub fn meet(a: f32, b: f32, k: f32) -> f32 {
    -join(-a, -b, k)
}

/// `a` without `b`, the rim rounded over `k`.
pub fn carve(a: f32, b: f32, k: f32) -> f32 {
    meet(a, -b, k)
}

/// 0 below `lo`, 1 above `hi`, smooth between.
pub fn smoothstep(lo: f32, hi: f32, x: f32) -> f32 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
