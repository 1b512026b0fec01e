//! What must hold for any groom and any head movement.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec3, Vec4Swizzles};
use lorelei_core::collider::Collider;
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::{HeadPose, Motion};
use lorelei_core::simulation::{Pearl, SimulationSettings};
use lorelei_sim::{CpuSolver, Measure};

use crate::grooms::{ball_field, draped};

const PIVOT: Vec3 = Vec3::new(0.0, -8.0, -1.0);

fn grooms() -> [(&'static str, GuideSet); 4] {
    [
        ("long", draped(16, 32, 35.0, 0.0)),
        ("curly", draped(16, 32, 25.0, 0.5)),
        ("coils", draped(16, 32, 15.0, 0.5)),
        ("short", draped(16, 12, 6.0, 0.0)),
    ]
}

/// Twice as wide and nearly twice as fast as the preset: nobody shakes a head like that.
fn violent_shake(t: f32) -> Affine3A {
    let swell = (t / 0.3).min(1.0);
    HeadPose { yaw: 0.6 * swell * (TAU * 2.5 * t).sin(), ..HeadPose::default() }.world_from_head(PIVOT)
}

fn run(solver: &mut CpuSolver, secs: f32, frames_per_second: f32, pose: impl Fn(f32) -> Affine3A) -> Vec<Measure> {
    (1..=(secs * frames_per_second).round() as u32)
        .map(|frame| {
            solver.set_head_pose(&pose(frame as f32 / frames_per_second));
            solver.advance(1.0 / frames_per_second);
            solver.measure()
        })
        .collect()
}

#[test]
fn a_groom_at_rest_stays_to_the_last_bit() {
    let field = ball_field();
    for (name, guides) in grooms() {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
        let last = *run(&mut solver, 2.0, 60.0, |_| Affine3A::IDENTITY).last().unwrap();
        assert_eq!((last.speed_max, last.from_rest_rms_cm), (0.0, 0.0), "{name}");
        assert!(solver.positions(0).iter().zip(&guides.positions).all(|(x, rest)| x.xyz() == *rest), "{name}");
    }
}

#[test]
fn a_groom_on_a_turned_head_stays_too() {
    let field = ball_field();
    let turned = HeadPose { yaw: 1.0, shift: Vec3::new(3.0, 40.0, -7.0), ..HeadPose::default() }.world_from_head(PIVOT);
    for (name, guides) in grooms() {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
        solver.set_head_pose(&turned);
        solver.reset();
        let last = *run(&mut solver, 2.0, 60.0, |_| turned).last().unwrap();
        // Rounding of coordinates around 60 cm moves a vertex by 4e-6 cm in a step of 1/240 s.
        assert!(last.from_rest_rms_cm < 1e-3 && last.speed_max < 1e-2, "{name}: {last:?}");
    }
}

#[test]
fn lengths_hold_in_a_violent_shake() {
    let field = ball_field();
    for (name, guides) in grooms() {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
        for measure in run(&mut solver, 2.0, 60.0, violent_shake) {
            assert!(measure.length_error_rms < 1e-4 && measure.n_not_finite == 0, "{name}: {measure:?}");
        }
    }
}

#[test]
fn hair_swings_and_settles_where_it_was() {
    let field = ball_field();
    for (name, guides) in grooms() {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
        let shaken = run(&mut solver, 2.3, 60.0, |t| Motion::Shake.pose(t, PIVOT));
        let farthest = shaken.iter().map(|m| m.from_rest_rms_cm).fold(0.0, f32::max);
        let settled = *run(&mut solver, 2.0, 60.0, |_| Affine3A::IDENTITY).last().unwrap();
        println!("{name}: {farthest} cm, then {settled:?}");
        assert!(farthest > if name == "short" { 0.1 } else { 3.0 }, "{name} follows stiffly: {farthest} cm");
        assert!(settled.from_rest_rms_cm < 1.0 && settled.kinetic_energy < 20.0, "{name}: {settled:?}");
        let later = *run(&mut solver, 4.0, 60.0, |_| Affine3A::IDENTITY).last().unwrap();
        println!("{name}: later {later:?}");
        assert!(later.speed_max < 0.1, "{name} jitters: {later:?}");
        assert!(later.penetration_max_cm < 0.1, "{name}: {later:?}");
    }
}

#[test]
fn every_motion_keeps_hair_out_of_the_head() {
    let field = ball_field();
    for (name, guides) in grooms() {
        for motion in [Motion::Turn, Motion::Nod, Motion::Shake] {
            let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
            for measure in run(&mut solver, motion.period_secs(), 60.0, |t| motion.pose(t, PIVOT)) {
                assert!(measure.penetration_max_cm < 0.1, "{name} {motion:?}: {measure:?}");
                assert!(measure.speed_max < 1000.0, "{name} {motion:?}: {measure:?}");
            }
        }
    }
}

#[test]
fn the_frame_rate_does_not_show() {
    let guides = draped(8, 24, 25.0, 0.2);
    let field = ball_field();
    let settings = SimulationSettings { wind_speed: 300.0, ..SimulationSettings::default() };
    let after = |frames_per_second: f32, pose: &dyn Fn(f32) -> Affine3A| {
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
        run(&mut solver, 1.0, frames_per_second, pose);
        solver.positions(0).to_vec()
    };
    // In wind, with the head at rest: the same steps, so the same bits.
    let still = |_| Affine3A::IDENTITY;
    assert_eq!(after(30.0, &still), after(60.0, &still));
    assert_eq!(after(60.0, &still), after(120.0, &still));
    // 144 frames a second do not end on a step: the picture goes ahead of it by less than one.
    let apart = |a: &[glam::Vec4], b: &[glam::Vec4]| {
        a.iter().zip(b).map(|(a, b)| a.xyz().distance(b.xyz())).fold(0.0, f32::max)
    };
    assert!(apart(&after(144.0, &still), &after(60.0, &still)) < 0.01);
    // Turning: the pose between frames is interpolated, which cuts the corners of the movement.
    let turn = |t| Motion::Turn.pose(t, PIVOT);
    let reference = after(240.0, &turn);
    for frames_per_second in [30.0, 60.0, 144.0] {
        let error = apart(&after(frames_per_second, &turn), &reference);
        // 2 % of the length of 25 cm.
        assert!(error < 0.5, "{frames_per_second}: {error} cm");
    }
}

#[test]
fn step_rate_and_iterations_hardly_change_where_wind_holds_the_hair() {
    let guides = draped(8, 32, 30.0, 0.0);
    let field = ball_field();
    let held = |steps_per_second: f32, n_iterations: u32| {
        let settings =
            SimulationSettings { wind_speed: 300.0, steps_per_second, n_iterations, ..SimulationSettings::default() };
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
        run(&mut solver, 5.0, 30.0, |_| Affine3A::IDENTITY);
        solver.positions(0).to_vec()
    };
    let reference = held(240.0, 2);
    for (steps_per_second, n_iterations) in [(120.0, 2), (480.0, 2), (240.0, 1), (240.0, 4)] {
        let other = held(steps_per_second, n_iterations);
        let error = reference.iter().zip(&other).map(|(a, b)| a.xyz().distance_squared(b.xyz())).sum::<f32>();
        let rms = (error / reference.len() as f32).sqrt();
        println!("{steps_per_second} Hz, {n_iterations} iterations: {rms} cm");
        // 2 % of the length of 30 cm.
        assert!(rms < 0.6, "{steps_per_second} Hz, {n_iterations} iterations: {rms} cm");
    }
}

#[test]
fn wind_lifts_hair_and_the_hair_comes_back() {
    let guides = draped(16, 32, 30.0, 0.0);
    let field = ball_field();
    let mut settings = SimulationSettings { wind_speed: 500.0, wind_azimuth_deg: 90.0, ..Default::default() };
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
    let blown = *run(&mut solver, 3.0, 60.0, |_| Affine3A::IDENTITY).last().unwrap();
    assert!(blown.from_rest_rms_cm > 3.0 && blown.penetration_max_cm < 0.1, "{blown:?}");
    let tip = |solver: &CpuSolver| solver.positions(0).iter().map(|x| x.x).sum::<f32>();
    let leeward = tip(&solver);
    settings.wind_speed = 0.0;
    solver.set_settings(&settings);
    let calm = *run(&mut solver, 4.0, 60.0, |_| Affine3A::IDENTITY).last().unwrap();
    assert!(leeward > tip(&solver) && calm.from_rest_rms_cm < 0.5, "{calm:?}");
}

#[test]
fn a_long_lock_swings_like_a_pendulum_of_its_length() {
    // Free of everything but gravity: 30 cm hanging straight, let go from 10 degrees.
    let n = 32;
    let positions: Vec<Vec3> = (0..n).map(|k| Vec3::NEG_Y * (30.0 * k as f32 / (n - 1) as f32)).collect();
    let guides = GuideSet { n_vertices: n, positions: positions.clone() };
    let settings = SimulationSettings { damping: 0.0, drag: 0.0, hold: 0.0, bend_length: 1.0, ..Default::default() };
    let mut solver = CpuSolver::new(&[&guides], None, &settings);
    let aside: Vec<Vec3> = positions.iter().map(|&p| Quat::from_rotation_z(0.17) * p).collect();
    solver.set_state(0, &aside, &aside);
    let mut crossings = Vec::new();
    let mut before = solver.positions(0)[n as usize - 1].x;
    for frame in 0..480 {
        solver.advance(1.0 / 120.0);
        let x = solver.positions(0)[n as usize - 1].x;
        if (x > 0.0) != (before > 0.0) {
            crossings.push(frame as f32 / 120.0);
        }
        before = x;
    }
    let half_period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f32;
    // A hanging chain swings at 1.2024 sqrt(g / l) = 6.9 rad/s, half a period of 0.457 s.
    println!("half a period: {half_period} s");
    assert!((0.3..0.6).contains(&half_period), "{half_period} s");
}

#[test]
fn nothing_breaks_it() {
    let field = ball_field();
    let mut awkward = draped(8, 16, 12.0, 0.0);
    // A strand in the middle of the head, one at a single point, one of NaN, one that turns back on itself.
    for k in 0..16 {
        awkward.positions[k] = Vec3::new(0.01 * k as f32, 0.0, 0.0);
        awkward.positions[16 + k] = Vec3::new(0.0, 9.0, 0.0);
        awkward.positions[32 + k] = Vec3::NAN;
        awkward.positions[48 + k] = Vec3::new(0.0, 9.0 + (k % 2) as f32, 0.0);
    }
    let wild = SimulationSettings {
        gravity: f32::NAN,
        damping: f32::INFINITY,
        bend_length: 1e30,
        hold: -5.0,
        wind_speed: 1e30,
        steps_per_second: 0.0,
        n_iterations: 0,
        colliders: vec![
            Collider::sphere("ball", Vec3::new(0.0, -12.0, 0.0), 5.0),
            Collider::sphere("none", Vec3::NAN, f32::NAN),
        ],
        pearl: Pearl::Growing,
        pearl_radius: f32::NAN,
        ..SimulationSettings::default()
    };
    for settings in [SimulationSettings::default(), wild] {
        let mut solver = CpuSolver::new(&[&awkward], Some(&field), &settings);
        for frame in 0..240 {
            let t = frame as f32 / 60.0;
            let pose = match frame % 48 {
                11 => Affine3A::from_translation(Vec3::splat(1e4)),
                23 => Affine3A::from_rotation_x(3.0),
                35 => Affine3A::from_translation(Vec3::NAN),
                _ => violent_shake(t),
            };
            solver.set_head_pose(&pose);
            solver.advance([1.0 / 60.0, 0.0, 1e9, f32::NAN][frame % 4]);
            assert_eq!(solver.measure().n_not_finite, 0, "frame {frame}");
        }
    }
    let empty = GuideSet::default();
    let mut solver = CpuSolver::new(&[&empty], None, &SimulationSettings::default());
    solver.advance(0.1);
    assert!(solver.positions(0).is_empty());
}

#[test]
fn it_recovers_from_a_teleport_and_from_any_state() {
    let field = ball_field();
    let guides = draped(8, 24, 20.0, 0.3);
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
    let far = Affine3A::from_translation(Vec3::new(500.0, 100.0, 0.0));
    let carried = run(&mut solver, 0.1, 60.0, |_| far);
    assert!(carried.last().unwrap().from_rest_rms_cm < 0.01, "{carried:?}");
    // Everything at one point inside the head.
    let crushed = vec![Vec3::new(500.0, 100.0, 0.0); guides.positions.len()];
    solver.set_state(0, &crushed, &crushed);
    let last = *run(&mut solver, 6.0, 60.0, |_| far).last().unwrap();
    assert!(last.length_error_max < 0.01 && last.penetration_max_cm < 0.1 && last.n_not_finite == 0, "{last:?}");
}

#[test]
fn reset_is_rest_to_the_last_bit() {
    let field = ball_field();
    let guides = draped(8, 24, 20.0, 0.3);
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
    run(&mut solver, 0.7, 60.0, violent_shake);
    solver.set_head_pose(&Affine3A::IDENTITY);
    solver.reset();
    assert!(solver.positions(0).iter().zip(&guides.positions).all(|(x, rest)| x.xyz() == *rest));
}

#[test]
fn spheres_push_and_leave() {
    let guides = draped(16, 32, 30.0, 0.0);
    let mut settings = SimulationSettings::default();
    let mut solver = CpuSolver::new(&[&guides], None, &settings);
    // A ball dropped where hair hangs; hair that rests inside of it stays.
    let ball = Collider::sphere("ball", Vec3::new(14.0, -10.0, 0.0), 4.0);
    settings.colliders = vec![Collider { keeps_rest: true, ..ball }];
    solver.set_settings(&settings);
    let pushed = *run(&mut solver, 2.0, 60.0, |t| {
        HeadPose { shift: Vec3::X * (2.0 * (3.0 * t).sin()), ..Default::default() }.world_from_head(PIVOT)
    })
    .last()
    .unwrap();
    assert!(pushed.penetration_max_cm < 0.1 && pushed.length_error_max < 0.01, "{pushed:?}");
}

#[test]
fn a_bowed_head_lets_hair_fall_to_where_down_is() {
    let field = ball_field();
    let guides = draped(16, 32, 30.0, 0.0);
    let bowed = HeadPose { pitch: 0.6, ..HeadPose::default() }.world_from_head(PIVOT);
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
    let bow = |t: f32| HeadPose { pitch: 0.6 * t.min(1.0), ..HeadPose::default() }.world_from_head(PIVOT);
    run(&mut solver, 4.0, 60.0, bow);
    // Tips against where a rigid wig would have them: as far below as gravity can pull them.
    let tips = (0..guides.n_guides()).map(|g| (g + 1) * 32 - 1);
    let fallen =
        tips.map(|tip| bowed.transform_point3(guides.positions[tip]).y - solver.positions(0)[tip].y).sum::<f32>()
            / guides.n_guides() as f32;
    println!("tips fell {fallen} cm");
    assert!(fallen > 0.5, "{fallen} cm");
}

#[test]
fn the_picture_is_still_in_a_steady_breeze_at_any_frame_rate() {
    let field = ball_field();
    let guides = draped(16, 24, 16.0, 0.1);
    let settings = SimulationSettings { wind_speed: 300.0, ..SimulationSettings::default() };
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
    run(&mut solver, 6.0, 60.0, |_| Affine3A::IDENTITY);
    let mut before = solver.positions(0).to_vec();
    for frame in 0..30 {
        solver.advance(1.0 / 144.0);
        let moved = solver.positions(0).iter().zip(&before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        // A hair's own width is 0.008 cm.
        assert!(moved < 0.008, "frame {frame}: {moved} cm");
        before = solver.positions(0).to_vec();
    }
}
