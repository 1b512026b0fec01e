//! A high ponytail: combed back smoothly, held at the crown, falling in one swing behind the neck.

use glam::{Vec2, Vec3, vec3};
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::style::{StyleKind, StyleOp};

use super::gather::{Comb, Tress, evenly, gather, rope};
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const N_COLUMNS: usize = 28;
const N_SECTIONS: usize = 10;

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let grid = studio.chart.grid_around(vec3(0.0, 7.4, -9.6), N_COLUMNS, 6);
    let out = vec3(0.0, 0.62, -0.78).normalize();
    let held = vec3(0.0, 8.0, -10.8);
    // Out of the band, over, and down: thrown, not hung.
    let mut line = vec![held];
    let mut way = out;
    while line.len() < 110 {
        let last = line[line.len() - 1];
        way = (way + 0.25 * 0.5 * Vec3::NEG_Y).normalize();
        let mut next = last + 0.25 * way;
        // The back and the shoulders carry the end.
        let off = 2.6 - studio.body.sample(next);
        if off > 0.0 {
            next += off * studio.body.gradient(next).normalize_or(Vec3::NEG_Z);
        }
        line.push(next);
    }
    let tail = rope(&evenly(&line, N_SECTIONS), Vec3::X, |t| {
        let swell = lerp(1.3, 2.5, smoothstep(0.0, 0.4, t)) - 0.9 * smoothstep(0.6, 1.0, t);
        Vec2::new(1.1 * swell, 0.85 * swell)
    });
    let course = |k: usize, place: Vec2| tail[k].at(place);
    let tress = Tress { columns: 0..N_COLUMNS, course: &course };
    let axes = (tail[0].x.normalize(), tail[0].y.normalize());
    let mesh = gather(studio, &grid, N_COLUMNS, &Comb::default(), axes, N_SECTIONS, &[tress])?;
    let mut main = Layer {
        material: HairMaterial {
            eumelanin: 0.7,
            pheomelanin: 0.5,
            tip_lightening: 0.3,
            colour_variation: 0.25,
            ..HairMaterial::default()
        },
        ..studio.gathered_layer(mesh, 48)
    };
    main.style.extend([
        op(StyleKind::Length { variation: 0.16, strands_per_clump: 260.0 }),
        op(StyleKind::Length { variation: 0.14, strands_per_clump: 1.0 }),
        StyleOp {
            from: 0.42,
            ramp: 1.0,
            ..op(StyleKind::Wave { amplitude: 0.9, wavelength: 11.0, strands_per_clump: 2000.0 })
        },
        StyleOp {
            from: 0.42,
            ramp: 0.8,
            ..op(StyleKind::Frizz { amplitude: 0.35, wavelength: 5.0, strands_per_clump: 260.0 })
        },
        StyleOp {
            from: 0.5,
            ramp: 1.0,
            ..op(StyleKind::Frizz { amplitude: 0.2, wavelength: 3.6, strands_per_clump: 36.0 })
        },
    ]);
    studio.style("Ponytail", &grid, main, Strays::by(0.8), 2.4)
}
