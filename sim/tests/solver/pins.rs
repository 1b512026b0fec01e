//! What is pinned, and what is painted to be held, stays with the style while the rest moves.

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4Swizzles};
use lorelei_core::binding::{Tie, bind_layer};
use lorelei_core::guides::GuideSet;
use lorelei_core::look::Choice;
use lorelei_core::maps::{MapKind, ScalpMap};
use lorelei_core::motion::Motion;
use lorelei_core::moved::MovedHair;
use lorelei_core::pin::Pin;
use lorelei_core::simulation::{Moved, SimulationSettings, Solver};
use lorelei_sim::laws::scenes::draped;

use crate::moved::layer;
use crate::twins::Twins;

const SOLVERS: [Solver; 2] = [Solver::Rods, Solver::Chains];
/// What a pin lets hair move in it in a shake of the head, cm: the lag of its spring (measured 0.15, and 0.5 where a guide
/// barely touches the ball), and with chains what their lengths take it along (0.83).
fn most(solver: Solver) -> f32 {
    match solver {
        Solver::Rods => 0.6,
        Solver::Chains => 1.1,
    }
}

/// The head that is shaken.
fn shake(frame: u32) -> Affine3A {
    Motion::Shake.pose(frame as f32 / 60.0, Vec3::NEG_Y * 8.0)
}

/// How far hair came from its place on the head, cm: the farthest of `parts`, in frames `from..to` of a shake, on either
/// solver.
fn farthest(twins: &mut Twins, places: &[Vec3], (from, to): (u32, u32), parts: &[Vec<usize>]) -> Vec<f32> {
    let mut farthest = vec![0.0_f32; parts.len()];
    for frame in from..to {
        let pose = shake(frame);
        twins.advance(1.0 / 60.0, &pose);
        let on_gpu = twins.on_gpu(0, places.len());
        for (farthest, part) in farthest.iter_mut().zip(parts) {
            for &idx in part {
                let place = pose.transform_point3(places[idx]);
                let away = twins.cpu_solver.positions(0)[idx].xyz().distance(place).max(on_gpu[idx].distance(place));
                *farthest = farthest.max(away);
            }
        }
    }
    farthest
}

/// What lies in a pin, and the tips of the strands of which some does.
fn parts(pin: &Pin, guides: &GuideSet) -> [Vec<usize>; 2] {
    let n = guides.n_vertices as usize;
    let is_in = |p: &Vec3| p.distance(pin.centre) <= pin.radius;
    let held = (0..guides.positions.len()).filter(|idx| is_in(&guides.positions[*idx])).collect();
    let tips = guides.positions.chunks(n).enumerate().filter(|(_, strand)| strand.iter().any(is_in));
    [held, tips.map(|(guide_idx, _)| guide_idx * n + n - 1).collect()]
}

#[test]
fn what_lies_in_a_pin_keeps_its_place_while_the_tip_swings() {
    let guides = draped(12, 32, 30.0, 0.0);
    for solver in SOLVERS {
        let pin = Pin { centre: guides.guide(5)[14], radius: 1.2, ..Pin::default() };
        let parts = parts(&pin, &guides);
        let run = |on: bool| {
            let pins = vec![Pin { on, ..pin.clone() }];
            let mut twins =
                Twins::new(&[&guides], &SimulationSettings { solver, pins, ..SimulationSettings::default() });
            let farthest = farthest(&mut twins, &guides.positions, (1, 90), &parts);
            (farthest, twins.farthest_apart(0), twins.cpu_solver.measure())
        };
        let ((pinned, apart, measure), (free, ..)) = (run(true), run(false));
        println!("{solver:?}: pinned {pinned:?}, free {free:?}, twins {apart} cm apart, {measure:?}");
        assert!(pinned[0] < most(solver) && pinned[1] > 3.0, "{solver:?}: {pinned:?}");
        assert!(free[0] > 3.0 && free[1] > 3.0, "{solver:?}: {free:?}");
        assert!(apart < 0.05, "{solver:?}: twins are {apart} cm apart");
        assert!(measure.n_not_finite == 0 && measure.length_error_rms < 0.01, "{solver:?}: {measure:?}");
    }
}

#[test]
fn a_pin_that_is_dragged_lets_go_and_holds_where_it_is_now() {
    let guides = draped(12, 32, 30.0, 0.0);
    let pin = |guide_idx: usize| Pin { centre: guides.guide(guide_idx)[14], radius: 1.2, ..Pin::default() };
    let parts = [5, 8].map(|guide_idx| parts(&pin(guide_idx), &guides)[0].clone());
    for solver in SOLVERS {
        let mut settings = SimulationSettings { solver, pins: vec![pin(5)], ..SimulationSettings::default() };
        let mut twins = Twins::new(&[&guides], &settings);
        let before = farthest(&mut twins, &guides.positions, (1, 30), &parts);
        settings.pins[0].centre = pin(8).centre;
        twins.cpu_solver.set_settings(&settings);
        twins.gpu_solver.set_settings(&settings).unwrap();
        // A moment for what was free to come into the pin.
        farthest(&mut twins, &guides.positions, (30, 60), &parts);
        let after = farthest(&mut twins, &guides.positions, (60, 90), &parts);
        println!("{solver:?}: before {before:?}, after {after:?}");
        assert!(before[0] < most(solver) && before[1] > 2.0, "{solver:?}: {before:?}");
        assert!(after[1] < most(solver) && after[0] > 2.0, "{solver:?}: {after:?}");
    }
}

