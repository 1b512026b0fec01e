//! A hair mesh's own chains, and every strand, under the laws that guides have.

use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4, Vec4Swizzles};
use lorelei_core::binding::bind_layer;
use lorelei_core::groom::{Layer, Source};
use lorelei_core::hair_mesh::{HairMesh, HairMeshLayer};
use lorelei_core::look::Choice;
use lorelei_core::motion::Motion;
use lorelei_core::moved::MovedHair;
use lorelei_core::simulation::{Moved, SimulationSettings, Solver};
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_sim::laws::scenes::{RADIUS, ball_field, draped};
use lorelei_sim::{CpuSolver, GpuSolver, Pull};

/// A strip of quads over the ball whose columns hang as the guides of [`draped`] do.
fn mesh() -> HairMesh {
    const N_LAYERS: u32 = 7;
    let columns = draped(8, N_LAYERS, 18.0, 0.0);
    let column = |i: usize, k: usize| columns.guide(i)[k];
    let layer = |k: u32| {
        let k = k as usize;
        let positions = (0..8).flat_map(|i| {
            let p = column(i, k);
            [p, p + Vec3::new(0.4, 0.1, 0.9)]
        });
        // Half of the bundles are lower.
        let faces = (0..4).map(|i| {
            let first = 4 * i as u32;
            (k < 4 || i % 2 == 0).then(|| vec![first, first + 1, first + 3, first + 2])
        });
        HairMeshLayer { positions: positions.collect(), faces: faces.collect(), pinned: Vec::new() }
    };
    HairMesh { layers: (0..N_LAYERS).map(layer).collect() }
}

pub fn layer() -> Layer {
    let layer = Layer::new("hair", Source::HairMesh(Arc::new(mesh())));
    Layer { n_strands: 60, vertices_per_strand: 16, tied: 0.1, ..layer }
}

fn frames(moved: Moved, solver: Solver, mut look: impl FnMut(&CpuSolver, Option<Vec<Vec4>>)) -> MovedHair {
    let (layer, field) = (layer(), ball_field());
    let binding = bind_layer(&layer, None);
    let settings = SimulationSettings { solver, moved, ..SimulationSettings::default() };
    let hair = [MovedHair::new(moved, &layer, &binding, Some(&field))];
    let gpu = Gpu::headless().unwrap();
    let library = ShaderLibrary::embedded();
    let mut on_gpu = GpuSolver::of_hair(&gpu, &library, &hair, Some(&field), &settings).unwrap();
    let mut on_cpu = CpuSolver::of_hair(&hair, Some(&field), &settings);
    look(&on_cpu, Some(on_gpu.read_positions(0).unwrap()));
    for frame in 1..=60 {
        let pose = Motion::Shake.pose(frame as f32 / 60.0, Vec3::NEG_Y * 8.0);
        on_cpu.set_head_pose(&pose);
        on_cpu.advance(1.0 / 60.0);
        on_gpu.set_head_pose(&pose);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        on_gpu.advance(&mut encoder, 1.0 / 60.0).unwrap();
        gpu.queue.submit([encoder.finish()]);
        // Of the first frames only: rounding grows in hair that is shaken.
        look(&on_cpu, (frame <= 6).then(|| on_gpu.read_positions(0).unwrap()));
    }
    let [hair] = hair;
    hair
}

#[test]
fn guides_follow_the_chains_of_a_hair_mesh_and_rest_where_they_were_modelled() {
    for solver in [Solver::Rods, Solver::Chains] {
        let binding = bind_layer(&layer(), None);
        let at_rest = binding.guides.positions.clone();
        let (mut n_looks, mut farthest, mut moved_far) = (0, 0.0_f32, 0.0_f32);
        let mut length_error = 0.0_f32;
        let hair = frames(Moved::Mesh, solver, |cpu, gpu| {
            let x = cpu.positions(0);
            assert_eq!(x.len(), at_rest.len());
            if n_looks == 0 {
                let apart = x.iter().zip(&at_rest).map(|(a, b)| a.xyz().distance(*b)).fold(0.0, f32::max);
                assert!(apart < 1e-4, "{apart} cm from where the mesh has its guides");
            }
            let gpu = gpu.into_iter().flatten();
            farthest = x.iter().zip(gpu).map(|(a, b)| a.xyz().distance(b.xyz())).fold(farthest, f32::max);
            moved_far = x.iter().zip(&at_rest).map(|(a, b)| a.xyz().distance(*b)).fold(moved_far, f32::max);
            length_error = length_error.max(cpu.measure().length_error_rms);
            n_looks += 1;
        });
        assert_eq!(hair.curves.n_vertices, 8, "seven layers, and the way out of the scalp");
        assert!(farthest < 5e-4, "{solver:?}: twins are {farthest} cm apart");
        assert!(moved_far > 2.0, "{solver:?}: the hair was shaken by {moved_far} cm only");
        let most = if solver == Solver::Rods { 1e-4 } else { 0.01 };
        assert!(length_error < most, "{solver:?}: {length_error}");
    }
}

