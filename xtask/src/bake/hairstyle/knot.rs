//! A knot at the back of the head: the rope of all hair led once through itself, its end hanging out. The
//! line is a trefoil that is open at its lowest loop. As in Yuksel, Schaefer and Keyser 2009, figure 3.

use glam::{Vec2, Vec3, vec3};
use lorelei_core::curve::catmull_rom;
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::style::StyleKind;

use super::gather::{Comb, Tress, evenly, gather, rope};
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const N_COLUMNS: usize = 28;
const N_SECTIONS: usize = 26;
/// Of the trefoil: its arms are about three of this long. Centimetres.
const SIZE: f32 = 1.25;
/// Between what passes over and what passes under, half, in centimetres.
const DEPTH: f32 = 1.05;

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let grid = studio.chart.grid_around(vec3(-0.3, 1.0, -11.7), N_COLUMNS, 6);
    let out = vec3(0.0, 0.12, -1.0).normalize();
    // Seen from behind: to the right is -x.
    let (right, up) = (Vec3::NEG_X, out.cross(Vec3::NEG_X));
    let held = vec3(-0.4, 0.8, -12.2);
    let middle = vec3(0.0, 2.6, -14.1);
    let trefoil = |t: f32| {
        let flat = Vec2::new(t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos());
        middle + SIZE * (flat.x * right + flat.y * up) - DEPTH * (3.0 * t).sin() * out
    };
    let open = 0.62;
    let (begin, end) = (std::f32::consts::PI + open, 3.0 * std::f32::consts::PI - open);
    let mut bends = vec![held, held + 0.6 * out + 0.6 * right];
    bends.extend((0..=24).map(|k| trefoil(lerp(begin, end, k as f32 / 24.0))));
    let last = bends[bends.len() - 1];
    bends.extend([
        last + vec3(0.1, -2.2, -0.5),
        last + vec3(0.1, -5.0, -0.4),
        last + vec3(0.0, -8.0, 0.3),
        last + vec3(0.0, -10.5, 1.2),
    ]);
    let line: Vec<Vec3> = (0..=(bends.len() - 1) * 8).map(|k| catmull_rom(&bends, k as f32 / 8.0)).collect();
    let coil = rope(&evenly(&line, N_SECTIONS), right, |t| {
        let size = lerp(1.05, 1.22, smoothstep(0.0, 0.12, t)) + 0.45 * smoothstep(0.8, 0.93, t)
            - 0.75 * smoothstep(0.93, 1.0, t);
        Vec2::splat(size)
    });
    let course = |k: usize, place: Vec2| coil[k].at(place);
    let tress = Tress { columns: 0..N_COLUMNS, course: &course };
    let axes = (coil[0].x.normalize(), coil[0].y.normalize());
    let mesh = gather(studio, &grid, N_COLUMNS, &Comb::default(), axes, N_SECTIONS, &[tress])?;
    let mut main = Layer {
        material: HairMaterial { eumelanin: 0.35, pheomelanin: 0.9, colour_variation: 0.25, ..HairMaterial::default() },
        ..studio.gathered_layer(mesh, 80)
    };
    main.style.push(op(StyleKind::Length { variation: 0.07, strands_per_clump: 36.0 }));
    studio.style("Knot", &grid, main, Strays::by(0.5), 2.4)
}
