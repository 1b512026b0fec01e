//! Small heads of hair made by formulas: draped over a ball, straight or curled.

use glam::{UVec3, Vec3};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;

pub const RADIUS: f32 = 9.0;

/// The exact distance to a ball of [`RADIUS`] about the origin.
pub fn ball_field() -> DistanceField {
    let (n, cell, min) = (40_u32, 0.7, Vec3::splat(-13.65));
    let node = |i: u32| min + cell * UVec3::new(i % n, i / n % n, i / (n * n)).as_vec3();
    let values = (0..n * n * n).map(|i| node(i).length() - RADIUS).collect();
    DistanceField { min, cell, n: [n; 3], values }
}

/// `n_guides` strands that leave the upper half of the ball, drape over it and hang, `length` centimetres long.
pub fn draped(n_guides: usize, n_vertices: u32, length: f32, curl: f32) -> GuideSet {
    let h = length / (n_vertices - 1) as f32;
    let mut positions = Vec::new();
    for guide_idx in 0..n_guides {
        // A golden spiral over the upper half.
        let y = 0.98 - 0.9 * (guide_idx as f32 + 0.5) / n_guides as f32;
        let azimuth = 2.399963 * guide_idx as f32;
        let normal = Vec3::new(azimuth.sin() * (1.0 - y * y).sqrt(), y, azimuth.cos() * (1.0 - y * y).sqrt());
        let mut p = RADIUS * normal;
        let mut direction = (normal + 0.8 * Vec3::new(normal.x, 0.0, normal.z)).normalize();
        let mut path = vec![p];
        for _ in 1..n_vertices {
            direction = (direction + 0.35 * h * Vec3::NEG_Y).normalize();
            p += h * direction;
            if p.length() < RADIUS + 0.3 {
                let moved = p.normalize() * (RADIUS + 0.3);
                direction = (moved - path.last().unwrap()).normalize();
                p = path.last().unwrap() + h * direction;
            }
            path.push(p);
        }
        for (k, p) in path.iter().enumerate() {
            let s = k as f32 * h;
            let turn = std::f32::consts::TAU * s / 2.5 + azimuth;
            let ramp = curl * (s / 3.0).min(1.0);
            positions.push(*p + ramp * Vec3::new(turn.cos(), 0.0, turn.sin()));
        }
    }
    GuideSet { n_vertices, positions }
}
