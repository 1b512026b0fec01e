//! A braid of three strands, from the nape over the shoulder: each takes a third of the columns, and all
//! three run along one line, side by side and over each other in turn.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec3};
use lorelei_core::curve::catmull_rom;
use lorelei_core::groom::{Groom, HairMaterial, Layer};
use lorelei_core::style::StyleKind;

use super::gather::{Comb, Section, Tress, evenly, gather, rope};
use super::{Strays, Studio, lerp, op};
use crate::bake::sdf::smoothstep;

const N_COLUMNS: usize = 27;
const N_SECTIONS: usize = 46;
/// The line of the braid: from the nape, around the neck, over the shoulder and down in front.
const LINE: [Vec3; 8] = [
    vec3(0.6, -4.6, -10.6),
    vec3(1.6, -6.8, -11.4),
    vec3(3.8, -9.8, -11.0),
    vec3(6.4, -12.8, -8.4),
    vec3(8.2, -15.2, -4.2),
    vec3(8.8, -17.4, 0.4),
    vec3(8.6, -20.4, 3.8),
    vec3(8.2, -26.0, 5.6),
];
/// Lengths in which each strand crosses over once and under once.
const N_PERIODS: f32 = 5.0;
/// Where the braid is bound, as a share of the line.
const BOUND: f32 = 0.86;

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let grid = studio.chart.grid_around(vec3(0.3, -2.2, -10.8), N_COLUMNS, 6);
    let fine: Vec<Vec3> = (0..=(LINE.len() - 1) * 16).map(|k| catmull_rom(&LINE, k as f32 / 16.0)).collect();
    let mut line = evenly(&fine, N_SECTIONS * 4);
    // It lies on the body.
    for p in &mut line {
        for _ in 0..4 {
            let off = 1.75 - studio.body.sample(*p);
            if off > 0.0 {
                *p += off * studio.body.gradient(*p).normalize_or(Vec3::Z);
            }
        }
    }
    let line = evenly(&line, N_SECTIONS);
    let last = N_SECTIONS - 1;
    // `y` looks away from the body.
    let frames: Vec<Section> = (0..N_SECTIONS)
        .map(|k| {
            let along = (line[(k + 1).min(last)] - line[k.saturating_sub(1)]).normalize();
            let y = studio.body.gradient(line[k]).reject_from_normalized(along).normalize_or(Vec3::Z);
            Section { middle: line[k], x: y.cross(along), y }
        })
        .collect();
    let strand = |which: usize| {
        let middles: Vec<Vec3> = frames
            .iter()
            .enumerate()
            .map(|(k, frame)| {
                let t = k as f32 / last as f32;
                let phase = TAU * (N_PERIODS * t + which as f32 / 3.0);
                // Together at the nape and where it is bound.
                let spread = smoothstep(0.0, 0.1, t) * smoothstep(BOUND, BOUND - 0.07, t);
                let spread = spread * lerp(1.0, 0.8, t) + 0.25 * (1.0 - spread);
                frame.at(spread * Vec2::new(1.15 * phase.sin(), 0.62 * (2.0 * phase).sin()))
            })
            .collect();
        rope(&middles, frames[0].x, |t| {
            let bound = 1.0 - 0.42 * smoothstep(BOUND - 0.05, BOUND, t) * smoothstep(BOUND + 0.05, BOUND, t);
            let tassel = 0.35 * smoothstep(BOUND, 0.95, t);
            Vec2::new(0.98, 0.86) * (lerp(1.0, 0.78, t) * bound + tassel)
        })
    };
    let strands = [strand(0), strand(1), strand(2)];
    let courses = strands.each_ref().map(|strand| move |k: usize, place: Vec2| strand[k].at(place));
    let third = N_COLUMNS / 3;
    let tresses: Vec<Tress<'_>> =
        courses.iter().enumerate().map(|(i, course)| Tress { columns: i * third..(i + 1) * third, course }).collect();
    let axes = (frames[0].x, frames[0].y);
    let mesh = gather(studio, &grid, N_COLUMNS, &Comb::default(), axes, N_SECTIONS, &tresses)?;
    let mut main = Layer {
        material: HairMaterial {
            eumelanin: 0.28,
            pheomelanin: 0.25,
            tip_lightening: 0.2,
            colour_variation: 0.3,
            ..HairMaterial::default()
        },
        ..studio.gathered_layer(mesh, 104)
    };
    main.style.push(op(StyleKind::Length { variation: 0.05, strands_per_clump: 36.0 }));
    studio.style("Braid", &grid, main, Strays::by(0.5), 2.4)
}
