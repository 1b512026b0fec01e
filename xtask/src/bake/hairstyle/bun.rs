//! A bun on the crown: combed up, held, then over a ball of its own hair with a swirl, ends tucked under.
//! As in Yuksel, Schaefer and Keyser 2009, figure 4.

use glam::{Quat, Vec2, Vec3, vec3};
use lorelei_core::groom::{Groom, HairMaterial, Layer};

use super::gather::{Comb, Tress, gather};
use super::{Strays, Studio, lerp};
use crate::bake::sdf::smoothstep;

const N_COLUMNS: usize = 28;
const N_SECTIONS: usize = 13;
/// Of the ball, centimetres.
const RADIUS: f32 = 3.1;
/// Turns of the swirl, radians.
const SWIRL: f32 = 2.6;

pub fn groom(studio: &Studio) -> Result<Groom, String> {
    let grid = studio.chart.grid_around(vec3(0.0, 10.0, -6.6), N_COLUMNS, 6);
    let up = vec3(0.0, 0.8, -0.6).normalize();
    let (x, y) = (Vec3::X, up.cross(Vec3::X));
    let held = vec3(0.0, 10.9, -7.3);
    let ball = held + 2.1 * up;
    let course = |k: usize, place: Vec2| {
        let t = k as f32 / (N_SECTIONS - 1) as f32;
        let rank = place.length();
        let way = place / rank.max(1e-6);
        // Up the middle, then over the ball; what comes from the hairline is outside.
        let column = held + 1.25 * (place.x * x + place.y * y) + up * 2.4 * smoothstep(0.0, 0.3, t);
        let polar = lerp(0.25, 2.75, smoothstep(0.12, 1.0, t) * lerp(0.9, 1.0, t));
        let turned = Quat::from_axis_angle(up, SWIRL * smoothstep(0.15, 1.0, t)) * (way.x * x + way.y * y);
        // A little flat, and uneven as hands leave it.
        let uneven = 1.0 + 0.05 * (3.0 * way.y.atan2(way.x) + 2.0 * t).sin();
        let shell = RADIUS * lerp(0.45, 1.0, rank) * uneven;
        let over = ball + shell * (0.86 * polar.cos() * up + 1.08 * polar.sin() * turned);
        column.lerp(over, smoothstep(0.08, 0.32, t))
    };
    let tress = Tress { columns: 0..N_COLUMNS, course: &course };
    let mesh = gather(studio, &grid, N_COLUMNS, &Comb::default(), (x, y), N_SECTIONS, &[tress])?;
    let main = Layer {
        material: HairMaterial { eumelanin: 1.4, pheomelanin: 0.5, colour_variation: 0.25, ..HairMaterial::default() },
        ..studio.gathered_layer(mesh, 56)
    };
    studio.style("Bun", &grid, main, Strays::by(0.5), 2.4)
}
