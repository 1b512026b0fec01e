//! The wind drawn over the picture: arrows, a slice coloured by speed, and tracers that the air carries like smoke.
//!
//! The air is that of the last frame, read back from the GPU while one of these is shown and never else. Tracers are no part
//! of the document: each leaves from a place that its number gives, upwind or at a source, and lives for a second or two.

use std::collections::VecDeque;

use egui::{Color32, Painter, Pos2, Shape, Ui};
use glam::{Vec3, Vec4Swizzles};
use lorelei_core::curve::catmull_rom;
use lorelei_core::hash::random;
use lorelei_core::wind::WindSource;
use lorelei_sim::wind::AirGrid;

use super::desk::Desk;
use super::projection::Projection;
use super::wind_handles::arrow;

/// Arrows along each side of the box.
const N_ARROWS: u32 = 9;
/// Share of a source's speed from which on its stream counts as blowing in the box.
const FELT: f32 = 0.05;
/// Squares along each side of the slice.
const N_SQUARES: u32 = 96;
const N_TRACERS: u32 = 500;
/// Places that a tracer's trail keeps.
const N_TRAIL: usize = 12;
/// Straight parts that a trail is drawn with between two of its places.
const PARTS: usize = 3;
/// Seconds that a tracer lives, at least; at most twice as long.
const LIFE_SECS: f32 = 0.8;
/// Steps of the tracers in a frame that is long, seconds each.
const STEP_SECS: f32 = 1.0 / 60.0;

/// What of the wind is shown; not in the document.
#[derive(Debug, Clone, Default)]
pub struct WindView {
    pub arrows: bool,
    pub slice: bool,
    pub tracers: bool,
    /// Across X, Y or Z.
    pub axis: usize,
    /// Where the slice is in the box, 0 to 1.
    pub at: f32,
    smoke: Smoke,
}

impl WindView {
    /// Nothing is shown; a slice would be in the middle, across Z.
    pub fn new() -> Self {
        Self { axis: 2, at: 0.5, ..Self::default() }
    }

    /// Whether the air has to be read back.
    pub fn is_on(&self) -> bool {
        self.arrows || self.slice || self.tracers
    }
}

#[derive(Debug, Clone, Default)]
struct Smoke {
    tracers: Vec<Tracer>,
    n_born: u32,
    /// Simulated seconds of the last frame.
    at_secs: f32,
}

#[derive(Debug, Clone, Default)]
struct Tracer {
    trail: VecDeque<Vec3>,
    left_secs: f32,
}

/// Draw what is asked for over the picture.
pub fn ui(ui: &Ui, desk: &mut Desk, projection: Projection) {
    if !desk.wind_view.is_on() {
        return;
    }
    let Some(air) = desk.report.air.clone() else { return };
    let space = Space::new(&air, desk.bounds);
    let fastest = fastest_of(&air, &space, &desk.document.groom.simulation.sources);
    let painter = ui.painter();
    if desk.wind_view.slice {
        slice(painter, projection, &air, &space, fastest, (desk.wind_view.axis, desk.wind_view.at));
    }
    if desk.wind_view.tracers {
        let secs = desk.report.timeline.secs as f32;
        desk.wind_view.smoke.advance(&air, &space, &desk.document.groom.simulation.sources, secs);
        desk.wind_view.smoke.draw(painter, projection);
    }
    if desk.wind_view.arrows {
        arrows(painter, projection, &air, &space, fastest);
    }
    legend(ui, projection, fastest);
}

/// The box that is drawn in, world.
struct Space {
    min: Vec3,
    size: Vec3,
}

impl Space {
    /// The grid's, or one around the groom where there is none.
    fn new(air: &AirGrid, bounds: (Vec3, Vec3)) -> Self {
        if air.params.n > 0 {
            return Self { min: air.params.min, size: Vec3::splat(air.params.n as f32 * air.params.cell) };
        }
        let side = 1.6 * (bounds.1 - bounds.0).max_element().clamp(10.0, 400.0);
        Self { min: 0.5 * (bounds.0 + bounds.1) - 0.5 * side, size: Vec3::splat(side) }
    }

    fn at(&self, share: Vec3) -> Vec3 {
        self.min + share * self.size
    }

    /// The middles of as many parts as there are arrows.
    fn places(&self) -> impl Iterator<Item = Vec3> {
        const N: u32 = N_ARROWS;
        let at = |i: u32| Vec3::new((i % N) as f32, (i / N % N) as f32, (i / (N * N)) as f32);
        (0..N * N * N).map(move |i| self.at((at(i) + 0.5) / N as f32))
    }

    fn holds(&self, p: Vec3) -> bool {
        let share = (p - self.min) / self.size;
        share.cmpge(Vec3::ZERO).all() && share.cmple(Vec3::ONE).all()
    }
}

