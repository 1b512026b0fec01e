//! Small heads of hair made by formulas, and how they are shaken.

use std::f32::consts::TAU;

use glam::{Affine3A, UVec3, Vec3};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::HeadPose;

/// Of the ball that is the head, cm; its middle is the origin.
pub const RADIUS: f32 = 9.0;
/// What that head turns about.
pub const PIVOT: Vec3 = Vec3::new(0.0, -8.0, -1.0);

/// Long hair, curls, tight curls and short hair on the ball.
pub fn grooms() -> [(&'static str, GuideSet); 4] {
    [
        ("long", draped(16, 32, 35.0, 0.0)),
        ("curly", draped(16, 32, 25.0, 0.5)),
        ("coils", draped(16, 32, 15.0, 0.5)),
        ("short", draped(16, 12, 6.0, 0.0)),
    ]
}

/// Twice as wide and nearly twice as fast as the preset: nobody shakes a head like that.
pub fn violent_shake(t: f32) -> Affine3A {
    let swell = (t / 0.3).min(1.0);
    HeadPose { yaw: 0.6 * swell * (TAU * 2.5 * t).sin(), ..HeadPose::default() }.world_from_head(PIVOT)
}

/// A strand from the origin along +X, its clamped edge behind.
pub fn cantilever(length: f32, n_vertices: u32) -> GuideSet {
    let h = length / (n_vertices - 2) as f32;
    GuideSet { n_vertices, positions: (0..n_vertices).map(|k| Vec3::X * (h * (k as f32 - 1.0))).collect() }
}

/// A strand that hangs straight from the origin.
pub fn hanging(length: f32, n_vertices: u32) -> GuideSet {
    let h = length / (n_vertices - 2) as f32;
    GuideSet { n_vertices, positions: (0..n_vertices).map(|k| Vec3::NEG_Y * (h * (k as f32 - 1.0))).collect() }
}

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
                direction = (moved - path[path.len() - 1]).normalize();
                p = path[path.len() - 1] + h * direction;
            }
            path.push(p);
        }
        for (k, p) in path.iter().enumerate() {
            let s = k as f32 * h;
            let turn = TAU * s / 2.5 + azimuth;
            let ramp = curl * (s / 3.0).min(1.0);
            positions.push(*p + ramp * Vec3::new(turn.cos(), 0.0, turn.sin()));
        }
    }
    GuideSet { n_vertices, positions }
}
