//! Long straight hair with a parting a little off the middle, ends layered over a hand's breadth.

use glam::{Vec3, vec3};
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::grow::Growth;
use lorelei_core::style::{StyleKind, StyleOp};

use super::roots::Layout;
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const LAYERS_AT: [f32; 9] = [0.03, 0.08, 0.16, 0.27, 0.40, 0.54, 0.69, 0.84, 1.0];

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let layout = Layout {
        parting_x: 1.1,
        crown: vec3(0.9, 10.0, -5.6),
        parted: 0.58,
        n_columns: 17,
        n_rows: 6,
        whorl: 0.9,
        whorl_radius: 2.8,
    };
    let grid = studio.chart.grid(&layout);
    let mesh = studio.hair_mesh(
        &grid,
        &LAYERS_AT,
        |root| {
            let front = smoothstep(0.45, 0.0, root.back);
            // Combed away from the face: the front goes back as well as to the side.
            let flow = root.flow + vec3(0.0, 0.0, -0.55) * front * lerp(0.35, 1.0, root.along) + vec3(0.0, -0.2, 0.0);
            // Ends hang at one height and are layered: upper rows and the front a little shorter.
            let end = -24.5 + 3.5 * (1.0 - root.along) + 4.5 * front * front;
            let down = (root.position.y - end).max(6.0);
            let growth = Growth {
                length: down * 1.03 + lerp(6.5, 1.0, root.along),
                lift: lerp(0.17, 0.14, root.along),
                fall: 0.085,
                weight: 0.018,
                clearance: lerp(0.95, 0.35, root.along),
                clear_over: lerp(7.0, 3.0, root.along),
            };
            (flow, growth)
        },
        |root, path| studio.clear(path, lerp(0.9, 0.45, root.along)),
    )?;
    let main = Layer {
        vertices_per_strand: 32,
        radius_um: 42.0,
        tip_radius: 0.3,
        style: vec![
            op(StyleKind::Length { variation: 0.14, strands_per_clump: 800.0 }),
            op(StyleKind::Length { variation: 0.16, strands_per_clump: 40.0 }),
            op(StyleKind::Length { variation: 0.10, strands_per_clump: 1.0 }),
            StyleOp {
                strength: 0.32,
                from: 0.05,
                ramp: 1.2,
                ..op(StyleKind::Clump { strands_per_clump: 800.0, flare: 0.3, stray: 0.5 })
            },
            StyleOp {
                strength: 0.30,
                ramp: 0.9,
                ..op(StyleKind::Clump { strands_per_clump: 200.0, flare: 0.3, stray: 0.6 })
            },
            StyleOp {
                strength: 0.72,
                ramp: 0.5,
                ..op(StyleKind::Clump { strands_per_clump: 40.0, flare: 0.5, stray: 0.7 })
            },
            StyleOp {
                from: 0.1,
                ramp: 0.8,
                ..op(StyleKind::Wave { amplitude: 0.75, wavelength: 12.0, strands_per_clump: 800.0 })
            },
            StyleOp {
                ramp: 0.8,
                ..op(StyleKind::Frizz { amplitude: 0.28, wavelength: 7.0, strands_per_clump: 200.0 })
            },
            StyleOp {
                ramp: 0.45,
                ..op(StyleKind::Frizz { amplitude: 0.17, wavelength: 4.0, strands_per_clump: 40.0 })
            },
            StyleOp { ramp: 0.4, ..op(StyleKind::Frizz { amplitude: 0.07, wavelength: 2.4, strands_per_clump: 1.0 }) },
            op(StyleKind::Deviate { share: 0.06, amplitude: 0.8, lift: 0.1, whole: 0.0 }),
        ],
        material: HairMaterial {
            eumelanin: 0.8,
            pheomelanin: 0.3,
            tip_lightening: 0.25,
            colour_variation: 0.3,
            ..HairMaterial::default()
        },
        ..studio.main_layer(&layout, mesh)
    };
    studio.style("Long, straight", &grid, main, Strays::by(1.5), 3.2)
}

/// Unit vector out of the axis of head and neck.
pub fn outwards(p: Vec3) -> Vec3 {
    vec3(p.x, 0.0, p.z + 2.5).normalize_or(Vec3::X)
}
