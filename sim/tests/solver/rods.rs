//! What rods promise: statics that no step, iteration or resolution changes, and dynamics that keep what is to be kept.

use glam::{Affine3A, Vec4Swizzles};
use lorelei_core::binding::Tie;
use lorelei_core::simulation::{SimulationSettings, Solver};
use lorelei_sim::CpuSolver;
use lorelei_sim::laws::scenes::{ball_field, draped};
use lorelei_sim::laws::statics::{apart, cantilevers, strand_in_wind};
use lorelei_sim::laws::{On, Under, free, rest};

const UNDER: Under<'static> = Under { on: &On::Cpu, solver: Solver::Rods };

#[test]
fn a_cantilever_droops_as_the_elastica_at_any_stiffness_resolution_and_step() {
    for row in cantilevers(&UNDER).unwrap() {
        println!("{}: {} %", row.scene, row.value);
        // Half of the bound. Measured: at most 0.55 %, with 16 vertices and a stiffness of 3 cm.
        assert!(row.value < 1.5, "{row:?}");
    }
}

#[test]
fn every_kind_of_hair_rests_without_creeping_for_ten_minutes() {
    for row in rest::ten_minutes(&UNDER).unwrap() {
        assert!(row.holds(), "{row:?}");
    }
}

#[test]
fn what_the_wind_holds_is_the_same_with_a_quarter_of_the_vertices() {
    let error = apart(&strand_in_wind(&UNDER, 16).unwrap(), &strand_in_wind(&UNDER, 65).unwrap());
    println!("{error} % of the length");
    assert!(error < 2.0, "{error} % of the length");
}

#[test]
fn a_free_strand_keeps_its_angular_momentum_and_gains_no_energy() {
    for row in free::whip(&UNDER).unwrap() {
        println!("{}: {} {}", row.law, row.value, row.unit);
        assert!(row.holds(), "{row:?}");
    }
}

#[test]
fn what_is_tied_stays_while_the_rest_swings() {
    let guides = draped(12, 32, 30.0, 0.0);
    let run = |tied: f32| {
        let mut solver = CpuSolver::new(&[&guides], Some(&ball_field()), &SimulationSettings::default());
        solver.set_ties(0, &vec![Tie::up_to(tied); guides.n_guides()]);
        let mut farthest = [0.0_f32; 2];
        for frame in 1..90 {
            let pose = Affine3A::from_rotation_y(0.5 * (std::f32::consts::TAU * frame as f32 / 45.0).sin());
            solver.set_head_pose(&pose);
            solver.advance(1.0 / 60.0);
            for (idx, x) in solver.positions(0).iter().enumerate() {
                let away = x.xyz().distance(pose.transform_point3(guides.positions[idx]));
                let half = usize::from(idx % 32 > 18);
                farthest[half] = farthest[half].max(away);
            }
        }
        farthest
    };
    let (tied, loose) = (run(0.6), run(0.0));
    println!("tied {tied:?}, loose {loose:?}");
    assert!(tied[0] < 1.0 && tied[1] > 3.0 && loose[0] > 3.0, "tied {tied:?}, loose {loose:?}");
}