#[test]
fn whatever_is_moved_is_held_by_a_pin() {
    let binding = bind_layer(&layer(), None);
    for &moved in Moved::ALL {
        let hair = [MovedHair::new(moved, &layer(), &binding, None)];
        // Guides lie on chains and ropes, or beside them.
        let shown = if moved == Moved::Strands { &hair[0].curves } else { &binding.guides };
        let run = |pins: Vec<Pin>, parts: &[Vec<usize>]| {
            let mut twins = Twins::of_hair(&hair, &SimulationSettings { moved, pins, ..SimulationSettings::default() });
            farthest(&mut twins, &shown.positions, (1, 60), parts)
        };
        // In the middle of what swings the farthest. A rope is held by as much of its hair as lies in the pin.
        let n = shown.n_vertices as usize;
        let middles: Vec<Vec<usize>> = (0..shown.n_guides()).map(|guide_idx| vec![guide_idx * n + n / 2]).collect();
        let swings = run(Vec::new(), &middles);
        let guide_idx = (0..swings.len()).max_by(|a, b| swings[*a].total_cmp(&swings[*b])).unwrap();
        let radius = if moved == Moved::Rope { 7.0 } else { 2.0 };
        let pin = Pin { centre: shown.guide(guide_idx)[n / 2], radius, ..Pin::default() };
        let parts = parts(&pin, shown);
        let run = |on: bool| run(vec![Pin { on, ..pin.clone() }], &parts);
        let (pinned, free) = (run(true), run(false));
        println!("{moved:?}: pinned {pinned:?}, free {free:?}");
        assert!(
            pinned[0] < most(Solver::Rods) && 2.0 * pinned[0] < free[0],
            "{moved:?}: pinned {pinned:?}, free {free:?}"
        );
    }
}

#[test]
fn hair_that_is_painted_to_be_held_moves_less_than_half_as_far() {
    let guides = draped(12, 32, 30.0, 0.0);
    let tips: Vec<usize> = (0..12).map(|guide_idx| guide_idx * 32 + 31).collect();
    for solver in SOLVERS {
        let run = |hold: f32| {
            let mut hair = MovedHair::of_guides(&[&guides]);
            hair[0].ties = vec![Tie { hold, ..Tie::default() }; 12];
            let settings = SimulationSettings { solver, hold: 6.0, ..SimulationSettings::default() };
            let mut twins = Twins::of_hair(&hair, &settings);
            farthest(&mut twins, &guides.positions, (1, 90), std::slice::from_ref(&tips))[0]
        };
        let (held, half, free) = (run(1.0), run(0.5), run(0.0));
        println!("{solver:?}: held {held}, half {half}, free {free}");
        assert!(2.0 * held < free && held < half && half < free, "{solver:?}: {held}, {half}, {free}");
    }
}

#[test]
fn a_painted_hold_reaches_whatever_is_moved() {
    let mut layer = layer();
    layer.maps.insert(MapKind::Hold, Arc::new(ScalpMap::filled(4, 4, 204)));
    let mut binding = bind_layer(&layer, None);
    // Without a head there are no places on its maps: the roots are put on one.
    binding.root_uvs = vec![[0.5, 0.5]; binding.n_strands()];
    binding.resample_maps(&layer);
    for &moved in Moved::ALL {
        let hair = MovedHair::new(moved, &layer, &binding, None);
        assert_eq!(hair.ties, hair.ties_of(&binding), "{moved:?}");
        assert_eq!(hair.ties.len(), hair.curves.n_guides(), "{moved:?}");
        let is_held = |tie: &Tie| (tie.hold - 0.8).abs() < 1e-5 && (tie.tied - 0.1).abs() < 1e-5;
        assert!(hair.ties.iter().any(is_held), "{moved:?}: {:?}", hair.ties);
    }
}

#[test]
fn pinned_and_held_hair_rests_to_the_last_bit() {
    let guides = draped(12, 24, 20.0, 0.3);
    let mut hair = MovedHair::of_guides(&[&guides]);
    hair[0].ties = vec![Tie { tied: 0.1, hold: 0.7 }; 12];
    let pins = vec![
        Pin { centre: guides.guide(3)[9], ..Pin::default() },
        Pin { centre: guides.guide(7)[20], radius: 3.0, ..Pin::default() },
    ];
    for solver in SOLVERS {
        let settings = SimulationSettings { solver, pins: pins.clone(), ..SimulationSettings::default() };
        let mut twins = Twins::of_hair(&hair, &settings);
        for _ in 0..30 {
            twins.advance(1.0 / 60.0, &Affine3A::IDENTITY);
        }
        let places: Vec<Vec3> = twins.cpu_solver.positions(0).iter().map(|p| p.xyz()).collect();
        let apart = |x: &[Vec3]| x.iter().zip(&guides.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        println!(
            "{solver:?}: {} cm on the CPU, {} cm on the GPU",
            apart(&places),
            apart(&twins.on_gpu(0, places.len()))
        );
        assert_eq!(places, guides.positions, "{solver:?}");
        assert_eq!(twins.on_gpu(0, places.len()), guides.positions, "{solver:?}");
        let (on_cpu, on_gpu) = (twins.cpu_solver.measure(), twins.gpu_solver.measure().unwrap());
        assert!(on_cpu.speed_max == 0.0 && on_gpu.speed_max == 0.0, "{solver:?}: {on_cpu:?} {on_gpu:?}");
    }
}