#[test]
fn a_rope_takes_its_guides_along_and_keeps_their_distances_from_it() {
    let binding = bind_layer(&layer(), None);
    let at_rest = binding.guides.positions.clone();
    let n = binding.guides.n_vertices as usize;
    let (mut n_looks, mut farthest, mut moved_far, mut apart) = (0, 0.0_f32, 0.0_f32, 0.0_f32);
    let width = |x: &[Vec3], k: usize| x[k].distance(x[n + k]);
    let hair = frames(Moved::Rope, Solver::Rods, |cpu, gpu| {
        let x: Vec<Vec3> = cpu.positions(0).iter().map(|p| p.xyz()).collect();
        if n_looks == 0 {
            let off = x.iter().zip(&at_rest).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(off < 1e-4, "{off} cm from where the mesh has its guides");
        }
        let gpu = gpu.into_iter().flatten();
        farthest = x.iter().zip(gpu).map(|(a, b)| a.distance(b.xyz())).fold(farthest, f32::max);
        moved_far = x.iter().zip(&at_rest).map(|(a, b)| a.distance(*b)).fold(moved_far, f32::max);
        // Two guides of one bundle lie side by side on one rope.
        apart = (0..n).map(|k| (width(&x, k) - width(&at_rest, k)).abs()).fold(apart, f32::max);
        n_looks += 1;
    });
    assert_eq!(hair.curves.n_guides(), 2, "bundles that lie against each other are one");
    assert!(farthest < 1e-3, "twins are {farthest} cm apart");
    assert!(moved_far > 2.0, "the hair was shaken by {moved_far} cm only");
    assert!(apart < 0.05, "guides of a rope came {apart} cm nearer or farther");
}

#[test]
fn every_strand_moves_from_where_it_is_drawn_and_keeps_its_length() {
    let (mut n_looks, mut farthest, mut length_error, mut deepest) = (0, 0.0_f32, 0.0_f32, 0.0_f32);
    let field = ball_field();
    let mut begun: Vec<Vec4> = Vec::new();
    let hair = frames(Moved::Strands, Solver::Rods, |cpu, gpu| {
        if n_looks == 0 {
            begun = cpu.positions(0).to_vec();
        }
        let gpu = gpu.into_iter().flatten();
        let apart = cpu.positions(0).iter().zip(gpu).map(|(a, b)| a.distance(b));
        farthest = apart.fold(farthest, f32::max);
        let measure = cpu.measure();
        length_error = length_error.max(measure.length_error_max);
        deepest = deepest.max(measure.penetration_max_cm);
        n_looks += 1;
    });
    let apart = begun.iter().zip(&hair.curves.positions).map(|(a, b)| a.xyz().distance(*b)).fold(0.0, f32::max);
    assert!(apart < 1e-5 && hair.curves.n_guides() == 60, "{apart}");
    assert!(farthest < 5e-4, "twins are {farthest} cm apart");
    assert!(length_error < 1e-4, "{length_error}");
    assert!(deepest < 0.1, "{deepest} cm in a head of {RADIUS} cm; {:?}", field.n);
}

#[test]
fn a_state_that_is_put_back_shows_the_guides_that_it_was_read_with() {
    for (moved, nearest) in [(Moved::Mesh, 0.02), (Moved::Rope, 0.5)] {
        put_back(moved, nearest);
    }
}