/// The velocity at a place, and how open that is: 0 in the head.
fn sample(air: &AirGrid, p: Vec3) -> (Vec3, f32) {
    air.sample(p).map_or_else(|| (air.air_velocity(p), 1.0), |v| (v.xyz(), v.w))
}

/// The velocity at a place; `None` in the head.
fn velocity_at(air: &AirGrid, p: Vec3) -> Option<Vec3> {
    let (v, open) = sample(air, p);
    (open > 0.5).then_some(v)
}

/// What the colours end at: a little over the steady wind, or the fastest source that blows in the box. No gust or eddy moves
/// it, or the picture would change colour with each.
fn fastest_of(air: &AirGrid, space: &Space, sources: &[WindSource]) -> f32 {
    let steady = 1.3 * air.free.steady.length();
    // The free air has those that are on, in their order.
    let on = sources.iter().filter(|source| source.on).zip(&air.free.sources);
    let streams = on.filter_map(|(source, stream)| {
        let is_felt = |p: Vec3| stream.stream(p).length() > FELT * stream.speed;
        (space.holds(source.place) || space.places().any(is_felt)).then_some(source.speed)
    });
    streams.fold(steady, f32::max).max(20.0)
}

/// Dark blue where the air is calm, over green to yellow and white.
fn colour_of(speed: f32, fastest: f32) -> Color32 {
    const RAMP: [[f32; 3]; 5] =
        [[38.0, 48.0, 110.0], [32.0, 120.0, 160.0], [60.0, 180.0, 130.0], [225.0, 205.0, 80.0], [255.0, 248.0, 230.0]];
    let t = (speed / fastest).clamp(0.0, 1.0) * (RAMP.len() - 1) as f32;
    let i = (t as usize).min(RAMP.len() - 2);
    let mix = |c: usize| (RAMP[i][c] + (RAMP[i + 1][c] - RAMP[i][c]) * (t - i as f32)) as u8;
    Color32::from_rgb(mix(0), mix(1), mix(2))
}

fn arrows(painter: &Painter, projection: Projection, air: &AirGrid, space: &Space, fastest: f32) {
    let longest = 1.1 * space.size.x / N_ARROWS as f32;
    for at in space.places() {
        let Some(v) = velocity_at(air, at) else { continue };
        let speed = v.length();
        if speed < 0.02 * fastest {
            continue;
        }
        let way = v * (longest / fastest.max(speed));
        let ends = (projection.point(at - 0.5 * way), projection.point(at + 0.5 * way));
        if let (Some(from), Some(to)) = ends {
            // A shade beneath and some white: slow air is dark, and so may be what is behind it.
            arrow(painter, from, to, 2.8, Color32::from_black_alpha(90));
            arrow(painter, from, to, 1.4, colour_of(speed, fastest).lerp_to_gamma(Color32::WHITE, 0.3));
        }
    }
}

