//! A groom that needs no file: hair falling from a ball, for tests and measurements.

use std::sync::Arc;

use glam::Vec3;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::mesh::TriMesh;
use lorelei_core::strands::Strands;

/// Radius of the head, centimetres.
const HEAD: f32 = 9.0;

/// `n_strands` strands of about 30 cm on a head of 9 cm radius, in waves, behind a parting.
pub fn sample_groom(n_strands: u32, vertices_per_strand: u32) -> Groom {
    let mut guides = Strands::default();
    let n_guides = 600;
    for guide_idx in 0..n_guides {
        // Spiral points (Vogel 1979) over the upper 60 % of the ball.
        let share = (guide_idx as f32 + 0.5) / n_guides as f32;
        let polar = (1.0 - 1.2 * share).acos();
        let around = guide_idx as f32 * 2.399_963;
        let normal = Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
        // The face is free.
        if normal.z > 0.55 && normal.y < 0.6 {
            continue;
        }
        let mut at = normal * (HEAD + 0.05);
        let sideways = Vec3::new(normal.x.signum(), 0.0, -0.4);
        let mut points = vec![at];
        for k in 1..24 {
            let fall = (k as f32 / 8.0).min(1.0);
            let wave = 0.25 * (0.9 * k as f32 + 3.0 * (guide_idx % 7) as f32).sin();
            let step = (normal * (1.0 - fall) + sideways * 0.6 * (1.0 - fall) + Vec3::NEG_Y * fall * 1.2).normalize();
            at += 1.25 * step + normal.cross(Vec3::Y) * wave;
            let out = at.length();
            let clear = HEAD + 0.3 + 0.08 * k as f32;
            if out < clear {
                at *= clear / out;
            }
            points.push(at);
        }
        guides.push(&points);
    }
    let hair = Layer { n_strands, vertices_per_strand, ..Layer::new("hair", Source::Guides(Arc::new(guides))) };
    Groom { name: "sample".to_owned(), head: Some(ball()), layers: vec![hair], ..Groom::default() }
}

fn ball() -> Head {
    let n = 64_u32;
    let mut mesh = TriMesh::default();
    for i in 0..=n {
        for j in 0..n {
            let (polar, around) =
                (i as f32 / n as f32 * std::f32::consts::PI, j as f32 / n as f32 * std::f32::consts::TAU);
            mesh.positions.push(HEAD * Vec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos()));
            if i < n {
                let (a, b) = (i * n + j, i * n + (j + 1) % n);
                mesh.triangles.extend([[a, a + n, b], [b, a + n, b + n]]);
            }
        }
    }
    mesh.compute_normals();
    Head::new("ball", mesh)
}
