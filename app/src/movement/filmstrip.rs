//! A movement as one picture: frames of it side by side, under each its time.

use egui::Color32;
use glam::Vec3;
use image::{Rgba, RgbaImage};
use lorelei_core::camera::Camera;
use lorelei_core::groom::Groom;
use lorelei_core::look::Choice;
use lorelei_core::simulation::{Moved, Wind};
use lorelei_core::wind::MAX_SOURCES;

use super::Shot;
use crate::lettering::Pen;
use crate::stage::{bounds_of, portrait_of};

/// Frames of a strip.
pub const N_PICTURES: u32 = 8;

const BACKGROUND: Rgba<u8> = Rgba([30, 30, 30, 255]);
const STRONG: Color32 = Color32::from_gray(240);
const WEAK: Color32 = Color32::from_gray(165);
const GAP: u32 = 6;
const TITLE: f32 = 20.0;
const SMALL: f32 = 14.0;
/// Hair is framed so far from the groom's middle, centimetres.
const FARTHEST: f32 = 80.0;

/// The frames that a strip of a movement of `n_frames` shows: the first, the last, and evenly between.
pub fn frames_of(n_frames: u32) -> Vec<u32> {
    let mut frames: Vec<u32> = (0..N_PICTURES)
        .map(|i| (f64::from(n_frames) * f64::from(i) / f64::from(N_PICTURES - 1)).round() as u32)
        .collect();
    frames.dedup();
    frames
}

/// What is seen: the groom, what happens, by which law, and what blows.
pub fn title_of(groom: &Groom) -> String {
    let simulation = &groom.simulation;
    let mut parts = vec![groom.movement.motion.info().label.to_owned(), simulation.solver.info().label.to_lowercase()];
    if simulation.moved != Moved::Guides {
        parts.push(simulation.moved.info().label.to_lowercase());
    }
    if simulation.wind != Wind::Off {
        let steady = (simulation.wind_speed > 0.0).then(|| format!("wind {:.0} cm/s", simulation.wind_speed));
        let sources = simulation.sources.iter().filter(|source| source.on && source.speed > 0.0).take(MAX_SOURCES);
        let blowing: Vec<String> = steady
            .into_iter()
            .chain(sources.map(|source| format!("{} {:.0} cm/s", source.name, source.speed)))
            .collect();
        if !blowing.is_empty() {
            parts.extend(blowing);
            parts.push(if simulation.wind == Wind::Grid { "on the grid" } else { "no grid" }.to_owned());
        }
    }
    format!("{}: {}", groom.name, parts.join(", "))
}

/// The camera that was asked for; where that frames the groom at rest, hair and head of all frames fill the picture.
pub fn camera_of_all(groom: &Groom, camera: &Camera, shots: &[(u32, Shot)], aspect: f32) -> Camera {
    let at_rest = bounds_of(groom);
    let mut framed = *camera;
    framed.frame(at_rest, aspect);
    if framed != *camera || shots.is_empty() {
        return *camera;
    }
    let head: Vec<Vec3> = portrait_of(groom).collect();
    // An explosion need not be framed whole.
    let near = |shot: &Shot, p: Vec3| {
        let middle = shot.world_from_head.transform_point3(0.5 * (at_rest.0 + at_rest.1));
        middle + (p - middle).clamp(Vec3::splat(-FARTHEST), Vec3::splat(FARTHEST))
    };
    framed.fit(
        shots.iter().flat_map(|(_, shot)| {
            let hair = shot.positions.iter().flatten().filter(|p| p.is_finite()).map(|&p| near(shot, p));
            hair.chain(head.iter().map(|&p| shot.world_from_head.transform_point3(p)))
        }),
        aspect,
    );
    framed
}

