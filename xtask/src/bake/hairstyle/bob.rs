//! A wavy bob to the jaw with a side parting: fullest at the cheekbones, ends turned in.

use glam::vec3;
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::grow::Growth;
use lorelei_core::style::{StyleKind, StyleOp};

use super::long::outwards;
use super::roots::Layout;
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const LAYERS_AT: [f32; 8] = [0.05, 0.12, 0.23, 0.37, 0.52, 0.68, 0.84, 1.0];

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let layout = Layout {
        parting_x: 2.9,
        crown: vec3(1.2, 9.6, -6.2),
        parted: 0.55,
        n_columns: 17,
        n_rows: 6,
        whorl: 0.9,
        whorl_radius: 3.0,
    };
    let grid = studio.chart.grid(&layout);
    let mesh = studio.hair_mesh(
        &grid,
        &LAYERS_AT,
        |root| {
            let front = smoothstep(0.42, 0.0, root.back);
            let flow = root.flow + vec3(0.0, 0.0, -0.6) * front * lerp(0.35, 1.0, root.along) + vec3(0.0, -0.1, 0.0);
            // Longer in front than at the nape, and shorter on top of it: the bob's line.
            let end = lerp(-8.6, -10.4, smoothstep(0.9, 0.1, root.back)) + 2.2 * (1.0 - root.along);
            let down = (root.position.y - end).max(2.5);
            let growth = Growth {
                length: down * 1.12 + lerp(7.0, 1.2, root.along),
                lift: lerp(0.2, 0.16, root.along),
                fall: 0.10,
                weight: 0.022,
                clearance: lerp(1.5, 0.4, root.along) * (1.0 - 0.45 * front),
                clear_over: lerp(7.0, 3.5, root.along),
            };
            (flow, growth)
        },
        |root, path| {
            // Fuller at the cheekbones, ends turned in.
            let n = path.len() as f32 - 1.0;
            for (k, p) in path.iter_mut().enumerate() {
                let t = k as f32 / n;
                let belly = smoothstep(0.25, 0.6, t) * smoothstep(7.0, 0.0, (p.y + 3.0).abs());
                let turn = smoothstep(0.72, 1.0, t);
                *p += outwards(*p) * (0.8 * belly - 1.3 * turn * turn) * lerp(1.0, 0.5, root.along);
            }
            studio.clear(path, lerp(1.2, 0.4, root.along));
        },
    )?;
    let main = Layer {
        vertices_per_strand: 36,
        radius_um: 42.0,
        tip_radius: 0.3,
        style: vec![
            op(StyleKind::Length { variation: 0.10, strands_per_clump: 400.0 }),
            op(StyleKind::Length { variation: 0.12, strands_per_clump: 40.0 }),
            op(StyleKind::Length { variation: 0.08, strands_per_clump: 1.0 }),
            StyleOp {
                strength: 0.45,
                ramp: 0.9,
                ..op(StyleKind::Clump { strands_per_clump: 400.0, flare: 0.25, stray: 0.5 })
            },
            StyleOp {
                strength: 0.72,
                ramp: 0.5,
                ..op(StyleKind::Clump { strands_per_clump: 40.0, flare: 0.4, stray: 0.6 })
            },
            StyleOp {
                from: 0.08,
                ramp: 0.7,
                ..op(StyleKind::Wave { amplitude: 0.6, wavelength: 6.0, strands_per_clump: 400.0 })
            },
            StyleOp { ramp: 0.6, ..op(StyleKind::Wave { amplitude: 0.16, wavelength: 3.8, strands_per_clump: 40.0 }) },
            StyleOp { ramp: 0.5, ..op(StyleKind::Frizz { amplitude: 0.16, wavelength: 3.4, strands_per_clump: 40.0 }) },
            StyleOp { ramp: 0.4, ..op(StyleKind::Frizz { amplitude: 0.08, wavelength: 2.2, strands_per_clump: 1.0 }) },
            op(StyleKind::Deviate { share: 0.06, amplitude: 0.8, lift: 0.2, whole: 0.0 }),
        ],
        material: HairMaterial {
            eumelanin: 0.4,
            pheomelanin: 1.1,
            tip_lightening: 0.2,
            colour_variation: 0.2,
            ..HairMaterial::default()
        },
        ..studio.main_layer(&layout, mesh)
    };
    let wave = StyleOp {
        from: 0.08,
        ramp: 0.6,
        ..op(StyleKind::Wave { amplitude: 0.5, wavelength: 5.6, strands_per_clump: 20.0 })
    };
    studio.style("Wavy bob", &grid, main, Strays { amplitude: 1.5, extra: vec![wave] }, 2.6)
}
