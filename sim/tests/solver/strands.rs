//! Strands between guides that move keep out of the head.

use glam::{Affine3A, Vec3, Vec4Swizzles};
use lorelei_core::binding::{LayerBinding, bind_layer};
use lorelei_core::distance_field::DistanceField;
use lorelei_core::generate::{Pose, generate};
use lorelei_core::groom::{Head, Layer, Source};
use lorelei_core::guides::GuideSet;
use lorelei_core::mesh::TriMesh;
use lorelei_core::motion::Motion;
use lorelei_core::simulation::{Interpolated, SimulationSettings};
use lorelei_core::strands::Strands;
use lorelei_sim::CpuSolver;
use lorelei_sim::laws::scenes::{RADIUS, ball_field, draped};

fn ball() -> Head {
    Head::new("ball", TriMesh::ball(RADIUS))
}

/// A head of few guides, so that strands between them are far from each.
fn groom() -> (Layer, LayerBinding) {
    let GuideSet { n_vertices, positions } = draped(40, 24, 25.0, 0.0);
    let n_guides = positions.len() as u32 / n_vertices;
    let offsets = (0..=n_guides).map(|g| g * n_vertices).collect();
    let guides = Strands { points: positions, offsets, ..Strands::default() };
    let mut layer = Layer::new("hair", Source::Guides(guides.into()));
    (layer.n_strands, layer.vertices_per_strand) = (1500, 24);
    layer.style.clear();
    let binding = bind_layer(&layer, Some(&ball()));
    (layer, binding)
}

/// How deep strands are, centimetres: the deepest, and the mean over all vertices.
fn depth(strands: &Strands, head_from_world: &Affine3A, field: &DistanceField) -> (f32, f32) {
    let depths = strands.points.iter().map(|&p| (-field.sample(head_from_world.transform_point3(p))).max(0.0));
    let (deepest, sum) = depths.fold((0.0_f32, 0.0), |(most, sum), depth| (most.max(depth), sum + depth));
    (deepest, sum / strands.points.len() as f32)
}

#[test]
fn strands_between_moved_guides_keep_out_of_the_head() {
    let field = ball_field();
    let (layer, binding) = groom();
    let settings = SimulationSettings::default();
    let at_rest =
        generate(&binding, &layer, &binding.guides.positions, &Pose { field: Some(&field), ..Pose::default() });
    for motion in [Motion::Shake, Motion::Nod] {
        let mut solver = CpuSolver::new(&[&binding.guides], Some(&field), &settings);
        let mut worst = [(0.0_f32, 0.0_f32); 3];
        let mut settled = [(0.0_f32, 0.0_f32); 3];
        for frame in 0..180 {
            let t = frame as f32 / 60.0;
            let world_from_head = if t < 1.5 { motion.pose(t, Vec3::NEG_Y * 8.0) } else { Affine3A::IDENTITY };
            solver.set_head_pose(&world_from_head);
            solver.advance(1.0 / 60.0);
            if frame % 6 != 5 {
                continue;
            }
            let guides: Vec<Vec3> = solver.positions(0).iter().map(|x| x.xyz()).collect();
            let choices = [Interpolated::Free, Interpolated::Pushed, Interpolated::SingleGuide];
            for (i, interpolated) in choices.into_iter().enumerate() {
                let pose =
                    Pose { world_from_head, field: Some(&field), interpolated: Some(interpolated), ..Pose::default() };
                let strands = generate(&binding, &layer, &guides, &pose);
                assert_eq!(strands.n_points(), at_rest.n_points());
                let now = depth(&strands, &world_from_head.inverse(), &field);
                worst[i] = (worst[i].0.max(now.0), worst[i].1.max(now.1));
                settled[i] = now;
            }
        }
        println!("{motion:?}: free, pushed, one guide: deepest and mean {worst:?}, settled {settled:?}");
        assert!(worst[0].0 > 0.3, "the free strands keep out by themselves: the test shows nothing");
        assert!(worst[1].0 < 0.4 && worst[2].0 < 0.4, "{motion:?}: {worst:?}");
        assert!(settled[1].0 < 0.1 && settled[2].0 < 0.1, "{motion:?}: {settled:?}");
    }
}

#[test]
fn at_rest_a_strand_goes_with_all_of_its_guides() {
    let field = ball_field();
    let (layer, binding) = groom();
    let strands = |interpolated| {
        let pose = Pose { field: Some(&field), interpolated, ..Pose::default() };
        generate(&binding, &layer, &binding.guides.positions, &pose).points
    };
    assert_eq!(strands(Some(Interpolated::SingleGuide)), strands(None));
}