/// Pictures of one size in a row, each over its time in seconds, below a title and a line.
pub fn filmstrip(title: &str, line: &str, frames: &[(f64, RgbaImage)]) -> RgbaImage {
    let [width, height] = frames.first().map_or([1, 1], |(_, picture)| [picture.width(), picture.height()]);
    let mut pen = Pen::new();
    let strip_width = GAP + (width + GAP) * frames.len().max(1) as u32;
    let text_width = strip_width.saturating_sub(2 * GAP);
    let title_height = pen.height(title, TITLE, text_width);
    let top = GAP + title_height + pen.height(line, SMALL, text_width) + 2 * GAP;
    let label_height = pen.height("0.00 s", SMALL, width);
    let mut strip = RgbaImage::from_pixel(strip_width, top + height + GAP + label_height + GAP, BACKGROUND);
    pen.write(&mut strip, [GAP, GAP], title, TITLE, text_width, STRONG);
    pen.write(&mut strip, [GAP, GAP + title_height + GAP / 2], line, SMALL, text_width, WEAK);
    for (i, (secs, picture)) in frames.iter().enumerate() {
        let left = GAP + (width + GAP) * i as u32;
        image::imageops::overlay(&mut strip, picture, i64::from(left), i64::from(top));
        let label = format!("{secs:.2} s");
        pen.write(&mut strip, [left + GAP, top + height + GAP], &label, SMALL, width, STRONG);
    }
    strip
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Affine3A;
    use lorelei_core::motion::Motion;
    use lorelei_core::simulation::Solver;
    use lorelei_core::wind::WindSource;

    #[test]
    fn a_title_names_the_motion_the_law_and_what_blows() {
        let mut groom = Groom { name: "Long".to_owned(), ..Groom::default() };
        groom.movement.motion = Motion::Shake;
        assert_eq!(title_of(&groom), "Long: Shake, rods");
        let simulation = &mut groom.simulation;
        simulation.solver = Solver::Chains;
        simulation.moved = Moved::Strands;
        simulation.wind_speed = 300.0;
        assert_eq!(title_of(&groom), "Long: Shake, chains, every strand, wind 300 cm/s, no grid");
        let simulation = &mut groom.simulation;
        let dryer = WindSource { name: "Dryer".to_owned(), speed: 800.0, ..WindSource::default() };
        simulation.sources = vec![dryer.clone(), WindSource { on: false, ..dryer }];
        (simulation.wind, simulation.wind_speed, simulation.moved) = (Wind::Grid, 0.0, Moved::Guides);
        assert_eq!(title_of(&groom), "Long: Shake, chains, Dryer 800 cm/s, on the grid");
        groom.simulation.wind = Wind::Off;
        assert_eq!(title_of(&groom), "Long: Shake, chains", "nothing blows in still air");
    }

    #[test]
    fn a_strip_frames_hair_and_head_wherever_a_jump_takes_them() {
        let groom = lorelei_assets::default_groom();
        let aspect = 300.0 / 360.0;
        let mut asked = Camera { azimuth_deg: 40.0, ..Camera::default() };
        asked.frame(bounds_of(&groom), aspect);
        let hair = [Vec3::new(0.0, -25.0, 0.0), Vec3::new(15.0, 0.0, 0.0)];
        let shots: Vec<(u32, Shot)> = [0.0, 60.0]
            .map(|up| {
                let world_from_head = Affine3A::from_translation(Vec3::Y * up);
                let positions = vec![hair.iter().map(|&p| world_from_head.transform_point3(p)).collect()];
                (up as u32, Shot { world_from_head, positions })
            })
            .into();
        let camera = camera_of_all(&groom, &asked, &shots, aspect);
        let (mut lowest, mut highest) = (f32::INFINITY, f32::NEG_INFINITY);
        for (_, shot) in &shots {
            let head = portrait_of(&groom).map(|p| shot.world_from_head.transform_point3(p));
            for p in head.chain(shot.positions[0].iter().copied()) {
                let seen = camera.clip_from_world(aspect).project_point3(p);
                assert!(seen.x.abs() < 0.98 && seen.y.abs() < 0.98, "{p} at {seen}");
                (lowest, highest) = (lowest.min(seen.y), highest.max(seen.y));
            }
        }
        assert!(highest - lowest > 1.85, "{lowest} to {highest}");
        let close = Camera { distance: 30.0, ..asked };
        assert_eq!(camera_of_all(&groom, &close, &shots, aspect), close, "a camera that was asked for");
    }

    #[test]
    fn a_strip_shows_the_first_and_the_last_frame_and_every_picture_whole() {
        assert_eq!(frames_of(70), [0, 10, 20, 30, 40, 50, 60, 70]);
        assert_eq!(frames_of(3), [0, 1, 2, 3]);
        assert_eq!(frames_of(0), [0]);
        let frames: Vec<(f64, RgbaImage)> =
            (0..3).map(|i| (f64::from(i), RgbaImage::from_pixel(40, 30, Rgba([200 + i as u8, 0, 0, 255])))).collect();
        let strip = filmstrip("Title", "line", &frames);
        for shade in 200..203 {
            assert_eq!(strip.pixels().filter(|pixel| pixel.0 == [shade, 0, 0, 255]).count(), 40 * 30, "{shade}");
        }
    }
}
