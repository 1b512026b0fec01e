//! A hand that holds hair: it comes along, keeps its lengths, and is let go of without a trace.

use glam::{Affine3A, Vec3, Vec4Swizzles};
use lorelei_core::guides::GuideSet;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::{SimulationSettings, Solver};
use lorelei_sim::laws::scenes::{ball_field, draped};
use lorelei_sim::{CpuSolver, Pull};

use crate::twins::Twins;

const N: usize = 24;

fn hair() -> GuideSet {
    draped(240, N as u32, 24.0, 0.0)
}

/// The 17th vertex of the guide that rests the farthest to the right.
fn grabbed(guides: &GuideSet) -> usize {
    let n_guides = guides.positions.len() / N;
    let x = |g: usize| guides.positions[g * N + 16].x;
    let rightmost = (0..n_guides).max_by(|a, b| x(*a).total_cmp(&x(*b))).unwrap();
    rightmost * N + 16
}

fn settings(solver: Solver) -> SimulationSettings {
    SimulationSettings { solver, ..SimulationSettings::default() }
}

#[test]
fn held_hair_comes_to_the_hand_its_neighbours_follow_and_the_rest_stays() {
    for solver in [Solver::Rods, Solver::Chains] {
        let guides = hair();
        let vertex_idx = grabbed(&guides);
        let mut cpu = CpuSolver::new(&[&guides], Some(&ball_field()), &settings(solver));
        let before: Vec<Vec3> = cpu.positions(0).iter().map(|x| x.xyz()).collect();
        let held = Pull::of_vertex(&guides, vertex_idx).unwrap();
        let hand = held.rest + Vec3::new(3.0, 3.0, 0.0);
        cpu.set_pull(Some(Pull { hand, radius: 4.0, ..held }));
        let mut stretched = 0.0_f32;
        for _ in 0..120 {
            cpu.advance(1.0 / 60.0);
            stretched = stretched.max(cpu.measure().length_error_max);
        }
        let now: Vec<Vec3> = cpu.positions(0).iter().map(|x| x.xyz()).collect();
        let moved = |g: usize| now[g * N + 16].distance(before[g * N + 16]);
        let beside = |g: usize| guides.positions[g * N + 16].distance(held.rest);
        let away = now[vertex_idx].distance(hand);
        let was_away = before[vertex_idx].distance(hand);
        let near = (0..240).filter(|g| beside(*g) > 0.01 && beside(*g) < 2.0).map(moved).fold(f32::MAX, f32::min);
        let far = (0..240).filter(|g| beside(*g) > 6.0).map(moved).fold(0.0, f32::max);
        println!("{solver:?}: {away} cm from the hand, near {near}, far {far}, stretched {stretched}");
        // The shape of a chain is put back after the hand's step, and holds against it.
        let farthest = if solver == Solver::Rods { 0.6 } else { 1.7 };
        assert!(away < farthest, "{solver:?}: {away} cm from the hand, {was_away} before");
        assert!(near > 1.0 && near < 100.0 && far < 0.3, "{solver:?}: near {near}, far {far}");
        assert!(stretched < 1e-3, "{solver:?}: {stretched}");
    }
}

#[test]
fn a_hand_out_of_reach_at_infinity_or_jerked_neither_stretches_nor_breaks_hair() {
    for solver in [Solver::Rods, Solver::Chains] {
        let guides = draped(60, N as u32, 24.0, 0.0);
        let held = Pull::of_vertex(&guides, grabbed(&guides)).unwrap();
        let mut cpu = CpuSolver::new(&[&guides], Some(&ball_field()), &settings(solver));
        let hands = [Vec3::new(500.0, 0.0, 0.0), Vec3::NAN, Vec3::INFINITY, Vec3::ZERO, held.root, Vec3::NEG_X * 30.0];
        let mut worst = (0.0_f32, 0.0_f32);
        for frame in 0..240 {
            let hand = hands[frame / 2 % hands.len()];
            let (radius, strength) = [(2.0, 2000.0), (0.0, 1e30), (f32::NAN, 1.0), (30.0, 1e5)][frame / 7 % 4];
            cpu.set_pull(Some(Pull { hand, radius, strength, ..held }));
            cpu.set_head_pose(&Motion::Shake.pose(frame as f32 / 60.0, Vec3::NEG_Y * 8.0));
            cpu.advance(1.0 / 60.0);
            let now = cpu.measure();
            assert_eq!(now.n_not_finite, 0, "{solver:?}, frame {frame}");
            worst = (worst.0.max(now.length_error_max), worst.1.max(now.penetration_max_cm));
        }
        println!("{solver:?}: {worst:?}");
        let longest = if solver == Solver::Rods { 2e-3 } else { 0.3 };
        assert!(worst.0 < longest && worst.1 < 1.0, "{solver:?}: {worst:?}");
        // Let go of, it comes to rest as if nothing had been.
        cpu.set_head_pose(&Affine3A::IDENTITY);
        cpu.set_pull(None);
        for _ in 0..600 {
            cpu.advance(1.0 / 60.0);
        }
        assert!(cpu.measure().speed_max < 1.0, "{solver:?}: {:?}", cpu.measure());
    }
}

#[test]
fn pinned_vertices_and_none_cannot_be_held() {
    let guides = hair();
    assert!(Pull::of_vertex(&guides, N + 1).is_none() && Pull::of_vertex(&guides, 240 * N).is_none());
    assert!(Pull::of_vertex(&GuideSet::default(), 0).is_none());
    let held = Pull::of_vertex(&guides, 2 * N - 1).unwrap();
    assert!((held.along, held.root) == (1.0, guides.positions[N]) && (held.reach - 24.0).abs() < 1e-3);
}

#[test]
fn twins_agree_under_a_pull() {
    for solver in [Solver::Rods, Solver::Chains] {
        let (long, short) = (hair(), draped(33, 8, 20.0, 0.3));
        let held = Pull::of_vertex(&long, grabbed(&long)).unwrap();
        let mut twins = Twins::new(&[&long, &short], &settings(solver));
        for frame in 1..=6 {
            let hand = held.rest + Vec3::new(0.7, 0.3, 0.2) * frame as f32;
            let pull = Some(Pull { hand, radius: 6.0, ..held });
            twins.cpu_solver.set_pull(pull);
            twins.gpu_solver.set_pull(pull);
            twins.advance(1.0 / 60.0, &Motion::Turn.pose(frame as f32 / 60.0, Vec3::NEG_Y * 8.0));
            let apart = twins.farthest_apart(0).max(twins.farthest_apart(1));
            println!("{solver:?}, frame {frame}: {apart} cm");
            assert!(apart < 5e-4, "{solver:?}, frame {frame}: {apart} cm");
        }
        let moved = twins.cpu_solver.positions(0)[grabbed(&long)].xyz().distance(held.rest);
        assert!(moved > 1.0, "{moved}: the test shows nothing");
    }
}