/// `nearest`: how near guides come to where they were, when curves are found again from guides alone.
fn put_back(moved: Moved, nearest: f32) {
    let (layer, field) = (layer(), ball_field());
    let hair = [MovedHair::new(moved, &layer, &bind_layer(&layer, None), Some(&field))];
    let settings = SimulationSettings { moved, ..SimulationSettings::default() };
    let gpu = Gpu::headless().unwrap();
    let library = ShaderLibrary::embedded();
    let mut cpu = CpuSolver::of_hair(&hair, Some(&field), &settings);
    let pose = Affine3A::from_rotation_y(0.4);
    cpu.set_head_pose(&pose);
    for _ in 0..10 {
        cpu.advance(1.0 / 60.0);
    }
    let mut on_gpu = GpuSolver::of_hair(&gpu, &library, &hair, Some(&field), &settings).unwrap();
    assert!(on_gpu.write_state(&cpu.read_state()));
    let apart = |a: &[Vec4], b: &[Vec4]| a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(apart(cpu.positions(0), &on_gpu.read_positions(0).unwrap()) < 1e-6);
    // Where guides were kept and nothing else, the chains are found again.
    let shown: Vec<Vec3> = cpu.positions(0).iter().map(|p| p.xyz()).collect();
    let curves = hair[0].curves_of(&shown);
    let mut again = CpuSolver::of_hair(&hair, Some(&field), &settings);
    again.set_head_pose(&pose);
    again.reset();
    again.set_state(0, &curves, &curves);
    let off = apart(cpu.positions(0), again.positions(0));
    assert!(off < nearest, "{moved:?}: {off} cm");
}

#[test]
fn whatever_is_moved_comes_to_the_hand_that_holds_it() {
    for &moved in Moved::ALL {
        let (layer, field) = (layer(), ball_field());
        let hair = [MovedHair::new(moved, &layer, &bind_layer(&layer, None), Some(&field))];
        let curves = &hair[0].curves;
        let settings = SimulationSettings { moved, ..SimulationSettings::default() };
        let gpu = Gpu::headless().unwrap();
        let library = ShaderLibrary::embedded();
        let mut on_gpu = GpuSolver::of_hair(&gpu, &library, &hair, Some(&field), &settings).unwrap();
        let mut on_cpu = CpuSolver::of_hair(&hair, Some(&field), &settings);
        // Two thirds along the curve that rests the farthest to the right.
        let n = curves.n_vertices as usize;
        let x = |g: usize| curves.positions[g * n + 2 * n / 3].x;
        let rightmost = (0..curves.n_guides()).max_by(|a, b| x(*a).total_cmp(&x(*b))).unwrap();
        let vertex_idx = rightmost * n + 2 * n / 3;
        let held = Pull::of_vertex(curves, vertex_idx).unwrap();
        let hand = held.rest + Vec3::new(2.0, 2.0, 0.0);
        let shown = on_cpu.positions(0).to_vec();
        let (mut stretched, mut farthest) = (0.0_f32, 0.0_f32);
        for frame in 0..60 {
            let pull = Some(Pull { hand, radius: 4.0, ..held });
            on_cpu.set_pull(pull);
            on_cpu.advance(1.0 / 60.0);
            stretched = stretched.max(on_cpu.measure().length_error_max);
            on_gpu.set_pull(pull);
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            on_gpu.advance(&mut encoder, 1.0 / 60.0).unwrap();
            gpu.queue.submit([encoder.finish()]);
            if frame < 6 {
                let twin = on_gpu.read_positions(0).unwrap();
                let apart = on_cpu.positions(0).iter().zip(&twin).map(|(a, b)| a.distance(*b));
                farthest = apart.fold(farthest, f32::max);
            }
        }
        let away = on_gpu.read_curves(0).unwrap()[vertex_idx].xyz().distance(hand);
        let moved_far = on_cpu.positions(0).iter().zip(&shown).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        let name = moved.info().name;
        println!(
            "{name}: {away} cm from the hand, stretched {stretched}, moved {moved_far}, twins {farthest} cm apart"
        );
        // The ropes of this mesh are short: they bend less.
        assert!(away < 1.2, "{name}: {away} cm from the hand");
        assert!(moved_far > 1.5 && moved_far < 20.0, "{name}: what is drawn moved by {moved_far} cm");
        assert!(stretched < 1e-4, "{name}: {stretched}");
        assert!(farthest < 1e-3, "{name}: twins are {farthest} cm apart");
        let all = on_gpu.read_positions(0).unwrap();
        assert!(all.iter().all(|p| p.is_finite()) && on_cpu.measure().n_not_finite == 0, "{name}");
    }
}
