//! The groom of the golden images: hair on a ball, made by code that nothing else uses, so that a nicer default
//! groom changes no golden image.

use std::sync::Arc;

use glam::Vec3;
use lorelei_core::groom::{Groom, Head, Layer, Source};
use lorelei_core::light::Light;
use lorelei_core::mesh::TriMesh;
use lorelei_core::strands::Strands;
use lorelei_core::style::{StyleKind, StyleOp};

/// Of the ball, centimetres.
const RADIUS: f32 = 9.0;
const N_GUIDES: u32 = 240;
/// Few and thick: a frame is cheap, and strands are still narrower than a pixel.
const N_STRANDS: u32 = 2_500;
const STRAND_RADIUS_UM: f32 = 250.0;

/// Auburn hair of 12 cm that falls from the upper half of a ball, in clumps and waves; three lamps.
pub fn groom() -> Groom {
    let mut guides = Strands::default();
    for guide_idx in 0..N_GUIDES {
        // Spiral points (Vogel 1979) over the upper half.
        let height = 1.0 - (guide_idx as f32 + 0.5) / N_GUIDES as f32;
        let (sin, cos) = (guide_idx as f32 * 2.399_963).sin_cos();
        let ring = (1.0 - height * height).sqrt();
        let normal = Vec3::new(ring * sin, height, ring * cos);
        let points: Vec<Vec3> = (0..8)
            .map(|k| {
                let along = 12.0 * k as f32 / 7.0;
                let p = normal * (RADIUS + 0.6 * along) - Vec3::Y * 0.05 * along * along;
                // Beside the ball, not through it.
                p * ((RADIUS + 0.1 + 0.05 * along) / p.length()).max(1.0)
            })
            .collect();
        guides.push(&points);
    }
    let style = vec![
        StyleOp::new(StyleKind::Clump { strands_per_clump: 25.0, flare: 0.2, stray: 0.3 }),
        StyleOp::new(StyleKind::Wave { amplitude: 0.3, wavelength: 4.0, strands_per_clump: 100.0 }),
        StyleOp::new(StyleKind::Frizz { amplitude: 0.05, wavelength: 1.0, strands_per_clump: 1.0 }),
    ];
    let mut hair = Layer {
        n_strands: N_STRANDS,
        vertices_per_strand: 16,
        radius_um: STRAND_RADIUS_UM,
        style,
        ..Layer::new("hair", Source::Guides(Arc::new(guides)))
    };
    hair.material.eumelanin = 0.35;
    hair.material.pheomelanin = 0.6;
    let lights = vec![
        Light::directional("key", 40.0, 40.0, 1.7, [1.0, 0.96, 0.9]),
        Light::directional("fill", -50.0, 12.0, 0.5, [0.86, 0.93, 1.0]),
        Light::directional("rim", 190.0, 45.0, 2.5, [1.0, 0.98, 0.95]),
    ];
    let mut groom =
        Groom { name: "golden".to_owned(), head: Some(ball()), layers: vec![hair], lights, ..Groom::default() };
    // Enough for a picture of 256 pixels, and a sixteenth of the work.
    groom.look.shadows.resolution = 256;
    // Lamps show a lobe that is missing, light from all around hides it.
    groom.look.environment_intensity = 0.09;
    groom
}

fn ball() -> Head {
    let (n_rings, n_around) = (32_u32, 64_u32);
    let mut mesh = TriMesh::default();
    for i in 0..=n_rings {
        let (v, polar) = (i as f32 / n_rings as f32, i as f32 / n_rings as f32 * std::f32::consts::PI);
        for j in 0..=n_around {
            let u = j as f32 / n_around as f32;
            let (sin, cos) = (u * std::f32::consts::TAU).sin_cos();
            mesh.positions.push(RADIUS * Vec3::new(polar.sin() * sin, polar.cos(), polar.sin() * cos));
            mesh.uvs.push([u, 1.0 - v]);
            if i < n_rings && j < n_around {
                let (a, b) = (i * (n_around + 1) + j, (i + 1) * (n_around + 1) + j);
                // The poles' rings have no width: one triangle of each quad there is none.
                if i > 0 {
                    mesh.triangles.push([a, b, a + 1]);
                }
                if i + 1 < n_rings {
                    mesh.triangles.push([a + 1, b, b + 1]);
                }
            }
        }
    }
    mesh.compute_normals();
    Head::new("ball", mesh)
}
