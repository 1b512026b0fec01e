//! The laws of the grid of air, and that its twins agree.

use glam::{Affine3A, Quat, Vec3, Vec4Swizzles};
use lorelei_core::collider::{Attachment, Collider};
use lorelei_core::guides::GuideSet;
use lorelei_core::look::Switch;
use lorelei_core::simulation::SimulationSettings;
use lorelei_core::wind::{SourceKind, WindSource};
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_sim::contact::Obstacles;
use lorelei_sim::laws::scenes::{RADIUS, ball_field, draped};
use lorelei_sim::laws::wind::{around_the_head, boxed, of_air, pass, windy};
use lorelei_sim::pose::Pose;
use lorelei_sim::wind::cpu::{HairLayer, divergence_rms};
use lorelei_sim::wind::{CpuWind, WindFrame};
use lorelei_sim::{CpuSolver, GpuSolver};

const FRAME_SECS: f32 = 1.0 / 60.0;

#[test]
fn the_air_keeps_its_laws() {
    for row in of_air() {
        println!("{}, {}: {} {}", row.law, row.scene, row.value, row.unit);
        assert!(row.holds(), "{row:?}");
    }
}

#[test]
fn without_an_obstacle_the_wind_blows_through_the_head() {
    let around = around_the_head(Switch::Off);
    assert!((around.lee - 300.0).abs() < 0.1 && (around.inside - 300.0).abs() < 0.1, "{around:?}");
}

#[test]
fn hair_stops_the_wind_as_much_as_there_is_of_it() {
    let settings = windy(200.0, 16);
    // A block of hair of 16 cm.
    let positions: Vec<_> = (0..17 * 17)
        .flat_map(|i| (0..17).map(move |k| Vec3::new((i % 17) as f32, k as f32, (i / 17) as f32) - 8.0))
        .map(|p| p.extend(0.0))
        .collect();
    let inside = |g: f32| {
        let hair = HairLayer { n_vertices: 17, positions: &positions, windage: &vec![g / 4913.0; 4913], g };
        let mut wind = boxed(&settings);
        pass(&mut wind, &settings, None, &[hair], 0..60);
        wind.air().air_velocity(Vec3::ZERO).x
    };
    let (none, thin, thick) = (inside(0.0), inside(20.0), inside(600.0));
    assert!((none - 200.0).abs() < 0.1, "{none}");
    assert!(thin < 0.9 * none && thick < 0.3 * thin && thick >= 0.0, "{none} {thin} {thick}");
}

#[test]
fn a_fan_blows_along_its_axis_and_a_vortex_around_it() {
    let fan = WindSource {
        place: Vec3::X * -12.0,
        direction: Vec3::X,
        radius: 5.0,
        speed: 500.0,
        eddies: lorelei_core::wind::Eddies::default(),
        ..WindSource::default()
    };
    let mut settings = SimulationSettings { sources: vec![fan.clone()], ..windy(0.0, 32) };
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, None, &[], 0..60);
    let air = wind.air();
    let (core, aside) = (air.air_velocity(Vec3::X * -5.0), air.air_velocity(Vec3::new(-5.0, 15.0, 0.0)));
    assert!((core.x / 500.0 - 1.0).abs() < 0.15 && aside.length() < 100.0, "{core} {aside}");
    settings.sources = vec![WindSource { kind: SourceKind::Vortex, place: Vec3::ZERO, radius: 10.0, ..fan.clone() }];
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, None, &[], 0..60);
    let around = wind.air().air_velocity(Vec3::Y * 5.0);
    assert!(around.z > 250.0 && around.x.abs() < 60.0, "{around}");
    // A fan outside of the box blows in through its boundary.
    settings.sources = vec![WindSource { place: Vec3::X * -40.0, ..fan }];
    let mut wind = boxed(&settings);
    pass(&mut wind, &settings, None, &[], 0..60);
    let core = wind.air().air_velocity(Vec3::ZERO);
    assert!(core.x > 300.0, "{core}");
}

#[test]
fn a_head_that_moves_pushes_the_air_before_it() {
    let settings = windy(0.0, 16);
    let field = ball_field();
    let mut wind = boxed(&settings);
    for frame in 0..20_u32 {
        let pose = Pose { rotation: Quat::IDENTITY, translation: Vec3::X * (frame as f32 * 1.0) };
        let frame = WindFrame { pose, jumped: false, t_secs: 0.0, frame_secs: FRAME_SECS };
        wind.advance(&settings, Obstacles::new(Some(&field), &[], &settings), &[], &frame);
    }
    // The head goes 60 cm/s; air on its front goes with it, at its side it comes back.
    let (front, side) = (Vec3::X * (19.0 + RADIUS + 1.5), Vec3::new(19.0, RADIUS + 3.0, 0.0));
    let air = wind.air();
    assert!(air.air_velocity(front).x > 20.0 && air.air_velocity(side).x < 5.0);
}

#[test]
fn nonsense_leaves_numbers() {
    let mut settings = windy(f32::INFINITY, 16);
    settings.air.vorticity = f32::NAN;
    settings.air.hair_drag = f32::INFINITY;
    settings.air.n_cycles = u32::MAX;
    settings.sources = vec![WindSource { place: Vec3::NAN, speed: 1e30, ..WindSource::default() }];
    let nowhere = vec![glam::Vec4::splat(f32::NAN); 40];
    let hair = HairLayer { n_vertices: 4, positions: &nowhere, windage: &[f32::INFINITY; 40], g: f32::NAN };
    let points = [Vec3::NAN, Vec3::splat(1e30)].into_iter();
    let mut wind = CpuWind::new(points, &settings, Pose::IDENTITY);
    wind.fill(|p| if p.x > 0.0 { Vec3::NAN } else { Vec3::splat(1e30) });
    for frame_secs in [1e30, f32::NAN, -1.0, 1e-30, 0.016, 0.016] {
        let frame = WindFrame { pose: Pose::IDENTITY, jumped: false, t_secs: f64::INFINITY, frame_secs };
        wind.advance(&settings, Obstacles::new(None, &[], &settings), &[hair], &frame);
    }
    assert!(wind.air().cells().all(|(_, v)| v.is_finite()));
    // And nothing of it stays: it began with a stream of 5000 cm/s.
    let calm = windy(0.0, 16);
    pass(&mut wind, &calm, None, &[], 0..240);
    let fastest = wind.air().cells().map(|(_, v)| v.xyz().length()).fold(0.0, f32::max);
    assert!(fastest < 15.0, "{fastest} cm/s");
}

