//! Hair against hair keeps the room that hair takes, and leaves a groom at rest alone.

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::{Moved, SimulationSettings, Solver, Volume};
use lorelei_sim::CpuSolver;
use lorelei_sim::laws::scenes::{PIVOT, ball_field, draped};
use lorelei_sim::laws::{On, Under, rest};

const UNDER: Under<'static> = Under { on: &On::Cpu, solver: Solver::Rods };

fn settings(volume: Volume) -> SimulationSettings {
    SimulationSettings { volume, hold: 1.0, bend_length: 0.6, ..SimulationSettings::default() }
}

/// Room that hair takes: cells of two centimetres that hold a vertex, in cm3.
fn room(solver: &CpuSolver) -> usize {
    let cell = |x: &Vec4| (0.5 * x.xyz()).floor().as_ivec3();
    8 * solver.positions(0).iter().map(cell).collect::<std::collections::HashSet<_>>().len()
}

#[test]
fn curly_hair_that_is_pressed_together_keeps_its_volume() {
    let field = ball_field();
    let guides = draped(150, 24, 22.0, 0.5);
    let settled = |volume: Volume| {
        // A storm from above.
        let settings =
            SimulationSettings { wind_speed: 1500.0, wind_elevation_deg: -90.0, volume_push: 10.0, ..settings(volume) };
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
        for _ in 0..180 {
            solver.advance(1.0 / 60.0);
        }
        (room(&solver), solver.measure())
    };
    let ((without, _), (with, measured)) = (settled(Volume::Off), settled(Volume::Density));
    let rest = room(&CpuSolver::new(&[&guides], Some(&field), &settings(Volume::Off)));
    println!("at rest {rest} cm3, pressed {without} cm3, with density {with} cm3; {measured:?}");
    assert!(measured.length_error_max < 0.01 && measured.penetration_max_cm < 0.1, "{measured:?}");
    assert!(without < rest, "nothing presses: the test shows nothing");
    // At least a third of what is lost is kept.
    assert!(3 * (with - without) >= rest - without, "at rest {rest}, {without} without, {with} with");
}

#[test]
fn a_groom_at_rest_stays_at_rest_with_every_choice_on() {
    // Soft curls twist their joints by what they weigh: bent as far as they go, they still have to rest.
    for row in rest::curls_with(&UNDER, "soft and loose", &rest::soft(&UNDER), Volume::DensityVelocity).unwrap() {
        println!("{}, {}: {} {}", row.law, row.scene, row.value, row.unit);
        assert!(row.holds(), "{row:?}");
    }
}

#[test]
fn hair_that_was_shaken_comes_to_rest_where_it_was() {
    let field = ball_field();
    let guides = draped(60, 24, 22.0, 0.3);
    for volume in [Volume::Density, Volume::DensityVelocity] {
        let mut solver =
            CpuSolver::new(&[&guides], Some(&field), &SimulationSettings { volume, ..SimulationSettings::default() });
        for frame in 0..600 {
            let t = frame as f32 / 60.0;
            solver.set_head_pose(&if t < 2.0 { Motion::Shake.pose(t, PIVOT) } else { Affine3A::IDENTITY });
            solver.advance(1.0 / 60.0);
        }
        let last = solver.measure();
        println!("{volume:?}: {last:?}");
        assert!(last.speed_max < 1.0 && last.from_rest_rms_cm < 0.3, "{volume:?}: {last:?}");
    }
}

