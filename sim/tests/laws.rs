//! What must hold for any groom and any head movement.

use glam::{Affine3A, Quat, Vec3};
use lorelei_core::motion::{HeadPose, Motion};
use lorelei_core::simulation::SimulationSettings;
use lorelei_sim::CpuSolver;

use crate::grooms::{ball_field, draped};

const PIVOT: Vec3 = Vec3::new(0.0, -8.0, -1.0);

#[test]
fn trace() {
    let field = ball_field();
    for (name, guides) in [
        ("straight", draped(64, 32, 35.0, 0.0)),
        ("curly", draped(64, 32, 25.0, 0.5)),
        ("short", draped(64, 16, 8.0, 0.0)),
    ] {
        for (motion, wind) in [
            (Motion::None, 0.0),
            (Motion::Turn, 0.0),
            (Motion::Nod, 0.0),
            (Motion::Shake, 0.0),
            (Motion::None, 300.0),
            (Motion::None, 1000.0),
        ] {
            let settings = SimulationSettings { wind_speed: wind, ..Default::default() };
            let mut solver = CpuSolver::new(&[&guides], Some(&field), &settings);
            println!("{name} {motion:?} wind {wind}");
            for frame in 1..=360 {
                let t = frame as f32 / 60.0;
                solver.set_head_pose(&motion.pose(t, PIVOT));
                solver.advance(1.0 / 60.0);
                let m = solver.measure();
                if frame % 24 == 0 {
                    println!(
                        "  t {t:.1} rms {:.6} max {:.5} pen {:.3} speed {:.4} energy {:.2} from rest {:.4} nan {}",
                        m.length_error_rms,
                        m.length_error_max,
                        m.penetration_max_cm,
                        m.speed_max,
                        m.kinetic_energy,
                        m.from_rest_rms_cm,
                        m.n_not_finite
                    );
                }
            }
        }
    }
}
