//! Tight curls, a round cloud around the head: every lock its own helix.

use glam::vec3;
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::grow::Growth;
use lorelei_core::style::{StyleKind, StyleOp};

use super::roots::Layout;
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const LAYERS_AT: [f32; 6] = [0.08, 0.2, 0.36, 0.55, 0.77, 1.0];

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let layout = Layout {
        parting_x: -0.6,
        crown: vec3(-0.6, 11.0, -1.5),
        parted: 0.3,
        n_columns: 16,
        n_rows: 6,
        whorl: 0.7,
        whorl_radius: 3.5,
    };
    let grid = studio.chart.grid(&layout);
    let mesh = studio.hair_mesh(
        &grid,
        &LAYERS_AT,
        |root| {
            // Over the forehead forwards: curls cover the hairline.
            let front = smoothstep(0.35, 0.0, root.back);
            let flow = root.flow + vec3(0.0, 0.0, 0.9) * front;
            let growth = Growth {
                // Longest from the crown, tapered to the hairline.
                length: lerp(10.5, 6.5, smoothstep(0.25, 1.0, root.along)) + smoothstep(0.4, 0.75, root.back)
                    - 1.5 * front
                    - 3.0 * smoothstep(0.7, 1.0, root.back) * smoothstep(0.4, 1.0, root.along),
                lift: lerp(0.92, 0.45, root.along) - 0.15 * front * root.along,
                fall: 0.05 + 0.07 * front,
                weight: 0.014,
                clearance: lerp(2.8, 0.7, root.along) * (1.0 - 0.35 * front),
                clear_over: 6.0,
            };
            (flow, growth)
        },
        |_, _| {},
    )?;
    let main = Layer {
        vertices_per_strand: 80,
        radius_um: 38.0,
        tip_radius: 0.35,
        style: vec![
            op(StyleKind::Length { variation: 0.3, strands_per_clump: 44.0 }),
            op(StyleKind::Length { variation: 0.1, strands_per_clump: 1.0 }),
            StyleOp {
                strength: 0.2,
                ramp: 0.8,
                ..op(StyleKind::Clump { strands_per_clump: 500.0, flare: 0.6, stray: 0.5 })
            },
            StyleOp {
                strength: 0.96,
                ramp: 0.25,
                ..op(StyleKind::Clump { strands_per_clump: 44.0, flare: 0.1, stray: 0.3 })
            },
            StyleOp {
                ramp: 0.3,
                ..op(StyleKind::Curl { radius: 0.44, pitch: 1.25, strands_per_clump: 44.0, loosen: 0.35 })
            },
            op(StyleKind::Frizz { amplitude: 0.5, wavelength: 5.0, strands_per_clump: 44.0 }),
            StyleOp { ramp: 0.5, ..op(StyleKind::Frizz { amplitude: 0.05, wavelength: 1.3, strands_per_clump: 1.0 }) },
            op(StyleKind::Deviate { share: 0.04, amplitude: 0.7, lift: 0.3, whole: 0.0 }),
        ],
        material: HairMaterial {
            eumelanin: 1.7,
            pheomelanin: 0.3,
            colour_variation: 0.15,
            tip_lightening: 0.25,
            ..HairMaterial::default()
        },
        ..studio.main_layer(&layout, mesh)
    };
    let curl = op(StyleKind::Curl { radius: 0.4, pitch: 1.6, strands_per_clump: 1.0, loosen: 0.5 });
    let mut groom = studio.style("Tight curls", &grid, main, Strays { amplitude: 1.2, extra: vec![curl] }, 2.4)?;
    let baby_hairs = &mut groom.layers[2];
    baby_hairs.vertices_per_strand = 24;
    baby_hairs.style.push(op(StyleKind::Curl { radius: 0.16, pitch: 0.9, strands_per_clump: 12.0, loosen: 0.3 }));
    Ok(groom)
}