struct Twins {
    gpu: Gpu,
    on_cpu: CpuSolver,
    on_gpu: GpuSolver,
}

impl Twins {
    fn new(guides: &GuideSet, settings: &SimulationSettings) -> Self {
        let (gpu, field) = (Gpu::headless().unwrap(), ball_field());
        let on_gpu = GpuSolver::new(&gpu, &ShaderLibrary::embedded(), &[guides], Some(&field), settings).unwrap();
        Self { on_cpu: CpuSolver::new(&[guides], Some(&field), settings), on_gpu, gpu }
    }

    fn advance(&mut self, pose: &Affine3A) {
        self.on_cpu.set_head_pose(pose);
        self.on_gpu.set_head_pose(pose);
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.on_gpu.advance(&mut encoder, FRAME_SECS).unwrap();
        self.gpu.queue.submit([encoder.finish()]);
        self.on_cpu.advance(FRAME_SECS);
    }
}

fn stormy() -> SimulationSettings {
    let mut settings = windy(300.0, 24);
    settings.air.eddies.amount = 0.3;
    settings.air.gusts.strength = 0.5;
    let arm = Collider {
        ends: [Vec3::new(9.0, -8.0, 2.0), Vec3::new(14.0, -8.0, 2.0)],
        radii: [3.0, 2.0],
        ..Collider::default()
    };
    settings.colliders =
        vec![arm.clone(), Collider { attached: Attachment::World, ends: arm.ends.map(|end| -end), ..arm }];
    let fan = WindSource { place: Vec3::new(0.0, 12.0, 14.0), direction: Vec3::NEG_Z, ..WindSource::default() };
    let vortex = WindSource { kind: SourceKind::Vortex, place: Vec3::new(-12.0, 0.0, 0.0), ..WindSource::default() };
    settings.sources = vec![fan, vortex];
    settings
}

#[test]
fn the_twins_of_the_grid_agree() {
    let guides = draped(60, 12, 14.0, 0.2);
    let mut twins = Twins::new(&guides, &stormy());
    for frame in 0..6 {
        let angle = 0.05 * frame as f32;
        twins.advance(&Affine3A::from_rotation_translation(Quat::from_rotation_y(angle), Vec3::X * (10.0 * angle)));
        let (on_cpu, on_gpu) = (twins.on_cpu.air_grid().unwrap(), twins.on_gpu.air_grid().unwrap());
        assert_eq!(on_cpu.grid(), on_gpu.grid());
        let (cpu_air, gpu_air) = (on_cpu.air(), on_gpu.read_air().unwrap());
        let mut farthest = 0.0_f32;
        for ((_, a), (_, b)) in cpu_air.cells().zip(gpu_air.cells()) {
            farthest = farthest.max(a.distance(b));
        }
        // Speeds reach 600 cm/s.
        assert!(farthest < 0.5, "frame {frame}: {farthest} cm/s apart");
        let left = divergence_rms(on_gpu.grid(), &on_gpu.read_faces().unwrap());
        assert!(left < 10.0, "frame {frame}: {left} cm/s");
    }
}

#[test]
fn a_state_that_is_put_back_goes_on_as_it_did() {
    let guides = draped(40, 12, 14.0, 0.2);
    let mut twins = Twins::new(&guides, &stormy());
    let pose = |frame: u32| Affine3A::from_rotation_y(0.05 * frame as f32);
    let run = |twins: &mut Twins| {
        (3..6).for_each(|frame| twins.advance(&pose(frame)));
        (twins.on_cpu.air_grid().unwrap().air().air, twins.on_gpu.air_grid().unwrap().read_air().unwrap().air)
    };
    (0..3).for_each(|frame| twins.advance(&pose(frame)));
    let (on_cpu, on_gpu) = (twins.on_cpu.read_state(), twins.on_gpu.read_state().unwrap());
    let first = run(&mut twins);
    assert!(twins.on_cpu.write_state(&on_cpu) && twins.on_gpu.write_state(&on_gpu));
    assert!(run(&mut twins) == first, "in the same solver");
    let mut others = Twins::new(&guides, &stormy());
    assert!(others.on_cpu.write_state(&on_cpu) && others.on_gpu.write_state(&on_gpu));
    assert!(run(&mut others) == first, "in another");
}

#[test]
fn the_same_inputs_give_the_same_air_on_the_gpu() {
    let guides = draped(40, 12, 14.0, 0.2);
    let run = || {
        let mut twins = Twins::new(&guides, &stormy());
        for frame in 0..3 {
            twins.advance(&Affine3A::from_rotation_y(0.05 * frame as f32));
        }
        // A reset begins again at the time 0.
        twins.on_gpu.set_head_pose(&Affine3A::IDENTITY);
        twins.on_gpu.reset();
        for frame in 0..3 {
            twins.advance(&Affine3A::from_rotation_y(0.05 * frame as f32));
        }
        twins.on_gpu.air_grid().unwrap().read_air().unwrap().air
    };
    assert_eq!(run(), run());
}
