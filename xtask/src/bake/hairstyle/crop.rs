//! A short crop: three fingers long on top, combed forward from the whorl, close at the sides and the nape.

use std::sync::Arc;

use glam::{Quat, vec3};
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::grow::Growth;
use lorelei_core::style::{StyleKind, StyleOp};

use super::roots::{Root, RootGrid};
use super::{Strays, Studio, density, lerp, op};
use crate::bake::sdf::smoothstep;

const N_COLUMNS: usize = 28;
const LAYERS_AT: [f32; 6] = [0.12, 0.28, 0.46, 0.64, 0.82, 1.0];

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let crown = vec3(1.0, 9.6, -6.4);
    let grid = studio.chart.grid_around(crown, N_COLUMNS, 6);
    let mesh = studio.hair_mesh(
        &grid,
        &LAYERS_AT,
        |root| {
            // Around the whorl, forward on top, to one side over the forehead, down at the back.
            let turn = 0.8 * (-(root.position.distance(crown) / 4.0).powi(2)).exp();
            let away = Quat::from_axis_angle(root.normal, turn) * -root.flow;
            let top = smoothstep(3.0, 8.5, root.position.y);
            let front = smoothstep(-7.0, 1.0, root.position.z) * top;
            let flow = away + vec3(-0.45, 0.0, 0.9) * front + vec3(0.0, -0.35, -0.25) * (1.0 - top);
            let growth = Growth {
                length: lerp(lerp(1.7, 2.8, smoothstep(-7.0, 3.0, root.position.y)), 5.4, top),
                lift: lerp(0.16, 0.42, top),
                fall: lerp(0.06, 0.14, top),
                weight: 0.02,
                clearance: lerp(0.3, 0.8, top),
                clear_over: lerp(2.0, 3.0, top),
            };
            (flow, growth)
        },
        |_, path| studio.clear(path, 0.25),
    )?;
    let main = Layer {
        radius_um: 47.0,
        tip_radius: 0.2,
        style: vec![
            op(StyleKind::Length { variation: 0.16, strands_per_clump: 70.0 }),
            op(StyleKind::Length { variation: 0.16, strands_per_clump: 1.0 }),
            StyleOp {
                strength: 0.35,
                ramp: 1.0,
                ..op(StyleKind::Clump { strands_per_clump: 320.0, flare: 0.0, stray: 0.6 })
            },
            StyleOp {
                strength: 0.8,
                ramp: 0.7,
                ..op(StyleKind::Clump { strands_per_clump: 50.0, flare: 0.0, stray: 0.6 })
            },
            StyleOp {
                ramp: 1.2,
                ..op(StyleKind::Frizz { amplitude: 0.24, wavelength: 5.0, strands_per_clump: 320.0 })
            },
            StyleOp { ramp: 1.0, ..op(StyleKind::Frizz { amplitude: 0.15, wavelength: 3.4, strands_per_clump: 50.0 }) },
            StyleOp { ramp: 0.6, ..op(StyleKind::Frizz { amplitude: 0.07, wavelength: 2.0, strands_per_clump: 1.0 }) },
            op(StyleKind::Deviate { share: 0.1, amplitude: 0.3, lift: 0.2, whole: 0.0 }),
        ],
        material: HairMaterial { eumelanin: 2.2, pheomelanin: 0.3, colour_variation: 0.2, ..HairMaterial::default() },
        maps: density(Arc::new(studio.chart.whorl_density(crown))),
        ..studio.gathered_layer(mesh, 16)
    };
    // The grid's flow is towards the crown; short hair lies away from it.
    let outwards = RootGrid {
        roots: grid.roots.iter().map(|root| Root { flow: -root.flow, ..*root }).collect(),
        faces: grid.faces.clone(),
    };
    studio.style("Short crop", &outwards, main, Strays::by(0.4), 1.4)
}