fn slice(
    painter: &Painter,
    projection: Projection,
    air: &AirGrid,
    space: &Space,
    fastest: f32,
    (axis, share): (usize, f32),
) {
    let n = N_SQUARES + 1;
    let axis = axis.min(2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut mesh = egui::Mesh::default();
    let mut is_seen = Vec::new();
    for i in 0..n * n {
        let mut place = Vec3::ZERO;
        place[axis] = share.clamp(0.0, 1.0);
        place[u] = (i % n) as f32 / N_SQUARES as f32;
        place[v] = (i / n) as f32 / N_SQUARES as f32;
        let at = space.at(place);
        let (v, open) = sample(air, at);
        let seen = projection.point(at);
        is_seen.push(seen.is_some());
        // What goes through a cell goes through its open part; the picture fades out where that is small.
        let speed = v.length() / open.max(0.5);
        let t = ((open - 0.3) / 0.4).clamp(0.0, 1.0);
        // Calm air lets the hair through.
        let strength = (0.35 + 0.4 * (2.0 * speed / fastest).min(1.0)) * t * t * (3.0 - 2.0 * t);
        let colour = colour_of(speed, fastest).gamma_multiply(strength);
        mesh.colored_vertex(seen.unwrap_or(Pos2::ZERO), colour);
    }
    for i in 0..N_SQUARES * N_SQUARES {
        let a = i % N_SQUARES + n * (i / N_SQUARES);
        let corners = [a, a + 1, a + n, a + n + 1];
        if corners.iter().all(|&corner| is_seen[corner as usize]) {
            mesh.add_triangle(corners[0], corners[1], corners[2]);
            mesh.add_triangle(corners[2], corners[1], corners[3]);
        }
    }
    painter.add(Shape::mesh(mesh));
}

impl Smoke {
    /// Let tracers go with the air until the time of the frame.
    fn advance(&mut self, air: &AirGrid, space: &Space, sources: &[WindSource], secs: f32) {
        let passed = secs - std::mem::replace(&mut self.at_secs, secs);
        if passed < 0.0 {
            // Time went back: what it carried is gone.
            self.tracers.clear();
            self.n_born = 0;
        }
        if self.tracers.is_empty() {
            self.tracers.resize(N_TRACERS as usize, Tracer::default());
        }
        let n_steps = (passed.clamp(0.0, 0.1) / STEP_SECS).round() as usize;
        for tracer in &mut self.tracers {
            for _ in 0..n_steps {
                tracer.left_secs -= STEP_SECS;
                let here = tracer.trail.back().copied();
                let next =
                    here.filter(|_| tracer.left_secs > 0.0).and_then(|p| carried(air, p)).filter(|&p| space.holds(p));
                if let Some(p) = next {
                    if tracer.trail.len() == N_TRAIL {
                        tracer.trail.pop_front();
                    }
                    tracer.trail.push_back(p);
                } else {
                    tracer.trail.clear();
                    tracer.trail.push_back(born(self.n_born, air, space, sources));
                    tracer.left_secs = LIFE_SECS * (1.0 + random(self.n_born, 9));
                    self.n_born = self.n_born.wrapping_add(1);
                }
            }
        }
    }

    fn draw(&self, painter: &Painter, projection: Projection) {
        let mut mesh = egui::Mesh::default();
        for tracer in &self.tracers {
            let trail: Vec<Vec3> = tracer.trail.iter().copied().collect();
            let n_parts = PARTS * trail.len().saturating_sub(1);
            let at = |i: usize| projection.point(catmull_rom(&trail, i as f32 / PARTS as f32));
            let points: Vec<Pos2> = (0..=n_parts).map_while(at).collect();
            // A trail grows out of nothing.
            let grown = trail.len().saturating_sub(1) as f32 / (N_TRAIL - 1) as f32;
            streak(&mut mesh, &points, grown * (tracer.left_secs / 0.3).clamp(0.0, 1.0));
        }
        painter.add(Shape::mesh(mesh));
    }
}

/// A thin ribbon that fades to both sides and to both ends, one mesh without seams: strokes would overlap at every joint and
/// show as beads.
fn streak(mesh: &mut egui::Mesh, points: &[Pos2], strength: f32) {
    let Some(last) = points.len().checked_sub(1).filter(|&last| last > 0) else { return };
    for (i, &p) in points.iter().enumerate() {
        let along = (points[(i + 1).min(last)] - points[i.saturating_sub(1)]).normalized();
        let from_tail = i as f32 / last as f32;
        let fade = from_tail * (6.0 * (1.0 - from_tail)).min(1.0);
        let side = (0.9 + 0.7 * from_tail) * along.rot90();
        let first = mesh.vertices.len() as u32;
        mesh.colored_vertex(p - side, Color32::TRANSPARENT);
        mesh.colored_vertex(p, Color32::from_white_alpha((170.0 * strength * fade) as u8));
        mesh.colored_vertex(p + side, Color32::TRANSPARENT);
        if i > 0 {
            for (a, b) in [(first - 3, first - 2), (first - 2, first - 1)] {
                mesh.add_triangle(a, b, a + 3);
                mesh.add_triangle(a + 3, b, b + 3);
            }
        }
    }
}

/// A step with the air, by the midpoint rule; `None` into the head.
fn carried(air: &AirGrid, p: Vec3) -> Option<Vec3> {
    let halfway = p + 0.5 * STEP_SECS * velocity_at(air, p)?;
    let next = p + STEP_SECS * velocity_at(air, halfway)?;
    velocity_at(air, next).map(|_| next)
}

/// Where a tracer begins: at a source, or where the steady wind comes into the box, or anywhere.
fn born(number: u32, air: &AirGrid, space: &Space, sources: &[WindSource]) -> Vec3 {
    let at = |purpose: u32| random(number, purpose);
    let blowing: Vec<&WindSource> = sources.iter().filter(|source| source.on && space.holds(source.place)).collect();
    let steady = air.free.steady;
    if !blowing.is_empty() && (at(1) < 0.6 || steady.length() < 1.0) {
        let source = blowing[(at(2) * blowing.len() as f32) as usize % blowing.len()];
        let (a, b) = source.direction.normalize_or(Vec3::NEG_Z).any_orthonormal_pair();
        let (sin, cos) = (std::f32::consts::TAU * at(3)).sin_cos();
        return source.place + source.radius * at(4).sqrt() * (cos * a + sin * b);
    }
    let p = space.at(Vec3::new(at(5), at(6), at(7)));
    let back = -steady.normalize_or_zero();
    // Compute the way back to the face that it came in by.
    let mut way = f32::INFINITY;
    for axis in 0..3 {
        if back[axis].abs() > 1e-3 {
            let face = space.min[axis] + if back[axis] > 0.0 { space.size[axis] } else { 0.0 };
            way = way.min((face - p[axis]) / back[axis]);
        }
    }
    // Some begin on their way, or smoke would come in puffs.
    if way.is_finite() { p + (0.98 - 0.5 * at(8) * at(8)) * way * back } else { p }
}

/// What the colours mean.
fn legend(ui: &Ui, projection: Projection, fastest: f32) {
    let rect = projection.rect();
    let bar = egui::Rect::from_min_size(rect.right_bottom() + egui::vec2(-176.0, -30.0), egui::vec2(160.0, 8.0));
    let n = 32;
    for i in 0..n {
        let from = bar.left() + bar.width() * i as f32 / n as f32;
        let part =
            egui::Rect::from_min_size(egui::pos2(from, bar.top()), egui::vec2(bar.width() / n as f32 + 0.5, 8.0));
        ui.painter().rect_filled(part, 0.0, colour_of(fastest * (i as f32 + 0.5) / n as f32, fastest));
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    for (at, align, text) in [
        (bar.left_bottom(), egui::Align2::LEFT_TOP, "0".to_owned()),
        (bar.right_bottom(), egui::Align2::RIGHT_TOP, format!("{fastest:.0} cm/s")),
    ] {
        ui.painter().text(at + egui::vec2(1.0, 3.0), align, &text, font.clone(), Color32::from_black_alpha(190));
        ui.painter().text(at + egui::vec2(0.0, 2.0), align, &text, font.clone(), super::theme::TEXT);
    }
}

#[cfg(test)]
mod tests {
    use lorelei_core::simulation::SimulationSettings;
    use lorelei_sim::wind::FreeAir;

    use super::*;

    fn steady() -> AirGrid {
        let settings = SimulationSettings { wind_speed: 100.0, ..SimulationSettings::default() };
        AirGrid::of_free(FreeAir::new(&settings, 0.0))
    }

    #[test]
    fn tracers_go_with_the_wind_and_stay_in_the_box() {
        let air = steady();
        let space = Space::new(&air, (Vec3::splat(-10.0), Vec3::splat(10.0)));
        let mut smoke = Smoke::default();
        for frame in 0..60 {
            smoke.advance(&air, &space, &[], frame as f32 / 60.0);
        }
        let mut n_trails = 0;
        for tracer in smoke.tracers.iter().filter(|tracer| tracer.trail.len() > 1) {
            assert!(tracer.trail.iter().all(|&p| space.holds(p)));
            let way = *tracer.trail.back().unwrap() - tracer.trail[0];
            let secs = (tracer.trail.len() - 1) as f32 * STEP_SECS;
            assert!((way / secs).distance(air.free.steady) < 1.0, "{way}");
            n_trails += 1;
        }
        assert!(n_trails > 300, "{n_trails}");
        // Time that goes back starts anew.
        smoke.advance(&air, &space, &[], 0.0);
        assert!(smoke.tracers.iter().all(|tracer| tracer.trail.is_empty()));
    }

    #[test]
    fn colours_end_at_the_fastest_source_that_blows_in_the_box_wherever_it_stands() {
        let fan = WindSource {
            place: Vec3::X * 60.0,
            direction: Vec3::NEG_X,
            speed: 600.0,
            radius: 8.0,
            ..WindSource::default()
        };
        let ends_at = |sources: Vec<WindSource>| {
            let settings = SimulationSettings { wind_speed: 100.0, sources, ..SimulationSettings::default() };
            let air = AirGrid::of_free(FreeAir::new(&settings, 0.0));
            let space = Space::new(&air, (Vec3::splat(-10.0), Vec3::splat(10.0)));
            fastest_of(&air, &space, &settings.sources)
        };
        assert_eq!(ends_at(vec![fan.clone()]), 600.0);
        let off = WindSource { on: false, ..fan.clone() };
        let away = WindSource { direction: Vec3::X, speed: 900.0, ..fan.clone() };
        assert_eq!(ends_at(vec![off.clone(), away.clone()]), 130.0);
        assert_eq!(ends_at(vec![off, away, fan]), 600.0, "those that are off have no place among the streams");
    }

    #[test]
    fn smoke_begins_upwind_or_at_a_source() {
        let air = steady();
        let space = Space::new(&air, (Vec3::splat(-10.0), Vec3::splat(10.0)));
        let mean = (0..200).map(|n| born(n, &air, &space, &[]).x).sum::<f32>() / 200.0;
        assert!(mean < -5.0, "{mean}");
        let fans = [WindSource { place: Vec3::new(3.0, 2.0, 1.0), radius: 2.0, ..WindSource::default() }];
        let at_fan = (0..200).filter(|&n| born(n, &air, &space, &fans).distance(fans[0].place) <= 2.001).count();
        assert!((80..160).contains(&at_fan), "{at_fan}");
    }
}
