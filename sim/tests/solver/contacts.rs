//! Hair keeps out of what it is to keep out of, however fast either goes.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::collider::{Attachment, Collider};
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::HeadPose;
use lorelei_core::simulation::{Pearl, SimulationSettings};
use lorelei_sim::CpuSolver;
use lorelei_sim::laws::scenes::{ball_field, draped};

/// Eight strands of 30 cm that hang side by side from (0, 0, z).
fn curtain(n_vertices: u32) -> GuideSet {
    let at = |g: u32, k: u32| Vec3::new(0.0, -30.0 * k as f32 / (n_vertices - 1) as f32, 0.5 * g as f32);
    GuideSet { n_vertices, positions: (0..8).flat_map(|g| (0..n_vertices).map(move |k| at(g, k))).collect() }
}

/// A rod across the curtain at x = 6, y = -14, in the world.
fn rod(radius: f32) -> Collider {
    let ends = [Vec3::new(6.0, -14.0, -20.0), Vec3::new(6.0, -14.0, 24.0)];
    Collider { attached: Attachment::World, ..Collider::capsule("rod", ends, [radius; 2]) }
}

/// How often each strand goes around the rod at (x, -14), from root to tip, in turns.
fn turns(solver: &CpuSolver, n_vertices: usize, x: f32) -> Vec<f32> {
    let of_edge = |edge: &[Vec4]| {
        let [a, b] = [edge[0], edge[1]].map(|p| Vec2::new(p.x - x, p.y + 14.0));
        a.angle_to(b) / std::f32::consts::TAU
    };
    solver.positions(0).chunks(n_vertices).map(|strand| strand.windows(2).map(of_edge).sum()).collect()
}

#[test]
fn fast_hair_does_not_go_through_a_rod() {
    for (radius, pearl, cm_s) in [
        (2.0, Pearl::Off, 3000.0),
        (2.0, Pearl::Off, 1000.0),
        (1.0, Pearl::Off, 600.0),
        (0.5, Pearl::Growing, 600.0),
        (0.3, Pearl::Growing, 300.0),
    ] {
        let settings = SimulationSettings {
            colliders: vec![rod(radius)],
            pearl,
            pearl_radius: 1.2,
            ..SimulationSettings::default()
        };
        let guides = curtain(32);
        let mut solver = CpuSolver::new(&[&guides], None, &settings);
        // All of it flies to the right; the roots stay. A rod of 0.5 cm is passed at 1000 cm/s: between two steps an edge
        // of the strand is on its other side, and only vertices are marched.
        let before: Vec<Vec3> = guides.positions.iter().map(|&p| p - Vec3::X * cm_s / 240.0).collect();
        solver.set_state(0, &guides.positions, &before);
        let mut wound = turns(&solver, 32, 6.0);
        let mut n_through = 0;
        let mut farthest = 0.0_f32;
        for _ in 0..480 {
            solver.step_once();
            let now = turns(&solver, 32, 6.0);
            // What goes through changes sides at once.
            n_through += now.iter().zip(&wound).filter(|(now, before)| (*now - *before).abs() > 0.5).count();
            wound = now;
            farthest = wound.iter().fold(farthest, |far, turns| far.max(turns.abs()));
        }
        let settled = solver.measure();
        println!("radius {radius}: {n_through} through, {farthest} turns, {settled:?}");
        assert_eq!(n_through, 0, "radius {radius}, {cm_s} cm/s");
        assert!(settled.length_error_max < 0.01 && settled.penetration_max_cm < 0.1, "{settled:?}");
    }
}

#[test]
fn a_collider_that_the_mouse_drags_takes_hair_along() {
    for (radius, pearl) in [(2.0, Pearl::Off), (0.5, Pearl::Growing)] {
        let mut settings = SimulationSettings {
            colliders: vec![rod(radius)],
            pearl,
            pearl_radius: 1.2,
            ..SimulationSettings::default()
        };
        let guides = curtain(32);
        let mut solver = CpuSolver::new(&[&guides], None, &settings);
        // From the right to the left through where hair hangs, 4 cm a frame, 240 cm/s.
        let mut leftmost = 0.0_f32;
        for frame in 0..12 {
            if frame < 3 {
                settings.colliders[0].shift(Vec3::NEG_X * 4.0);
                solver.set_settings(&settings);
            }
            solver.advance(1.0 / 60.0);
            leftmost = solver.positions(0).iter().map(|x| x.x).fold(leftmost, f32::min);
        }
        println!("radius {radius}: {leftmost} cm");
        assert!(leftmost < -7.0, "radius {radius}: hair was passed through, it came to {leftmost} cm");
    }
}

#[test]
fn a_thrown_head_keeps_its_hair_out() {
    let field = ball_field();
    let guides = draped(24, 32, 30.0, 0.2);
    let mut deepest = 0.0_f32;
    let mut solver = CpuSolver::new(&[&guides], Some(&field), &SimulationSettings::default());
    for frame in 0..240 {
        let t = frame as f32 / 240.0;
        // To and fro by 40 cm, 3000 cm/s at its fastest.
        let shift = Vec3::new(20.0 * (150.0 * t).sin(), 0.0, 0.0) * (8.0 * t).min(1.0);
        solver.set_head_pose(&HeadPose { shift, ..HeadPose::default() }.world_from_head(Vec3::NEG_Y * 8.0));
        solver.advance(1.0 / 240.0);
        deepest = deepest.max(solver.measure().penetration_max_cm);
    }
    for _ in 0..240 {
        solver.advance(1.0 / 60.0);
    }
    let settled = solver.measure();
    println!("while thrown {deepest} cm, settled {settled:?}");
    assert!(settled.penetration_max_cm < 0.1 && settled.n_not_finite == 0, "{settled:?}");
    // Measured 0.
    assert!(deepest < 0.1, "{deepest} cm");
}

#[test]
fn with_pearls_rest_stays_and_a_lock_keeps_its_thickness() {
    let field = ball_field();
    let guides = draped(16, 24, 20.0, 0.0);
    let nearest = |pearl: Pearl| {
        let settings =
            SimulationSettings { pearl, pearl_radius: 1.0, bend_length: 0.3, hold: 0.5, ..Default::default() };
        let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
        for _ in 0..60 {
            solver.advance(1.0 / 60.0);
        }
        assert!(solver.measure().speed_max < 1e-4, "{:?}", solver.measure());
        // Lie on the back: the hair of the front falls onto the face.
        for frame in 0..240 {
            let pose = HeadPose { pitch: -1.2 * (frame as f32 / 60.0).min(1.0), ..HeadPose::default() };
            solver.set_head_pose(&pose.world_from_head(Vec3::NEG_Y * 8.0));
            solver.advance(1.0 / 60.0);
        }
        let pose = HeadPose { pitch: -1.2, ..HeadPose::default() }.world_from_head(Vec3::NEG_Y * 8.0).inverse();
        let distance = |x: &Vec4| field.sample(pose.transform_point3(x.xyz()));
        let far = |k: usize, x: &Vec4| (k % 24 > 12).then(|| distance(x));
        solver.positions(0).iter().enumerate().filter_map(|(k, x)| far(k, x)).fold(f32::INFINITY, f32::min)
    };
    let (thin, thick) = (nearest(Pearl::Off), nearest(Pearl::Growing));
    println!("{thin} cm, with pearls {thick} cm");
    assert!(thick > 0.4 && thick > thin + 0.2, "{thin} cm, with pearls {thick} cm");
}
