//! A groom that draws quickly: a ball with a tuft.

use std::sync::Arc;

use glam::Vec3;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::mesh::TriMesh;
use lorelei_core::strands::Strands;

/// A ball with a tuft of 400 strands that stand out and hang over.
pub fn small_groom() -> Groom {
    let mut strands = Strands::default();
    for i in 0..400 {
        // Fibonacci directions over the upper half.
        let t = i as f32 / 400.0;
        let (height, turn) = (1.0 - 0.75 * t, i as f32 * 2.399_963);
        let ring = (1.0 - height * height).sqrt();
        let out = Vec3::new(ring * turn.cos(), height, ring * turn.sin());
        let points: Vec<Vec3> = (0..10).map(|k| (9.0 + k as f32) * out - 0.12 * (k * k) as f32 * Vec3::Y).collect();
        strands.push(&points);
    }
    let mut layer = Layer::from_strands("tuft", strands);
    layer.radius_um = 300.0;
    let guides = Layer { source: Source::Guides(strands_of(&layer)), n_strands: 2000, ..layer };
    Groom {
        name: "small".to_owned(),
        head: Some(Head::new("ball", ball(9.0))),
        layers: vec![guides],
        ..Groom::default()
    }
}

fn strands_of(layer: &Layer) -> Arc<Strands> {
    match &layer.source {
        Source::Strands(strands) | Source::Guides(strands) => Arc::clone(strands),
        Source::HairMesh(_) => unreachable!("made of strands above"),
    }
}

fn ball(radius: f32) -> TriMesh {
    let (n_around, n_up) = (32_u32, 16_u32);
    let mut mesh = TriMesh::default();
    for j in 0..=n_up {
        for i in 0..n_around {
            let (phi, theta) =
                (i as f32 / n_around as f32 * std::f32::consts::TAU, j as f32 / n_up as f32 * std::f32::consts::PI);
            mesh.positions.push(radius * Vec3::new(theta.sin() * phi.sin(), theta.cos(), theta.sin() * phi.cos()));
        }
    }
    for j in 0..n_up {
        for i in 0..n_around {
            let at = |i: u32, j: u32| j * n_around + i % n_around;
            mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh.compute_normals();
    mesh
}