#[test]
fn hair_that_rubs_on_hair_moves_alike() {
    let n = 16_u32;
    // Two curtains through each other, one at rest, one that flies.
    let at = |g: u32, k: u32| Vec3::new(0.3 * (g % 2) as f32, -15.0 * k as f32 / (n - 1) as f32, 0.4 * (g / 2) as f32);
    let positions: Vec<Vec3> = (0..40).flat_map(|g| (0..n).map(move |k| at(g, k))).collect();
    let guides = GuideSet { n_vertices: n, positions: positions.clone() };
    let apart = |volume: Volume| {
        let settings = SimulationSettings { volume, volume_rub: 30.0, ..SimulationSettings::default() };
        let mut solver = CpuSolver::new(&[&guides], None, &settings);
        let flies = |i: usize| if (i / n as usize).is_multiple_of(2) { 1.0 } else { 0.0 };
        let prev: Vec<Vec3> = positions.iter().enumerate().map(|(i, &p)| p - 0.5 * flies(i) * Vec3::X).collect();
        solver.set_state(0, &positions, &prev);
        for _ in 0..6 {
            solver.advance(1.0 / 60.0);
        }
        let tip = |g: usize| solver.positions(0)[(g + 1) * n as usize - 1].x;
        (0..20).map(|pair| (tip(2 * pair) - tip(2 * pair + 1)).abs()).sum::<f32>() / 20.0
    };
    let (free, along) = (apart(Volume::Off), apart(Volume::DensityVelocity));
    println!("tips are {free} cm apart, {along} cm where they rub");
    assert!(along < 0.7 * free, "{free} {along}");
}

#[test]
fn the_same_frames_follow_from_the_same_state() {
    let field = ball_field();
    let guides = draped(60, 24, 22.0, 0.5);
    let frames = || {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings(Volume::DensityVelocity));
        for frame in 0..90 {
            solver.set_head_pose(&Motion::Shake.pose(frame as f32 / 60.0, PIVOT));
            solver.advance(1.0 / 60.0);
        }
        solver.positions(0).to_vec()
    };
    assert_eq!(frames(), frames());
}

/// Way that hair above the seam is pushed in a frame, cm: a brush with twice as many guides on its right is pressed flat.
fn pushed_over_the_seam(moved: Moved) -> Vec3 {
    let n = 8_u32;
    let root = |x: f32, z: u32| Vec3::new(x, 0.0, 0.5 * z as f32);
    let sparse = (0..12).flat_map(|i| (0..48).map(move |z| root(-0.5 - i as f32, z)));
    let dense = (0..24).flat_map(|i| (0..48).map(move |z| root(0.25 + 0.5 * i as f32, z)));
    let roots: Vec<Vec3> = sparse.chain(dense).collect();
    let brush = |height: f32| -> Vec<Vec3> {
        let guide = |&root: &Vec3| (0..n).map(move |k| root + height * k as f32 / (n - 1) as f32 * Vec3::Y);
        roots.iter().flat_map(guide).collect()
    };
    let guides = GuideSet { n_vertices: n, positions: brush(6.0) };
    let pressed = brush(3.0);
    let after = |volume: Volume| {
        let settings = SimulationSettings { volume, moved, volume_cells: 24, ..SimulationSettings::default() };
        let mut solver = CpuSolver::new(&[&guides], None, &settings);
        solver.set_state(0, &pressed, &pressed);
        solver.advance(1.0 / 60.0);
        solver.positions(0).to_vec()
    };
    let (without, with) = (after(Volume::Off), after(Volume::Density));
    // Away from the other rims.
    let is_over_seam = |idx: &usize| {
        let place = pressed[*idx];
        place.x.abs() < 2.0 && (6.0..18.0).contains(&place.z) && idx % n as usize >= 2
    };
    let ways: Vec<Vec3> =
        (0..pressed.len()).filter(is_over_seam).map(|idx| with[idx].xyz() - without[idx].xyz()).collect();
    ways.iter().sum::<Vec3>() / ways.len() as f32
}

#[test]
fn guides_that_stand_twice_as_dense_on_one_side_push_evenly() {
    // Every strand counts for itself: where there are more of them is more hair.
    let (even, uneven) = (pushed_over_the_seam(Moved::Guides), pushed_over_the_seam(Moved::Strands));
    println!("guides {even:?}, strands {uneven:?}");
    assert!(uneven.x < -0.01, "nothing pushes sideways: the test shows nothing, {uneven}");
    assert!(even.x.abs() < 0.25 * uneven.x.abs(), "guides {even}, strands {uneven}");
}
